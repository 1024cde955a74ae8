"""Zero functions that go through zero and back within a step, as a short pulse does.

An integrator looks at the signs at the ends of its steps. Where a zero function bends away from
zero so close to it that a parabola through the ends of the last two steps comes as far as zero,
or nearly so, the step is looked at more closely: at the lowest point of the parabola, and of those
through the points found.

Example: `s > 0.9999` of s = sin(t) holds for 0.028 s; steps of 0.1 s do not see it.

In machine code the march notes the points and asks (`codegen.native.march`); this searches.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.ir.march import DIP_MARGIN, DIP_NOISE, DIP_POINTS
from planarc.solve.solvers.locate import Interpolant, crossed, locate
from planarc.solve.solvers.zeros import Zeros

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Sizes below which nothing but rounding is expected: of ways, this times `DIP_NOISE`.
LEAST = 1e-6
#: Parabolas that are followed to their lowest points.
_ROUNDS = 8


class Dips:
    """`points`: rows of a time and all zero functions there, the last one third; then a row of
    their largest sizes. `seen`: how many of these there are since the run went on."""

    def __init__(self, zeros: Zeros, relations: int) -> None:
        import numpy as np

        self.points = np.zeros((4, 1 + relations))
        self._zeros = zeros
        self.renew()

    def renew(self) -> None:
        """Know nothing of a run."""
        self.points.fill(0.0)
        self.points[3], self.seen = LEAST, 0

    def note(self, t: float, zeros: Sequence[float]) -> bool:
        """Take the end of a step; whether to search in it."""
        import numpy as np

        points = self.points
        points[:2] = points[1:3]
        points[2] = t, *zeros
        np.maximum(points[3], abs(points[2]), out=points[3])
        self.seen += 1
        return self.seen >= DIP_POINTS and bool(self._suspects().any())

    def _suspects(self) -> NDArray[np.bool_]:
        import numpy as np

        (t0, *a), (t1, *b), (t2, *c) = self.points[:3]
        a, b, c = np.array(a), np.array(b), np.array(c)
        h = t2 - t1
        with np.errstate(all="ignore"):  # far bounds, as of 1e300 s, are beyond any product
            before, behind = (b - a) / (t1 - t0), (c - b) / h
            bend = (behind - before) / (t2 - t0)
            x = np.clip((h - behind / bend) / 2, 0, h)
            least = b + x * (behind + bend * (x - h))
            way = abs(b - a) + abs(c - b)
            found: NDArray[np.bool_] = (b * c > 0) & (b * bend > 0)
            found &= abs(behind) < 2 * h * abs(bend)
            found &= (way > DIP_NOISE * self.points[3, 1:]) & (
                np.sign(b) * least < DIP_MARGIN * way
            )
        return found

    def search(
        self, states: Interpolant, directions: Sequence[int]
    ) -> tuple[float, list[int]] | None:
        """The first crossing in the last step, with its directions; None where there is none."""
        points = [(t, g) for t, *g in self.points[:3].tolist()]
        for i, suspect in enumerate(self._suspects().tolist()):
            (_, begin, end), t = points, _lowest(points, i)
            for _ in range(_ROUNDS if suspect else 0):
                left, right = begin, end
                if not left[0] < t < right[0]:
                    break
                middle = (t, [0.0] * len(left[1]))
                if self._zeros.roots(t, states(t), middle[1]) != 0:
                    return None
                if any(crossed(left[1], middle[1], directions)):
                    return locate(self._zeros, states, left, middle, directions)
                t = _lowest((left, middle, right), i)
                begin, end = (left, middle) if t < middle[0] else (middle, right)
        return None


def _lowest(points: Sequence[tuple[float, list[float]]], i: int) -> float:
    """Where the parabola of zero function i through three points has no slope; in the middle of
    the last two where it is none."""
    (t0, a), (t1, b), (t2, c) = points
    before, behind = (b[i] - a[i]) / (t1 - t0), (c[i] - b[i]) / (t2 - t1)
    bend = (behind - before) / (t2 - t0)
    return (t1 + t2 - behind / bend) / 2 if bend else (t1 + t2) / 2
