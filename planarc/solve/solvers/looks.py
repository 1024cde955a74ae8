"""Looks all along a step at zero functions that may switch anywhere within it.

In:   the zero functions, the states on a step, how far an angle has turned in it
Out:  the first crossing, with its directions

States that move evenly let steps grow without end, while a gap between what turns with them closes
and opens again. So a step is cut into pieces in which angles turn a little, and a piece is cut
again and again until each zero function is farther from zero, at both ends and between, than it
bends away from a straight line there.

Example: a blade turns with 7 rad/s past a post; in steps of 0.4 s it goes through it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.ir.march import DIP_NOISE, REACH
from planarc.solve.solvers.locate import Interpolant, crossed, locate
from planarc.solve.solvers.zeros import Zeros

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Pieces at first, and evaluations on a step, at most.
FEWEST, MOST = 4, 1 << 14
#: A zero function bends by less than its distance from zero over this.
MARGIN = 4.0
#: Where a piece is cut: not in its middle, lest periods hide between.
CUT = 0.45

_Point = tuple[float, list[float]]


class Looks:
    def __init__(self, zeros: Zeros, relations: int) -> None:
        self._zeros, self._count = zeros, relations

    def search(
        self,
        states: Interpolant,
        begin: _Point,
        end: _Point,
        turned: float,
        largest: Vector,
        directions: Sequence[int],
    ) -> tuple[float, list[int]] | None:
        """The first crossing; None where there is none. `turned` in rad; `largest` are the sizes
        that zero functions had so far."""
        import numpy as np

        noise, pieces = DIP_NOISE * largest, FEWEST + int(min(turned / REACH, MOST / 4))
        times = np.linspace(begin[0], end[0], pieces + 1)[1:-1].tolist()
        left, budget = begin, MOST
        ahead: list[float | _Point] = [end, *reversed(times)]
        while ahead:
            right = ahead.pop()
            if not isinstance(right, tuple):
                right = self.point(states, right)
            t = left[0] + CUT * (right[0] - left[0])
            middle = self.point(states, t) if left[0] < t < right[0] and budget > 0 else right
            if not right[1] or not middle[1]:
                return None
            for point in (middle, right):
                if any(crossed(left[1], point[1], directions)):
                    return locate(self._zeros, states, left, point, directions)
            budget -= 2
            if middle is right or _are_away(left, middle, right, noise):
                left = right
            else:
                ahead += [right, middle]
        return None

    def point(self, states: Interpolant, t: float) -> _Point:
        """A time of the step with the zero functions there; with none where these fail."""
        g = [0.0] * self._count
        return t, (g if self._zeros.roots(t, states(t), g) == 0 else [])


def _are_away(left: _Point, middle: _Point, right: _Point, noise: Vector) -> bool:
    """Whether no zero function can reach zero between the points, but for noise."""
    import numpy as np

    a, b, c = (np.array(g) for _, g in (left, middle, right))
    bend = np.abs(b - (a + CUT * (c - a)))
    least = np.minimum(np.minimum(np.abs(a), np.abs(b)), np.abs(c))
    return bool(((least > MARGIN * bend) | (bend <= noise)).all())
