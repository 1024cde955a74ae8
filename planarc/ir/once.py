"""What follows from a program alone is found once, however many runs it has."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from planarc.ir.program import Program

Found = TypeVar("Found")

#: Programs remembered by each function.
MOST = 8


def once(function: Callable[[Program], Found]) -> Callable[[Program], Found]:
    """Remember what a function has found of the last few programs. They are told apart by
    identity, and kept, so that none takes the place of another."""
    known: dict[int, tuple[Program, Found]] = {}

    @wraps(function)
    def find(program: Program) -> Found:
        entry = known.get(id(program))
        if entry is None:
            entry = (program, function(program))
            known[id(program)] = entry
            for old in list(known)[:-MOST]:
                known.pop(old, None)
        return entry[1]

    return find
