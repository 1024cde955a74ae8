"""Forces at touches, by complementarity: what presses does not part, what parts does not press.

In:   `a`, `b`    u = a*x + b: along the normals (first half) and the slips (second half), how
                  fast the touches part and slide when the forces or impulses x act at them
      `spots`     what is known of each touch
Out:  Solution    the forces, the motion, and the case of each touch; None where there is none

    normal    n = floor, u_n >= 0    or    n >= floor, u_n = 0
    slip      sticks |t| <= mu*n, u_t = 0;    slides t = -way*mu*n, way*u_t >= 0;    idle t = 0

All cases are tried for up to three touches, those with the fewest forces first; above, Lemke's
method finds them (`lemke`), to rounding or, where touches depend on each other, loosely.
Equations of touches that say the same (two corners that stick) are left to one of them, and the
other idles.

Example: a ball of 2 kg on the floor: a = [[0.5]], b = [-9.81], n = 19.62.

Reference: F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, 1996;
           C. E. Lemke, Management Science 11(7), 1965, 681-689.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain, product
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from planarc.core.data import Data
from planarc.solve.contact.lemke import lemke

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Touches of which all cases are tried.
MOST_TRIED = 3
#: The same after Lemke's method has found none.
MOST_AFTER = 5
#: Errors of forces and motions, as parts of the largest.
ROUNDING = 1e-11
#: So many times larger errors may be where no case has smaller ones: touches that depend on each
#: other (two corners that stick) have accelerations that agree to errors of the run only.
LOOSELY = 1e4
#: Condition above which equations say the same.
ALIKE = 1e10

#: Starts of Lemke's method, which may end at a wrong case where touches depend on each other, and
#: what makes the covers of later ones uneven.
ATTEMPTS, UNEVEN = 8, (math.sqrt(5.0) - 1.0) / 2.0

#: Ways of a touch along its slip.
STICKS, IDLE = 0, 2


class Spot(Data):
    """A touch that may be held. `way`: None where the slip is zero, so that it may stick or slide;
    else where it slides to, or IDLE. `floor` is the least normal force. A `loose` one is at the end
    of its sticking."""

    mu: float
    way: int | None
    floor: float = 0.0
    loose: bool = False


#: Whether a touch keeps its normal motion zero, and its way.
Case: TypeAlias = "tuple[bool, int]"


class Solution(Data):
    x: Vector
    u: Vector
    cases: tuple[Case, ...]


def solve_contacts(
    a: Vector, b: Vector, spots: Sequence[Spot], noise: float = 0.0
) -> Solution | None:
    """The forces and cases that keep all inequalities; None where none do. `noise` is the size of a
    motion that is nothing but rounding."""
    if len(spots) == 1 and spots[0].way == IDLE and a[0, 0] > 0:
        return _alone(a, b, spots[0].floor, noise)
    if len(spots) <= MOST_TRIED:
        tried: Iterator[Sequence[Case] | None] = product(*map(_cases, spots))
    else:
        tried = _found(a, b, spots)
        if len(spots) <= MOST_AFTER:
            tried = chain(tried, (None,), product(*map(_cases, spots)))
    best, least, seen = None, LOOSELY, set()
    for cases in tried:
        if cases is None and best is not None:
            return best
        if cases is None or tuple(cases) in seen:
            continue
        seen.add(tuple(cases))
        found = solve_case(a, b, spots, cases)
        if found is not None and (off := _misfit(a, found, b, spots, noise)) < least:
            if off <= 1.0:
                return found
            best, least = found, off
    return best


def _alone(a: Vector, b: Vector, floor: float, noise: float) -> Solution:
    """The forces of one touch without friction."""
    closed = bool(a[0, 0] * floor + b[0] < -max(ROUNDING * float(np.abs(b).max()), noise))
    x = np.array([-b[0] / a[0, 0] if closed else floor, 0.0])
    return Solution(x, a @ x + b, ((closed, IDLE),))


def _cases(spot: Spot) -> list[Case]:
    """The cases of a touch, in the order in which they are tried."""
    if spot.way is not None:
        ways = [spot.way]
    elif spot.loose:
        ways = [1, -1, STICKS, IDLE]
    else:
        ways = [STICKS, IDLE, 1, -1]
    free = [(False, w) for w in ways] if spot.floor > 0 else [(False, IDLE)]
    return free + [(True, w) for w in ways]


def solve_case(
    a: Vector, b: Vector, spots: Sequence[Spot], cases: Sequence[Case]
) -> Solution | None:
    """Forces by the equations of one case; None where these say the same twice."""
    k = len(spots)
    matrix, given = np.eye(2 * k), np.zeros(2 * k)
    rows = []
    for i, (spot, (closed, way)) in enumerate(zip(spots, cases, strict=True)):
        given[i] = spot.floor
        if closed:
            matrix[i], given[i] = a[i], -b[i]
            rows.append(i)
        if way == STICKS:
            matrix[k + i], given[k + i] = a[k + i], -b[k + i]
            rows.append(k + i)
        elif way != IDLE:
            matrix[k + i, i] = way * spot.mu
    if rows:
        own = matrix[np.ix_(rows, rows)]
        slides = [i for i in rows if i < k and cases[i][1] not in (STICKS, IDLE)]
        for i in slides:
            own[:, rows.index(i)] -= cases[i][1] * spots[i].mu * matrix[rows, k + i]
        sizes = np.linalg.svd(own, compute_uv=False)
        if not sizes[-1] * ALIKE > sizes[0]:
            return None
    x: Vector = np.asarray(np.linalg.solve(matrix, given), dtype=np.float64)
    return Solution(x, a @ x + b, tuple(cases))


def _misfit(a: Vector, found: Solution, b: Vector, spots: Sequence[Spot], noise: float) -> float:
    """How far a solution of the equations breaks an inequality, at most 1 for rounding alone."""
    k, x, u = len(spots), found.x, found.u
    largest, size, effect = (float(np.abs(v).max(initial=1e-300)) for v in (x, b, a))
    force, motion = max(ROUNDING * largest, noise / effect), max(ROUNDING * size, noise)
    worst, forces, motions = 0.0, x.reshape(2, k).T.tolist(), u.reshape(2, k).T.tolist()
    for (closed, way), spot, (n, t), (v, slip) in zip(
        found.cases, spots, forces, motions, strict=True
    ):
        worst = max(worst, (spot.floor - n) / force, 0.0 if closed else -v / motion)
        if way == STICKS:
            worst = max(worst, (abs(t) - spot.mu * n) / force)
        elif spot.way is None and way != IDLE:
            worst = max(worst, -way * slip / motion)
        elif spot.way is None and n > force:
            worst = max(worst, abs(slip) / motion)
    return worst


def _found(a: Vector, b: Vector, spots: Sequence[Spot]) -> Iterator[Sequence[Case]]:
    """The cases that Lemke's method finds, from one start and then from others.

    z = (n - floor of each; t forward, t backward, speed of each that may stick)
    """
    k = len(spots)
    free = [i for i, s in enumerate(spots) if s.way is None]
    f = len(free)
    size = k + 3 * f
    to_forces, base = np.zeros((2 * k, size)), np.zeros(2 * k)
    for i, spot in enumerate(spots):
        to_forces[i, i], base[i] = 1.0, spot.floor
        if spot.way not in (None, IDLE):
            to_forces[k + i, i] = -spot.way * spot.mu
            base[k + i] = -spot.way * spot.mu * spot.floor
    for j, i in enumerate(free):
        to_forces[k + i, k + j], to_forces[k + i, k + f + j] = 1.0, -1.0
    motion, rest = a @ to_forces, a @ base + b
    m, q = np.zeros((size, size)), np.zeros(size)
    m[:k], q[:k] = motion[:k], rest[:k]
    for j, i in enumerate(free):
        forward, backward, speed = k + j, k + f + j, k + 2 * f + j
        m[forward], q[forward] = motion[k + i], rest[k + i]
        m[backward], q[backward] = -motion[k + i], -rest[k + i]
        m[forward, speed] = m[backward, speed] = 1.0
        m[speed, i], m[speed, forward], m[speed, backward] = spots[i].mu, -1.0, -1.0
        q[speed] = spots[i].mu * spots[i].floor
    for attempt in range(ATTEMPTS):
        cover = 1.0 + np.modf(attempt * UNEVEN * np.arange(size))[0]
        basic = lemke(m, q, cover)
        if basic is not None:
            for lets in (True, False):
                yield _read(basic, spots, free, lets)


def _read(
    basic: frozenset[int], spots: Sequence[Spot], free: Sequence[int], lets: bool
) -> list[Case]:
    """The case in which these of Lemke's unknowns are not zero. `lets`: what is at the end of its
    sticking slides against its force. Where both fit to rounding it would stick for ever otherwise,
    since nothing that happens later asks again."""
    k, f = len(spots), len(free)
    cases: list[Case] = []
    for i, spot in enumerate(spots):
        way = IDLE if spot.way is None else spot.way
        if spot.way is None:
            j = free.index(i)
            forward, backward = k + j in basic, k + f + j in basic
            slides = k + 2 * f + j in basic
            if forward or backward:
                sticks = forward == backward or not (slides or (lets and spot.loose))
                way = STICKS if sticks else -1 if forward else 1
        cases.append((i in basic, way))
    return cases
