"""The step of elimination, with exact numbers."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from planarc.runtime.elimination import clear


def test_rows_lose_the_unknown_and_keep_their_solution() -> None:
    pivot: Any = [Fraction(2), Fraction(4), Fraction(8)]  # 2x + 4y = 8
    rows: Any = [[Fraction(3), Fraction(1), Fraction(7)], [Fraction(0), Fraction(5), Fraction(5)]]
    clear(rows, pivot, 0, range(3))
    assert rows == [[0, -5, -5], [0, 5, 5]]


def test_only_the_columns_asked_for_are_computed() -> None:
    rows = [[1.0, 2.0, 3.0]]
    clear(rows, [1.0, 1.0, 1.0], 0, [2])
    assert rows == [[1.0, 2.0, 2.0]]
