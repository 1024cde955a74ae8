"""The step that all eliminations on plain numbers share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def clear(
    rows: Iterable[list[float]], pivot: Sequence[float], column: int, others: Sequence[int]
) -> None:
    """Take multiples of the pivot row from rows, so that they lose the unknown of `column`;
    only the columns `others` are computed."""
    size = pivot[column]
    for row in rows:
        if row[column] != 0.0:
            factor = row[column] / size
            for j in others:
                row[j] -= factor * pivot[j]
