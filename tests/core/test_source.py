"""Places survive the way through the disk."""

from __future__ import annotations

import copy
import pickle

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
