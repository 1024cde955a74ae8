"""Forces at contacts and at joints that rub: what presses on a joint follows from all forces.

In:   `a`, `b`, `spots`, `noise`    as of `solve_contacts`
      `rubs`     the spots that are joints; their rows and columns of the normals are zero, but for
                 `most` on the diagonal
      `press`    what presses at all spots while forces act there
Out:  Solution, or None where no limits of friction agree with the forces that they cause

A joint's normal force is put in as given, its limit; forces by these limits show what really
presses, which gives better limits.

Example: a slide of 2 kg on a level guide, mu = 0.3: the limit is 0, then 19.62 N, and stays.

Reference: D. G. Anderson, J. ACM 12(4), 1965, 547-560.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from planarc.solve.contact.problem import Solution, Spot, solve_contacts

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: Rounds in which limits and forces agree, to this part.
ROUNDS, AGREE = 200, 1e-9


def solve_pressed(
    a: Vector,
    b: Vector,
    spots: Sequence[Spot],
    noise: float,
    rubs: Array,
    most: float,
    press: Callable[[Vector], Vector | None],
) -> Solution | None:
    if not len(rubs):
        return solve_contacts(a, b, spots, noise)
    b, limits = b.copy(), np.zeros(len(rubs))
    found: Solution | None = Solution(np.zeros(len(b)), b, ())
    seen: list[tuple[Vector, Vector]] = []
    for _ in range(ROUNDS):
        if found is None or (pressed := press(found.x)) is None:
            return None
        error = pressed[rubs] - limits
        if not np.isfinite(error).all():
            return None
        if found.cases and np.abs(error).max() <= AGREE * np.abs(limits).max():
            return found
        seen = [*seen[-len(rubs) :], (limits, error)]
        limits = _next(seen)
        b[rubs] = -most * limits
        found = solve_contacts(a, b, spots, noise)
    return None


def _next(seen: Sequence[tuple[Vector, Vector]]) -> Vector:
    """The limits that the last ones and their errors promise."""
    limits, error = seen[-1]
    if len(seen) > 1:
        steps = np.array([earlier - limits for earlier, _ in seen[:-1]]).T
        changes = np.array([earlier - error for _, earlier in seen[:-1]]).T
        part = np.linalg.lstsq(changes, error, rcond=1e-10)[0]
        limits, error = limits - steps @ part, error - changes @ part
    found: Vector = np.maximum(limits + error, 0.0)
    return found
