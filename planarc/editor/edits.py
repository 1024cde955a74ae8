"""The lines of a text that differ from another edition of it, as edits."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import SequenceMatcher

from planarc.catalog.format.formatter import format_source
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.editor.texts import Text


class Edit(Data):
    span: Span
    text: str


def formatted(text: Text) -> tuple[Edit, ...] | None:
    """What `planarc fmt` changes; None where the text cannot be parsed."""
    try:
        new = format_source(text.source)
    except PlanarcError:
        return None
    return tuple(_differences(text, new))


def _differences(text: Text, new: str) -> Iterator[Edit]:
    before, after = text.source.text.splitlines(True), new.splitlines(True)
    places = [0]
    for line in before:
        places.append(places[-1] + len(line))
    for tag, a, b, c, d in SequenceMatcher(None, before, after, False).get_opcodes():
        if tag != "equal":
            yield Edit(Span(text.source, places[a], places[b]), "".join(after[c:d]))
