"""The impulses of all contacts at once, by projected Gauss-Seidel.

In:   `a`, `b`     u = a @ x + b, sparse: the normal and the slip velocity of each contact in
                   turn, for impulses x
      `mu`         coefficients of friction
Out:  x            x_n >= 0, u_n >= 0, x_n*u_n = 0; |x_t| <= mu*x_n, against u_t where it slides

Example: a ball of 2 kg that falls by 0.1 m/s onto the floor: a = [[0.5]], b = [-0.1], x_n = 0.2.

Reference: M. Jean, Comput. Methods Appl. Mech. Eng. 177, 1999, 235-257.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planarc.ir.kernel import Sweep

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    from planarc.core.arrays import Vector

#: Sweeps over all contacts, at most.
MOST_SWEEPS = 300


def solve_impulses(
    a: csr_array, b: Vector, mu: Vector, x: Vector, tolerance: float, sweep: Sweep | None
) -> Vector:
    """`x` are impulses to begin with; changes of velocities below `tolerance` (m/s) are none.
    `sweep` does it in machine code, where there is some."""
    diagonal = a.diagonal()
    inverse = np.where(diagonal > 0, 1.0 / np.where(diagonal > 0, diagonal, 1.0), 0.0)
    x = x.copy()
    if sweep is not None:
        starts, columns = a.indptr.astype(np.int64), a.indices.astype(np.int64)
        sweep(starts, columns, a.data, b, mu, inverse, x, MOST_SWEEPS, tolerance)
        return x
    rows = [(a.indices[s:e], a.data[s:e]) for s, e in zip(a.indptr[:-1], a.indptr[1:], strict=True)]
    for number in range(MOST_SWEEPS):
        worst = 0.0
        for i in range(len(mu))[:: -1 if number % 2 else 1]:
            for row in (2 * i, 2 * i + 1):
                columns, entries = rows[row]
                new = x[row] - (entries @ x[columns] + b[row]) * inverse[row]
                most = mu[i] * x[2 * i]
                new = max(new, 0.0) if row == 2 * i else min(max(new, -most), most)
                worst = max(worst, abs(new - x[row]) * diagonal[row])
                x[row] = new
        if worst <= tolerance:
            break
    return x
