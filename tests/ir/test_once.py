"""What follows from a program alone is found once."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from planarc.ir.once import MOST, once


def test_each_program_is_looked_at_once_while_it_is_remembered() -> None:
    looked: list[Any] = []

    @once
    def find(program: Any) -> int:
        looked.append(program)
        return len(looked)

    programs: list[Any] = [SimpleNamespace() for _ in range(MOST + 1)]  # all equal to each other
    assert [find(p) for p in programs] == list(range(1, MOST + 2))
    assert find(programs[-1]) == MOST + 1
    assert find(programs[1]) == 2
    assert find(programs[0]) == MOST + 2  # the oldest one was forgotten
    assert [p is q for p, q in zip(looked, (*programs, programs[0]), strict=True)] == [True] * len(
        looked
    )
