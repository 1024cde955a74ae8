"""Which unknowns of an underdetermined linear system to solve for, on plain numbers.

In:   a matrix G of m rows and n > m columns, a class for each column
Out:  m columns to solve for; how strongly they depend on the others

Small matrices are treated as Python lists, since a call into NumPy costs as much as
eliminating a few rows; large ones go to NumPy, which takes an eighth of the time for 160 rows.

Example: one row (3, -4), equal classes. Column 1 is solved for; the sensitivity to
column 0 is 3/4.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from planarc.ir.begin import EQUAL, GIVE_WAY
from planarc.runtime.elimination import clear

Rows: TypeAlias = Sequence[Sequence[float]]

#: Rows up to which Python is faster than NumPy.
SMALL = 6
#: Rows from which a step of an elimination is faster in NumPy.
MANY = 32


def choose_columns(g: Rows, classes: Sequence[int], never: int) -> list[int] | None:
    """Columns to solve for, by elimination with complete pivoting.

    The lowest class comes first, and gives way only where its pivot would be much smaller.
    Columns of the class `never` are not chosen: None where there are no others left.
    """
    a = _Many(g) if len(g) >= MANY else _Few(g)
    rows, left, chosen = list(range(len(g))), list(range(len(classes))), []
    while rows:
        sizes = zip(a.sizes(rows, left), left, strict=True)
        best = [(size, classes[j], j) for size, j in sizes if classes[j] < never]
        if not best:
            return None
        enough = GIVE_WAY * max(best)[0]
        lowest = min([kind for size, kind, _ in best if size >= enough])
        most = max([size for size, kind, _ in best if kind == lowest]) * (1 - EQUAL)
        column = next(j for size, kind, j in best if kind == lowest and size >= most)
        left.remove(column)
        chosen.append(column)
        rows.remove(a.eliminate(rows, column, left))
    return sorted(chosen)


class _Few:
    """Rows while unknowns are eliminated from them, as lists."""

    def __init__(self, g: Rows) -> None:
        self._a = [list(map(float, row)) for row in g]

    def sizes(self, rows: Sequence[int], columns: Sequence[int]) -> list[float]:
        """The largest size in each column."""
        sizes = [
            max(map(abs, column)) for column in zip(*map(self._a.__getitem__, rows), strict=True)
        ]
        return [sizes[j] for j in columns]

    def eliminate(self, rows: Sequence[int], column: int, others: Sequence[int]) -> int:
        """Clear a column in all of the rows but the one with its largest entry, which is given;
        only the columns `others` are computed."""
        a = self._a
        pivot = max(rows, key=lambda r: abs(a[r][column]))
        if a[pivot][column] != 0.0:
            clear([a[r] for r in rows if r != pivot], a[pivot], column, others)
        return pivot


class _Many:
    """The same, to the last bit, as one array."""

    def __init__(self, g: Rows) -> None:
        import numpy as np

        self._np = np
        self._a = np.array(g, dtype=float)

    def sizes(self, rows: Sequence[int], columns: Sequence[int]) -> list[float]:
        np = self._np
        found: list[float] = np.fmax.reduce(np.abs(self._a[np.ix_(rows, columns)])).tolist()
        return found

    def eliminate(self, rows: Sequence[int], column: int, others: Sequence[int]) -> int:
        a, values = self._a, self._a[:, column].tolist()
        pivot = max(rows, key=lambda r: abs(values[r]))
        cleared = [r for r in rows if r != pivot and values[r] != 0.0]
        if cleared:
            np = self._np
            factors = a[cleared, column] / values[pivot]
            a[np.ix_(cleared, others)] -= np.outer(factors, a[pivot, others])
        return pivot


def sensitivities(g: Rows, solved: Sequence[int], free: Sequence[int]) -> list[list[float]] | None:
    """|G_solved^-1 * G_free|, a row for each column solved for; None where singular."""
    if len(solved) > SMALL:
        return _large(g, solved, free)
    m = len(solved)
    a = [[row[j] for j in (*solved, *free)] for row in g]
    width = len(a[0])
    for k in range(m):
        pivot = max(range(k, m), key=lambda r: abs(a[r][k]))
        if a[pivot][k] == 0.0:
            return None
        a[k], a[pivot] = a[pivot], a[k]
        clear(a[:k] + a[k + 1 :], a[k], k, range(k + 1, width))
    return [[abs(x / a[k][k]) for x in a[k][m:]] for k in range(m)]


def _large(g: Rows, solved: Sequence[int], free: Sequence[int]) -> list[list[float]] | None:
    import numpy as np

    matrix = np.asarray(g, dtype=float)
    try:
        x = np.linalg.solve(matrix[:, list(solved)], matrix[:, list(free)])
    except np.linalg.LinAlgError:
        return None
    return np.abs(x).tolist()  # type: ignore[no-any-return]


def largest(x: Rows, columns: Sequence[int]) -> tuple[float, int, int]:
    """The largest entry in some columns, with its row and column; -1 where there is none."""
    best, at, place = -1.0, -1, -1
    for r, row in enumerate(x):
        for c in columns:
            if row[c] > best:
                best, at, place = row[c], r, c
    return best, at, place
