"""Writes the handbook: all classes on one page that needs no network.

In:   ClassPage   one for each class, parents before children
Out:  str         HTML: a tree of all classes, and a section for each, of which one is shown

Which section is shown is decided by the style sheet alone (`:target`), so a link to
`handbook.html#A.B` opens the class `A.B`; one script, known by its hash, searches the tree, opens
it at the class, shows it in motion and writes its source text, which is packed. Everything that a
library says is escaped, by the template, `page.html`, or for its colours by `code`; a content
security policy keeps other scripts from running all the same.
"""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from jinja2 import BytecodeCache, Environment, FileSystemLoader, StrictUndefined
from jinja2.bccache import Bucket
from markupsafe import Markup

from planarc.catalog.handbook.code import colored
from planarc.catalog.handbook.formula import formula
from planarc.catalog.handbook.icon import icon_svg
from planarc.catalog.handbook.motion import Motions
from planarc.catalog.handbook.pages import ClassPage, Link
from planarc.catalog.handbook.prose import clean
from planarc.core import cache
from planarc.core.diagnostic import usage_error

_HERE = Path(__file__).parent


def write_handbook(
    path: Path, title: str, pages: Sequence[ClassPage], motions: Motions | None = None
) -> None:
    """Write the page. Raises UsageError where the file cannot be written."""
    try:
        path.write_text(render_handbook(title, pages, motions), encoding="utf-8", newline="\n")
    except OSError as reason:
        message = f"cannot write the handbook `{path}`: {reason.strerror or reason}"
        raise usage_error("V103", message) from None


def render_handbook(title: str, pages: Sequence[ClassPage], motions: Motions | None = None) -> str:
    """The page as text."""
    motions = motions or Motions()
    known = {page.name: page for page in pages}
    inner = {child for page in pages for child in page.children}
    roots = [page for page in pages if page.name not in inner]
    sources = {page.name: colored(page.source) for page in pages if page.source}
    templates = Environment(
        loader=FileSystemLoader(_HERE),
        autoescape=True,
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        bytecode_cache=_Kept(),
    )
    templates.filters.update(
        clean=lambda text: Markup(clean(text, known)),
        colored=lambda text: Markup(colored(text)),
        formula=lambda text: Markup(formula(text)),
        icon=lambda page, size: Markup(icon_svg(page.icon, page.name, size)),
        last_name=_last,
        outer=_outer,
    )
    return templates.get_template("page.html").render(
        title=title,
        script=Markup(script := (_HERE / "page.js").read_text(encoding="utf-8")),
        digest=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
        styles=Markup((_HERE / "page.css").read_text(encoding="utf-8")),
        pages=pages,
        roots=roots,
        tree=[step for root in roots for step in _tree(root, known)],
        known=known,
        examples=_examples(pages),
        shown=motions.shown,
        pictures=_packed([picture.decode() for picture in motions.pictures]),
        sources=_packed([*sources.values()]),
        numbers={name: number for number, name in enumerate(sources)},
    )


def _packed(texts: Sequence[str]) -> str:
    """Texts as the page's script unpacks them: a fifth of their size, for there are many."""
    listed = json.dumps(texts, ensure_ascii=False)
    return base64.b64encode(zlib.compress(listed.encode(), 9)).decode() if texts else ""


class _Kept(BytecodeCache):
    """The template as it was compiled before."""

    def load_bytecode(self, bucket: Bucket) -> None:
        known = cache.load("pages", cache.key(bucket.key, bucket.checksum))
        if known is not None:
            bucket.bytecode_from_string(known)

    def dump_bytecode(self, bucket: Bucket) -> None:
        key = cache.key(bucket.key, bucket.checksum)
        cache.store("pages", key, bucket.bytecode_to_string())


def _examples(pages: Sequence[ClassPage]) -> dict[str, list[Link]]:
    """The examples in which each class is a component."""
    found: dict[str, list[Link]] = {}
    for page in pages:
        if page.is_example:
            rows = (row for _, rows in page.tables for row in rows)
            for target in dict.fromkeys(row.type.target for row in rows):
                found.setdefault(target or "", []).append(Link(_last(page.name), page.name))
    return found


def _tree(root: ClassPage, known: Mapping[str, ClassPage]) -> Iterator[tuple[str, ClassPage]]:
    """The steps through nested classes: `begin` and `end` of those that hold others, and `leaf`.

    Iterative: packages may lie deep.
    """
    stack = [("begin", root)]
    while stack:
        step, page = stack.pop()
        children = [known[name] for name in page.children if name in known]
        if step == "begin" and children:
            stack.append(("end", page))
            stack.extend(("begin", child) for child in reversed(children))
        yield (step if children else "leaf"), page


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _outer(name: str) -> list[Link]:
    """The packages around a class, from the outermost to the innermost."""
    names = name.split(".")
    return [Link(names[i], ".".join(names[: i + 1])) for i in range(len(names) - 1)]
