"""Contacts between which motions that are given leave no room.

In:   `a`       how fast contacts part and slide by impulses along the normals of some of them
      `rest`    how fast these part without impulses, in m/s; negative where they approach
Out:  weights   y >= 0 with a @ y = 0 and rest @ y < 0; None where there are none

Impulses x, with friction or without, leave y @ u = rest @ y < 0: one of the contacts goes on
approaching, whatever presses there. Where no such weights exist, normal impulses end all approach
(Farkas' lemma).

Example: a ball of 1 kg, pushed by 1 m/s against a wall by what does not give way:
a = [[1, -1], [-1, 1]], rest = [-1, 0], y = (1, 1).

Reference: J. Farkas, Journal fuer die reine und angewandte Mathematik 124, 1902, 1-27.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: What cancels leaves errors below this part of what is summed.
CANCELS = 1e-9
#: Contacts with the largest of all shares that are looked at.
FEWEST = 1e-6


def find_pinched(a: Vector, rest: Vector) -> Vector | None:
    """`a` has a column for each of `rest`, and a row for each of all motions."""
    from scipy.optimize import nnls

    fastest = float(np.abs(rest).max(initial=0.0))
    if fastest == 0.0:
        return None
    sizes = np.abs(a).max(axis=0, initial=0.0)
    scale = 1.0 / np.where(sizes > 0, sizes, 1.0)
    rows = np.vstack([a * scale, rest * scale * (sizes.max() or 1.0) / fastest])
    target = np.zeros(len(rows))
    target[-1] = -1.0
    try:
        y: Vector = nnls(rows, target)[0] * scale
    except RuntimeError:  # too many iterations
        return None
    y = np.where(y > FEWEST * y.max(initial=0.0), y, 0.0)
    kept = bool((np.abs(a @ y) <= CANCELS * (np.abs(a) @ y)).all())
    closes = rest @ y < -CANCELS * (np.abs(rest) @ y)
    return y if kept and closes else None
