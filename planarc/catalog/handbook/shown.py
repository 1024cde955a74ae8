"""Which model shows which component in motion: an example of its library, else one of `models/`.

In:   ClassPage   of a library
Out:  Shows       for each component the model to draw, as a reader may name it to planarc

`models/` holds small mechanisms for components that no example has.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from msgspec.structs import replace

from planarc.catalog.handbook.gather import gather
from planarc.catalog.handbook.pages import ClassPage
from planarc.core.data import Data
from planarc.flatten.library.library import Library
from planarc.request.request import Request, open_library

MODELS = Path(__file__).parent / "models"
#: What examples are called in libraries, and what makes parts that are drawn.
_EXAMPLES, _DRAWN = "Examples", "PlanarMultiBody"


class Shows(Data):
    """A model, and the components in it."""

    request: Request
    name: str  # full
    comment: str
    text: str
    used: frozenset[str]  # full names of its components' classes, and of its bases
    words: frozenset[str]  # all words of its text

    @property
    def is_file(self) -> bool:
        """True for a model of `models/`."""
        return self.request.class_name is None

    @property
    def model(self) -> str:
        """What a reader gives to planarc."""
        file = self.request.file
        return file.name if file is not None and self.is_file else self.name


def models_that_show(
    library: Library, pages: Sequence[ClassPage], asked: Request | None = None
) -> list[Shows]:
    """The examples of these pages, small ones first, then the models beside this file.

    `asked` is the request that the library was opened with.
    """
    asked = asked or Request()
    known = {page.name for page in pages}
    near = (f"{outer}.{_EXAMPLES}" for page in pages for outer in _packages(page.name))
    apart = [n for n in dict.fromkeys(near) if n not in known and library.entry(n) is not None]
    every = (*pages, *gather(library, apart))
    drawn = {_top(page.name) for page in every if any(_top(n) == _DRAWN for n in _needs(page))}
    examples = [
        _shows(Request(asked.file, page.name, asked.libraries), page)
        for page in every
        if page.kind == "model" and "experiment(" in page.source and _top(page.name) in drawn
    ]
    return [*sorted(examples, key=lambda s: len(s.text)), *_own(pages)]


def find(name: str, shows: Sequence[Shows]) -> Shows | None:
    """The model itself, the first with such a component, else the first that names the class."""
    itself = (s for s in shows if s.name == name)
    having = (s for s in shows if name in s.used)
    of_library = (s for s in shows if _top(name) in (_top(s.name), *s.words))
    naming = (s for s in of_library if name.rpartition(".")[2] in s.words)
    return next(itself, None) or next(having, None) or next(naming, None)


def _own(pages: Sequence[ClassPage]) -> Iterator[Shows]:
    """The models beside this file, for a library whose classes they name."""
    if not any(page.name == _DRAWN or page.name.startswith(f"{_DRAWN}.") for page in pages):
        return
    library, reader, _ = open_library(Request())
    for file in sorted(MODELS.glob("*.pmo")):
        for page in gather(library, library.add_file(reader(file))):
            yield replace(_shows(Request(file), page), text=file.read_text("utf-8"))


def _shows(request: Request, page: ClassPage) -> Shows:
    words = re.findall(r"\b[A-Z]\w+", re.sub(r'"[^"]*"|//.*', "", page.source))
    used = frozenset(_needs(page))
    return Shows(request, page.name, page.comment, page.source, used, frozenset(words))


def _needs(page: ClassPage) -> Iterator[str]:
    """The classes of a page's components, and those that it extends."""
    links = (*page.bases, *(row.type for _, rows in page.tables for row in rows))
    return (link.target for link in links if link.target)


def _top(name: str) -> str:
    return name.partition(".")[0]


def _packages(name: str) -> list[str]:
    """The packages around a class, the nearest first."""
    parts = name.split(".")
    return [".".join(parts[:i]) for i in range(len(parts) - 1, 0, -1)]
