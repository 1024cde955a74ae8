"""The pages of the libraries, from the same data as `planarc doc`.

Every component and every example of `PlanarMultiBody` has a page with a moving picture; other
classes stand together on the page of their package.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from planarc.catalog.handbook.gather import gather
from planarc.catalog.handbook.icon import icon_svg
from planarc.catalog.handbook.pages import ClassPage, Link, Row
from planarc.catalog.handbook.prose import clean
from planarc.catalog.handbook.shown import Shows, find, models_that_show
from planarc.cli.arguments import open_classes
from planarc.flatten.library.library import Library
from planarc_docs.written import code, fence, plain, table

LIBRARIES = ("PlanarMultiBody", "Modelica")
_WIDTH = 320
_PACKAGE = ("package",)


def library_pages() -> Iterator[tuple[str, str]]:
    """Names and texts of the pages."""
    books = [_Book(*open_classes(name, None), name == LIBRARIES[0]) for name in LIBRARIES]
    everywhere = {name: page for book in books for name, page in book.known.items()}
    for book in books:
        yield from book.pages(everywhere)


def has_own_page(page: ClassPage) -> bool:
    """True for what a user puts into a mechanism, or runs."""
    return page.kind in ("model", "block")


class _Book:
    """One library. `whole`: its components have pages of their own."""

    def __init__(self, library: Library, names: Sequence[str], whole: bool) -> None:
        pages = gather(library, names)
        # A class within a model is a part of that model, whose source shows it.
        inner = {child for p in pages if p.kind not in _PACKAGE for child in p.children}
        self.known = {page.name: page for page in pages if page.name not in inner}
        self._whole = whole
        self._linked: Mapping[str, ClassPage] = self.known
        self._shows = models_that_show(library, pages) if whole else []

    def pages(self, everywhere: Mapping[str, ClassPage]) -> Iterator[tuple[str, str]]:
        """Names and texts; links lead to the classes of `everywhere`."""
        self._linked = everywhere
        for name, page in self.known.items():
            if page.kind in _PACKAGE:
                yield name, "\n".join(self._package(page))
            elif self._apart(page):
                yield name, "\n".join(self._component(page))

    def _apart(self, page: ClassPage) -> bool:
        return self._whole and has_own_page(page)

    def _package(self, page: ClassPage) -> Iterator[str]:
        inner = [self.known[n] for n in page.children if n in self.known]
        outer = page.name.rpartition(".")[0]
        if outer and not self._whole:  # in no tree of contents: each costs all pages some time
            yield "---\norphan: true\n---\n"
        yield f"{_target(page)}# {plain(_last(page.name))}\n"
        if outer:
            yield f"In {self._link(Link(outer, outer))}.\n"
        yield f"`{page.name}`: {plain(page.comment)}.\n"
        yield _info(page)
        apart = [p for p in inner if p.kind in _PACKAGE or self._apart(p)]
        yield table(
            ("class", "kind", "what it is"),
            ((self._link(Link(_last(p.name), p.name)), p.kind, plain(p.comment)) for p in inner),
        )
        if apart and self._whole:
            names = "\n".join(p.name for p in apart)
            yield f"```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{names}\n```\n"
        for found in inner:
            if found not in apart:
                yield f"{_target(found)}## {plain(_last(found.name))}\n"
                yield from self._body(found)

    def _component(self, page: ClassPage) -> Iterator[str]:
        icon = icon_svg(page.icon, page.name, 110) if page.icon else ""
        yield f"{_target(page)}# {plain(_last(page.name))}\n"
        if icon:
            yield f'<div class="icon-beside">{icon}</div>\n'
        yield from self._body(page)
        yield from self._run(page)

    def _body(self, page: ClassPage) -> Iterator[str]:
        said = plain(page.comment).rstrip(".")
        yield f"*{page.kind}* {code(page.name)}" + (f": {said}.\n" if said else "\n")
        if self._apart(page):
            yield from self._picture(page)
        for word, text in page.head:
            if word != "Check":  # for those who work on the library
                yield f"{plain(word)}\n: {_laid(text)}\n"
        yield _info(page)
        if page.bases:
            yield f"Extends {', '.join(map(self._link, page.bases))}.\n"
        for heading, rows in page.tables:
            if self._whole or heading in ("Parameters", "Connectors", "Inputs and outputs"):
                yield f"**{heading}**\n\n{self._table(rows)}"
        equations = [text for _, texts in page.inherited for text in texts] + [*page.equations]
        if equations and self._whole:
            yield fence("modelica", "\n\n".join(equations))

    def _picture(self, page: ClassPage) -> Iterator[str]:
        shown = self._shown(page)
        if shown is not None:
            alt = f"{_last(page.name)} in motion"
            yield f"```{{motion}} {shown.model}\n:width: {_WIDTH}\n:alt: {alt}\n```\n"

    def _run(self, page: ClassPage) -> Iterator[str]:
        """What a reader runs to see the same."""
        shown = self._shown(page)
        if shown is None:
            return
        yield "## Try it\n"
        if shown.is_file:
            yield f"The picture shows this model. Save it as `{shown.model}` and run it:\n"
        elif shown.model != page.name:
            name = _last(shown.model)
            yield f"The picture shows {self._link(Link(name, shown.model))}. Run it:\n"
        yield fence("console", f"$ planarc simulate {shown.model}")
        if shown.is_file or page.is_example:
            yield fence("modelica", shown.text, shown.model if shown.is_file else "")

    def _shown(self, page: ClassPage) -> Shows | None:
        return find(page.name, self._shows)

    def _table(self, rows: Iterable[Row]) -> str:
        head = ("name", "type", "value", "unit", "what it is")
        return table(head, (self._cells(row) for row in rows))

    def _cells(self, row: Row) -> tuple[str, ...]:
        origin = f" ({self._link(row.origin)})" if row.origin is not None else ""
        value = code(row.value)
        return (
            code(row.name),
            self._link(row.type),
            value,
            plain(row.unit),
            plain(row.comment) + origin,
        )

    def _link(self, link: Link) -> str:
        found = self._linked.get(link.target or "")
        if found is None:
            return plain(link.text)
        return f"[{plain(link.text)}](#{_label(found)})"


def _last(name: str) -> str:
    return name.rpartition(".")[2]


def _label(page: ClassPage) -> str:
    return f"class-{page.name.lower()}"


def _target(page: ClassPage) -> str:
    return f"({_label(page)})=\n"


def _info(page: ClassPage) -> str:
    """The library's own text: HTML, in which no mark of Markdown means anything."""
    lines = (line for line in clean(page.info, ()).splitlines() if line.strip())
    text = "\n".join(lines)  # an empty line would end the HTML
    return f"<div>\n{text}\n</div>\n" if text else ""


def _laid(text: str) -> str:
    """Lines of a law one below the other, as code."""
    return "\\\n  ".join(code(line) for line in text.splitlines())
