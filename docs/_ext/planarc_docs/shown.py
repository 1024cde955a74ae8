"""Which model shows which component in motion: an example of its library, else one of
`docs/models/`.

In:   ClassPage   of the library, as its handbook has them
Out:  Shows       for each component the model to draw, as a reader may name it to planarc
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from planarc.catalog.handbook.gather import gather
from planarc.catalog.handbook.pages import ClassPage
from planarc.cli.arguments import open_classes

MODELS = Path(__file__).parents[2] / "models"


class Shows(NamedTuple):
    """A model by its file (with its text) or its name, and the components in it."""

    model: str
    text: str
    used: frozenset[str]  # full names of its components' classes
    words: frozenset[str]  # all words of its text

    @property
    def is_file(self) -> bool:
        return self.model.endswith(".pmo")


def models_that_show(pages: Sequence[ClassPage]) -> list[Shows]:
    """The examples, small ones first, then the models of this site."""
    runnable = (p for p in pages if p.is_example and "experiment(" in p.source)
    examples = [_shows(page.name, page) for page in runnable]
    return [*sorted(examples, key=lambda s: len(s.text)), *_own()]


def find(name: str, shows: Sequence[Shows]) -> Shows | None:
    """The first model with such a component, else the first whose text names the class."""
    last = name.rpartition(".")[2]
    having = (s for s in shows if name in s.used)
    naming = (s for s in shows if last in s.words)
    return next(having, None) or next(naming, None)


def _own() -> Iterator[Shows]:
    for file in sorted(MODELS.glob("*.pmo")):
        classes, names = open_classes(str(file), None)
        text = file.read_text("utf-8")
        for page in gather(classes, names):
            yield _shows(file.name, page)._replace(text=text)


def _shows(model: str, page: ClassPage) -> Shows:
    used = {row.type.target or "" for _, rows in page.tables for row in rows}
    words = re.findall(r"\b[A-Z]\w+", re.sub(r'"[^"]*"|//.*', "", page.source))
    return Shows(model, page.source, frozenset(used), frozenset(words))
