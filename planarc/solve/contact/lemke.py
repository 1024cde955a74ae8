"""Lemke's method for a linear complementarity problem.

In:   m, q     w = m*z + q,  w >= 0,  z >= 0,  w*z = 0
Out:  the indices of the z that are in the basis, or None where the method finds none

Ties are broken by the order of whole rows, so that no basis comes back.

Example: m = [[2]], q = [-1]: {0}, since z = 0.5 and w = 0.

Reference: C. E. Lemke, Management Science 11(7), 1965, 681-689;
           R. W. Cottle, J.-S. Pang, R. E. Stone, The Linear Complementarity Problem, 1992, 4.4.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: Pivots below this part of the largest are zero.
LEAST = 1e-10
MOST_PIVOTS = 100


def lemke(m: Vector, q: Vector, cover: Vector | None = None) -> frozenset[int] | None:
    """The unknowns z that are not zero where w = m z + q, w and z are at least zero and w z = 0;
    None where the method finds none. `cover` is positive, by default ones: another one leads there
    by another way."""
    n = len(q)
    if (q >= 0).all():
        return frozenset()
    q, cover = q / np.abs(q).max(), np.ones(n) if cover is None else cover
    # Columns: w (0 to n - 1), z (n to 2n - 1), the cover (2n), the right side.
    table = np.hstack([np.eye(n), -m, -cover[:, None], q[:, None]])
    basis = list(range(n))
    row, entering = int(np.argmin(q / cover)), 2 * n
    for _ in range(MOST_PIVOTS * n):
        table[row] /= table[row, entering]
        others = np.arange(n) != row
        table[others] -= np.outer(table[others, entering], table[row])
        basis[row], leaving = entering, basis[row]
        if leaving == 2 * n:
            return frozenset(b - n for b in basis if b >= n)
        entering = leaving + n if leaving < n else leaving - n
        column = table[:, entering]
        rows = np.flatnonzero(column > LEAST * max(1.0, np.abs(column).max()))
        if not len(rows):
            return None
        row = _first(table, basis, rows, column, 2 * n)
    return None


def _first(table: Vector, basis: list[int], rows: Array, column: Vector, cover: int) -> int:
    """The row that reaches zero first; the cover's where it is among them."""
    ratios = table[rows, -1] / column[rows]
    tied = rows[ratios <= ratios.min() + LEAST * max(1.0, abs(ratios.min()))]
    for row in tied:
        if basis[row] == cover:
            return int(row)
    n = len(basis)
    return int(min(tied, key=lambda row: tuple(table[row, :n] / column[row])))
