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
from itertools import compress
from pathlib import Path
from string import Template

from planarc.catalog.handbook.code import colored
from planarc.catalog.handbook.icon import icon_svg
from planarc.catalog.handbook.pages import ClassPage, Link, Row
from planarc.catalog.handbook.prose import clean
from planarc.core.diagnostic import usage_error

_HERE = Path(__file__).parent
_LARGE, _SMALL = 150, 36  # pixels
_EXAMPLES = ".Examples."  # the package of a library in which its models to run stand


def write_handbook(path: Path, title: str, pages: Sequence[ClassPage]) -> None:
    """Write the page. Raises UsageError where the file cannot be written."""
    try:
        path.write_text(render_handbook(title, pages), encoding="utf-8", newline="\n")
    except OSError as reason:
        message = f"cannot write the handbook `{path}`: {reason.strerror or reason}"
        raise usage_error("V103", message) from None


def render_handbook(title: str, pages: Sequence[ClassPage]) -> str:
    """The page as text."""
    known = {page.name: page for page in pages}
    inner = {child for page in pages for child in page.children}
    roots = [page for page in pages if page.name not in inner]
    examples = _examples(pages)
    # The last section is shown where none is asked for: that of the only root, or a list.
    alone = roots[0] if len(roots) == 1 else None
    sections = [_section(page, known, examples) for page in pages if page is not alone]
    if alone is not None:
        sections.append(_section(alone, known, examples, is_start=True))
    else:
        links = "".join(f"<li>{_link(Link(p.name, p.name), known)}</li>" for p in roots)
        start = f"<h1>{html.escape(title)}</h1><ul>{links}</ul>"
        sections.append(f'<section class="start">{start}</section>')
    return Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(title),
        styles=(_HERE / "page.css").read_text(encoding="utf-8"),
        tree="".join(_tree(page, known) for page in roots),
        sections="".join(sections),
    )


def _examples(pages: Sequence[ClassPage]) -> dict[str, list[str]]:
    """The examples in which each class is a component."""
    found: dict[str, list[str]] = {}
    for page in pages:
        if _EXAMPLES in page.name:
            rows = (row for _, rows in page.tables for row in rows)
            for target in dict.fromkeys(row.type.target for row in rows):
                found.setdefault(target or "", []).append(page.name)
    return found


def _tree(root: ClassPage, known: Mapping[str, ClassPage]) -> str:
    """The classes as nested lists that can be opened. Iterative: packages may lie deep."""
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


def _section(
    page: ClassPage,
    known: Mapping[str, ClassPage],
    examples: Mapping[str, Sequence[str]],
    is_start: bool = False,
) -> str:
    start = ' class="start"' if is_start else ""
    parts = [
        f'<section id="{html.escape(page.name)}"{start}>',
        _path(page, known),
        '<div class="head">',
        icon_svg(page.icon, page.name, _LARGE) if page.icon else "",
        f"<div><h1>{html.escape(page.name.rpartition('.')[2])}</h1>",
        f'<p class="comment"><span class="kind">{html.escape(page.kind)}</span> '
        f"{html.escape(page.comment)}</p></div></div>",
        _head(page),
        f'<div class="info">{clean(page.info, known)}</div>' if page.info else "",
        _names("Extends", page.bases, known),
        _names("Used in", [Link(_last(e), e) for e in examples.get(page.name, ())], known),
        _children(page, known),
        *(_table(heading, rows, known) for heading, rows in page.tables),
        _equations(page, known),
        _source(page),
        "</section>",
    ]
    return "".join(parts)


def _path(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    names = page.name.split(".")
    above = [".".join(names[: i + 1]) for i in range(len(names) - 1)]
    links = [_link(Link(name.rpartition(".")[2], name), known) for name in above]
    return f'<p class="path">{" › ".join([*links, html.escape(_last(page.name))])}</p>'


def _head(page: ClassPage) -> str:
    """Law, sign and limits; formulas keep their lines."""
    rows = "".join(
        f"<dt>{html.escape(keyword)}</dt><dd>{html.escape(text)}</dd>"
        for keyword, text in page.head
    )
    return f'<dl class="law">{rows}</dl>' if rows else ""


def _names(what: str, links: Sequence[Link], known: Mapping[str, ClassPage]) -> str:
    if not links:
        return ""
    return f"<p>{what} {', '.join(_link(link, known) for link in links)}.</p>"


def _equations(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    if not page.equations and not page.inherited:
        return ""
    others = "".join(
        f"<details><summary>from {_link(base, known)}</summary>{_pre(sections)}</details>"
        for base, sections in page.inherited
    )
    return f"<h2>Equations</h2>{_pre(page.equations)}{others}"


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _children(page: ClassPage, known: Mapping[str, ClassPage]) -> str:
    rows = []
    for child in (known[name] for name in page.children if name in known):
        icon = icon_svg(child.icon, child.name, _SMALL) if child.icon else ""
        link = _link(Link(child.name.rpartition(".")[2], child.name), known)
        rows.append(f"<tr><td>{icon}</td><td>{link}</td><td>{html.escape(child.comment)}</td></tr>")
    return f'<h2>Contents</h2><table class="contents">{"".join(rows)}</table>' if rows else ""


def _table(heading: str, rows: Sequence[Row], known: Mapping[str, ClassPage]) -> str:
    """The rows; values and units only where there are any."""
    shown = [True, True, any(r.value for r in rows), any(r.unit for r in rows), True]
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
        lines.append("".join(f"<td>{cell}</td>" for cell in compress(cells, shown)))
    names = compress(("Name", "Type", "Value", "Unit", "Description"), shown)
    lines.insert(0, "".join(f"<th>{name}</th>" for name in names))
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f"<h2>{html.escape(heading)}</h2><table>{body}</table>"


def _source(page: ClassPage) -> str:
    if not page.source:
        return ""
    summary = f"Source text <span>{html.escape(page.file)}</span>"
    # An example is its text.
    is_open = " open" if _EXAMPLES in page.name else ""
    text = _pre((page.source,))
    return f'<details class="source"{is_open}><summary>{summary}</summary>{text}</details>'


def _pre(texts: Sequence[str]) -> str:
    return "".join(f"<pre>{colored(text)}</pre>" for text in texts)


def _link(link: Link, known: Mapping[str, ClassPage]) -> str:
    if link.target in known:
        target = html.escape(link.target or "")
        return f'<a href="#{target}" title="{target}">{html.escape(link.text)}</a>'
    return html.escape(link.text)
