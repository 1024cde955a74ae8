"""Where the first relation switches within a step, by bisection on dense output.

For integrators without root finding of their own. Gives the first time at which a zero
function has gone through zero in its allowed direction, within the last few bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from planarc.solve.solvers.zeros import Zeros

Interpolant = Callable[[float], Sequence[float]]


def crossed(old: Sequence[float], new: Sequence[float], directions: Sequence[int]) -> list[int]:
    """The direction in which each zero function crossed, or 0."""
    return [
        d if (d > 0 and a < 0 <= b) or (d < 0 and a > 0 >= b) else 0
        for a, b, d in zip(old, new, directions, strict=True)
    ]


def locate(
    zeros: Zeros,
    states: Interpolant,
    begin: tuple[float, list[float]],
    end: tuple[float, list[float]],
    directions: Sequence[int],
) -> tuple[float, list[int]] | None:
    """The time and the directions of the first crossing between two evaluated times.

    Between them the root lies in a bracket that is halved, or cut by the secant of the
    function that crosses. None where the kernel fails.
    """
    (t0, g0), (t1, g1) = begin, end
    found = crossed(g0, g1, directions)
    side = 0
    for i in range(200):
        width = t1 - t0
        if width <= 4e-16 * max(abs(t0), abs(t1)) * 8:
            break
        t = t0 + width * _cut(g0, g1, found, bisect=i % 3 == 2 or abs(side) > 2)
        if not t0 < t < t1:
            break
        g = [0.0] * len(g0)
        if zeros.roots(t, states(t), g) != 0:
            return None
        earlier = crossed(g0, g, directions)
        if any(earlier):
            t1, g1, found = t, g, earlier
            side = max(side, 0) + 1
        else:
            t0, g0 = t, g
            side = min(side, 0) - 1
    return t1, found


def _cut(g0: Sequence[float], g1: Sequence[float], found: Sequence[int], bisect: bool) -> float:
    """The part of the bracket to look at next: the earliest secant of those that cross."""
    if bisect:
        return 0.5
    parts = [a / (a - b) for a, b, d in zip(g0, g1, found, strict=True) if d and a != b]
    part = min(parts, default=0.5)
    return min(max(part, 1e-9), 1 - 1e-9)
