"""Zero functions that swing within a step, as sin(1000*x) does while x moves evenly.

In:   the zero functions, the states on a step
Out:  the first crossing on it, with its directions

Steps follow the states, and know nothing of how often a sine of them turns. So such functions are
looked at within every step. Where a polynomial goes through all looks, they are smooth; else there
are twice as many looks again and again, until these find no more switches. The looks lie by chance,
so that no period hides between them.

Example: `sin(1000*x) > 0` with der(x) = 1; a step of 0.02 s goes across six switches.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.solve.solvers.locate import Interpolant, crossed, locate
from planarc.solve.solvers.zeros import Zeros

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Looks within a step at first, and at most; the degree of the polynomial.
FEWEST, MOST, DEGREE = 8, 1 << 14, 5
#: Distance from the polynomial, as a part of a function's way on the step.
SMOOTH = 0.02

_Point = tuple[float, list[float]]


class Waves:
    """`times` are the first looks on a step of length 1; `rough` gives what no polynomial does."""

    def __init__(self, zeros: Zeros, relations: int) -> None:
        import numpy as np

        self._zeros, self._count = zeros, relations
        self._times = _times(FEWEST)
        v = np.vander(self._times, DEGREE + 1)
        self._rough = np.eye(len(v)) - v @ np.linalg.pinv(v)

    def search(
        self, states: Interpolant, begin: float, end: float, directions: Sequence[int]
    ) -> tuple[float, list[int]] | None:
        """The first crossing between two times of the last step; None where there is none."""
        points = self._points(states, begin, end, self._times)
        count, before = FEWEST, -1
        while points is not None and not self._is_smooth(points):
            now = _switches(points)
            if now == before or count >= MOST:
                break
            count, before = 2 * count, now
            points = self._points(states, begin, end, _times(count))
        for left, right in zip(points or (), (points or ())[1:], strict=False):
            if any(crossed(left[1], right[1], directions)):
                return locate(self._zeros, states, left, right, directions)
        return None

    def _points(
        self, states: Interpolant, begin: float, end: float, times: Vector
    ) -> list[_Point] | None:
        """Times with the zero functions there; None where these fail."""
        found = []
        for part in times.tolist():
            t, g = begin + part * (end - begin), [0.0] * self._count
            if self._zeros.roots(t, states(t), g) != 0:
                return None
            found.append((t, g))
        return found

    def _is_smooth(self, points: Sequence[_Point]) -> bool:
        import numpy as np

        if len(points) != len(self._times):
            return False
        g = np.array([g for _, g in points])
        return bool((abs(self._rough @ g) <= SMOOTH * np.ptp(g, axis=0)).all())


def _times(count: int) -> Vector:
    """Both ends of a step of length 1, and a time in each of so many parts between."""
    import numpy as np

    parts = np.arange(count) + np.random.default_rng(count).random(count)
    return np.concatenate(([0.0], parts / count, [1.0]))


def _switches(points: Sequence[_Point]) -> int:
    import numpy as np

    positive = np.array([g for _, g in points]) > 0
    return int((positive[1:] != positive[:-1]).sum())
