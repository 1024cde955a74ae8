"""What follows from a program alone, or from another whole value, is found once."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

Whole = TypeVar("Whole")
Found = TypeVar("Found")

#: Values remembered by each function.
MOST = 8


def once(function: Callable[[Whole], Found]) -> Callable[[Whole], Found]:
    """Remember what a function has found of the last few programs, or of other values that never
    change. They are told apart by identity, and kept, so that none takes the place of another."""
    known: dict[int, tuple[Whole, Found]] = {}

    @wraps(function)
    def find(whole: Whole) -> Found:
        try:
            return known[id(whole)][1]
        except KeyError:
            pass
        found = function(whole)
        known[id(whole)] = whole, found
        for old in list(known)[:-MOST]:
            known.pop(old, None)
        return found

    return find
