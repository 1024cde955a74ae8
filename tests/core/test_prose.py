"""Lists, counts and near names, as all messages word them."""

from __future__ import annotations

import pytest

from planarc.core.nearest import did_you_mean, nearest
from planarc.core.prose import both, counted, either, listed, shortened, sized, ticked


def test_lists() -> None:
    assert [listed("abc"[:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]
    assert listed("abc", "or") == "a, b or c"
    assert ticked("ab") == "`a`, `b`"
    assert both("ab") == "`a` and `b`"
    assert either("ab") == "`a` or `b`"
    assert shortened("abcd", 3) == "a, b, c and 1 more"
    assert shortened("abc", 3) == "a, b, c"
    assert sized([(3,)]) == "the size 3"
    assert sized([(3,), (2, None)]) == "the sizes 3 and 2 by any"


@pytest.mark.parametrize(
    ("number", "noun", "text"),
    [
        (0, "state", "0 states"),
        (1, "alias", "1 alias"),
        (2, "alias", "2 aliases"),
        (2, "entry", "2 entries"),
        (2, "way", "2 ways"),
    ],
)
def test_counts(number: int, noun: str, text: str) -> None:
    assert counted(number, noun) == text


def test_near_names_come_best_first_and_each_once() -> None:
    assert nearest("Jiont", ["Jont", "Joint", "Jont", "Body"]) == ["Jont", "Joint"]
    assert str(did_you_mean("Jiont", ["Jont", "Joint"])) == "did you mean `Jont` or `Joint`?"


def test_capitals_alone_are_near() -> None:
    assert nearest("PHI", ["phi", "w"]) == ["phi"]


def test_nothing_near_gives_no_hint() -> None:
    assert did_you_mean("length", ["mass", "w"]) is None
    assert did_you_mean("x", []) is None
