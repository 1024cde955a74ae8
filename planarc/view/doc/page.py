"""Writes the handbook: all classes on one page that needs no network and runs no script.

In:   ClassPage   one for each class, parents before children
Out:  str         HTML: a tree of all classes, and a section for each, of which one is shown

Which section is shown is decided by the style sheet alone (`:target`), so a link to
`handbook.html#A.B` opens the class `A.B`. Everything that a library says is escaped;
a content security policy keeps scripts from running all the same.
"""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template

from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.view.doc.icon import icon_svg
from planarc.view.doc.pages import ClassPage, Link, Row
from planarc.view.doc.prose import clean

_HERE = Path(__file__).parent
_LARGE, _SMALL = 150, 36  # pixels


def write_handbook(path: Path, title: str, pages: Sequence[ClassPage]) -> None:
    """Write the page. Raises UsageError where the file cannot be written."""
    try:
        path.write_text(render_handbook(title, pages), encoding="utf-8", newline="\n")
    except OSError as reason:
        message = f"cannot write the handbook `{path}`: {reason.strerror or reason}"
        raise UsageError(Diagnostic("V103", message)) from None


def render_handbook(title: str, pages: Sequence[ClassPage]) -> str:
    """The page as text."""
    known = {page.name: page for page in pages}
    inner = {child for page in pages for child in page.children}
    roots = [page for page in pages if page.name not in inner]
    return Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(title),
        styles=(_HERE / "page.css").read_text(encoding="utf-8"),
        tree="".join(_tree(page, known) for page in roots),
        start="".join(f"<li>{_link(Link(p.name, p.name), known)}</li>" for p in roots),
        sections="".join(_section(page, known) for page in pages),
    )


def _tree(root: ClassPage, known: Mapping[str, ClassPage]) -> str:
    """Nested lists; what has children can be opened. Iterative: packages may lie deep."""
    out: list[str] = []
    stack: list[ClassPage | str] = [root]
    while stack:
        item = stack.pop()
        if isinstance(item, str):
            out.append(item)
            continue
        children = [known[name] for name in item.children if name in known]
        last = item.name.rpartition(".")[2]
        label = f'<a href="#{html.escape(item.name)}">{html.escape(last)}</a>'
        if not children:
            out.append(f'<div class="leaf">{label}</div>')
            continue
        is_root = " open" if item is root else ""
        out.append(f"<details{is_root}><summary>{label}</summary>")
        stack.append("</details>")
        stack.extend(reversed(children))
    return "".join(out)


def _section(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    parts = [
        f'<section id="{html.escape(page.name)}">',
        _path(page, known),
        '<div class="head">',
        icon_svg(page.icon, page.name, _LARGE) if page.icon else "",
        f"<div><h1>{html.escape(page.name.rpartition('.')[2])}</h1>",
        f'<p class="comment">{html.escape(page.comment)}</p></div></div>',
        f'<div class="info">{clean(page.info, known)}</div>' if page.info else "",
        _bases(page, known),
        _children(page, known),
        *(_table(heading, rows, known) for heading, rows in page.tables),
        f"<h2>Equations</h2>{_pre(page.equations)}" if page.equations else "",
        _source(page),
        "</section>",
    ]
    return "".join(parts)


def _path(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    names = page.name.split(".")
    above = [".".join(names[: i + 1]) for i in range(len(names) - 1)]
    links = [_link(Link(name.rpartition(".")[2], name), known) for name in above]
    return f'<p class="path">{" . ".join([*links, html.escape(page.kind)])}</p>'


def _bases(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    if not page.bases:
        return ""
    return f"<p>Extends {', '.join(_link(base, known) for base in page.bases)}.</p>"


def _children(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    rows = []
    for child in (known[name] for name in page.children if name in known):
        icon = icon_svg(child.icon, child.name, _SMALL) if child.icon else ""
        link = _link(Link(child.name.rpartition(".")[2], child.name), known)
        rows.append(f"<tr><td>{icon}</td><td>{link}</td><td>{html.escape(child.comment)}</td></tr>")
    return f'<h2>Contents</h2><table class="contents">{"".join(rows)}</table>' if rows else ""


def _table(heading: str, rows: Sequence[Row], known: Mapping[str, ClassPage]) -> str:
    lines = []
    for row in rows:
        origin = f' <span class="origin">{_link(row.origin, known)}</span>' if row.origin else ""
        cells = (
            f"<code>{html.escape(row.name)}</code>",
            _link(row.type, known),
            f"<code>{html.escape(row.value)}</code>" if row.value else "",
            html.escape(row.unit),
            html.escape(row.comment) + origin,
        )
        lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    head = "<tr><th>Name</th><th>Type</th><th>Value</th><th>Unit</th><th>Description</th></tr>"
    return f"<h2>{html.escape(heading)}</h2><table>{head}{''.join(lines)}</table>"


def _source(page: ClassPage) -> str:
    if not page.source:
        return ""
    summary = f"Source text <span>{html.escape(page.file)}</span>"
    return f'<details class="source"><summary>{summary}</summary>{_pre((page.source,))}</details>'


def _pre(texts: Sequence[str]) -> str:
    return "".join(f"<pre>{html.escape(text)}</pre>" for text in texts)


def _link(link: Link, known: Mapping[str, ClassPage]) -> str:
    if link.target in known:
        target = html.escape(link.target or "")
        return f'<a href="#{target}" title="{target}">{html.escape(link.text)}</a>'
    return html.escape(link.text)
