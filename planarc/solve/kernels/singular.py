"""A singular system of linear equations that agree: some unknowns are open, others follow.

Both brakes of a shaft hold it, and their torques s1 + s2 = T may be shared in any way:

    [1 1] [s1]   [T]        s2 keeps its value, s1 := T - s2
    [1 1] [s2] = [T]

Slow: it is asked only where elimination has found no solution. The native back end does
the same (`codegen.native.newton`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from planarc.ir.newton import AGREES, DEPENDENT
from planarc.runtime.elimination import clear


def solve_open(
    matrix: Sequence[Sequence[float]], right: Sequence[float], kept: Sequence[float]
) -> list[float] | None:
    """x with matrix*x = right, open unknowns as in `kept`; None where the rows disagree.

    Gauss and Jordan's elimination with the largest pivots, each relative to its row.
    """
    n = len(right)
    a = [[*row, r] for row, r in zip(matrix, right, strict=True)]
    sizes = [max(map(abs, row)) or 1.0 for row in matrix]
    if not all(map(math.isfinite, (*sizes, *right))):
        return None
    row_of: dict[int, int] = {}  # of each unknown that follows
    left = list(range(n))  # rows that give no unknown yet
    for _ in range(n):
        most, best, column = DEPENDENT, -1, -1
        for i in left:
            for j in range(n):
                if j not in row_of and abs(a[i][j]) > most * sizes[i]:
                    most, best, column = abs(a[i][j]) / sizes[i], i, j
        if best < 0:
            break
        row_of[column] = best
        left.remove(best)
        clear(a[:best] + a[best + 1 :], a[best], column, range(n + 1))
    open_ones = [j for j in range(n) if j not in row_of]
    x = list(kept)
    for j, i in row_of.items():
        x[j] = (a[i][n] - sum(a[i][k] * kept[k] for k in open_ones)) / a[i][j]
    largest = max(1.0, *map(abs, x))
    if any(abs(a[i][n]) > AGREES * sizes[i] * largest for i in left):
        return None
    return x
