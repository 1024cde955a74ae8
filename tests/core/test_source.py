"""Places survive the way through the disk."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

from planarc.core import plain
from planarc.core.source import NOWHERE, Source, Span


def test_no_place_stays_the_one_that_there_is() -> None:
    """`is NOWHERE` is asked of what was compiled by an earlier process, too."""
    assert pickle.loads(pickle.dumps([NOWHERE]))[0] is NOWHERE
    assert plain.loads(pickle.dumps([NOWHERE]))[0] is NOWHERE
    assert copy.deepcopy(NOWHERE) is NOWHERE


def test_what_is_made_from_no_place_is_an_ordinary_one() -> None:
    moved = pickle.loads(pickle.dumps(NOWHERE._replace(end=1)))
    assert type(moved) is Span and moved.end == 1


def test_a_place_keeps_its_text() -> None:
    span = pickle.loads(pickle.dumps(Span(Source("a", "one two"), 4, 7)))
    assert span.text == "two"


def test_places_read_one_by_one_are_the_same(tmp_path: Path) -> None:
    """Warnings and programs are remembered apart from each other, and name the same places."""
    file = tmp_path / "a.pmo"
    file.write_text("one two", encoding="utf-8")
    read = Span(Source("a.pmo", "one two", file), 4, 7)
    first, second = (pickle.loads(pickle.dumps(read)) for _ in range(2))
    assert first == second == read and len({first, second, read}) == 1
    changed = Span(Source("a.pmo", "one too", file), 4, 7)
    assert read != changed and first != changed
    assert read != Span(Source("b.pmo", "one two", file), 4, 7)
