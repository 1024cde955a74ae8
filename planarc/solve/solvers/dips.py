"""Zero functions that go through zero and back within a step, as a short pulse does.

An integrator looks at the signs at the ends of its steps. A step is looked at more closely where

    dip     a zero function bends away from zero so close to it that a parabola through the ends of
            the last two steps comes as far as zero, or nearly so: at the lowest point of the
            parabola, and of those through the points found
    rough   a zero function is not where its points before lead to, by more than a part of its
            distance from zero; or an angle of which a sine is asked has turned far: all along the
            step (`looks`)

Example: `s > 0.9999` of s = sin(t) holds for 0.028 s; steps of 0.1 s do not see it.

In machine code the march notes the points and asks (`codegen.native.march`); this searches.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

from planarc.ir.march import (
    DIP_MARGIN,
    DIP_NOISE,
    DIP_POINTS,
    POINTS,
    REACH,
    ROUGH_MARGIN,
    ROUGH_NOISE,
)
from planarc.solve.solvers.locate import Interpolant, crossed, locate
from planarc.solve.solvers.zeros import Zeros

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: Sizes below which nothing but rounding is expected: of ways, this times `DIP_NOISE`.
LEAST = 1e-6
#: Parabolas that are followed to their lowest points.
_ROUNDS = 8


class Suspicion(IntEnum):
    """What a step's zero functions may have done within it; the march has the same numbers."""

    NONE = 0
    DIP = 1
    ROUGH = 2


class Dips:
    """`points`: rows of a time and all zero functions there, the last one fourth; then a row of
    their largest sizes. `seen`: how many of these there are since the run went on. `turned`: the
    angles at the last of them, of the slots `turning` times `factors`; `farthest`: how far one has
    turned since the point before."""

    def __init__(
        self, zeros: Zeros, relations: int, turning: Sequence[tuple[int, float]] = ()
    ) -> None:
        import numpy as np

        self.points = np.zeros((POINTS + 1, 1 + relations))
        self.turning = np.array([slot for slot, _ in turning], dtype=np.int64)
        self.factors = np.array([factor for _, factor in turning], dtype=float)
        self.turned = np.zeros(len(turning))
        self._zeros = zeros
        self.renew()

    def renew(self) -> None:
        """Know nothing of a run."""
        self.points.fill(0.0)
        self.points[POINTS], self.seen, self.farthest = LEAST, 0, 0.0
        self._begun = False  # whether `turned` are angles of this run

    def begin(self, t: float, y: Sequence[float]) -> None:
        """Take the point from which the run goes on."""
        relations = self.points.shape[1] - 1
        self.seen, self._begun = 0, False
        zeros = [0.0] * relations
        if relations and self._zeros.roots(t, y, zeros) == 0:
            self.note(t, zeros)
        else:
            self.turn()

    def note(self, t: float, zeros: Sequence[float]) -> Suspicion:
        """Take the end of a step, at which the kernel is; what is to be searched for in it."""
        import numpy as np

        points = self.points
        points[: POINTS - 1] = points[1:POINTS]
        points[POINTS - 1] = t, *zeros
        np.maximum(points[POINTS], abs(points[POINTS - 1]), out=points[POINTS])
        self.seen += 1
        if (far := self.turn()) or self.seen < DIP_POINTS:
            return far
        if self._are_rough().any():
            return Suspicion.ROUGH
        return Suspicion.DIP if self._suspects().any() else Suspicion.NONE

    def turn(self) -> Suspicion:
        """Take the angles where the kernel is; what is to be searched for up to there."""
        if not len(self.turning):
            return Suspicion.NONE
        now = self.factors * self._zeros.values(self.turning)
        self.farthest = float(abs(now - self.turned).max()) if self._begun else 0.0
        self.turned[:], self._begun = now, True
        return Suspicion.ROUGH if self.farthest > REACH else Suspicion.NONE

    def _suspects(self) -> NDArray[np.bool_]:
        import numpy as np

        (t0, *a), (t1, *b), (t2, *c) = self.points[POINTS - 3 : POINTS]
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
            found &= (way > DIP_NOISE * self.points[POINTS, 1:]) & (
                np.sign(b) * least < DIP_MARGIN * way
            )
        return found

    def _are_rough(self) -> NDArray[np.bool_]:
        """Whether a zero function has the sign of before, but is off a parabola through the three
        points before, or a line through two, by more than a part of its distance from zero."""
        import numpy as np

        (t0, *a), (t1, *b), (t2, *c), (t3, *d) = self.points[:POINTS]
        a, b, c, d = (np.array(x) for x in (a, b, c, d))
        with np.errstate(all="ignore"):
            first, last = (b - a) / (t1 - t0), (c - b) / (t2 - t1)
            bend = (last - first) / (t2 - t0) if self.seen >= POINTS else 0.0
            off = abs(d - (c + (t3 - t2) * (last + bend * (t3 - t1))))
            near = np.minimum(abs(c), abs(d)) < ROUGH_MARGIN * off
            found: NDArray[np.bool_] = (c * d > 0) & near
            found &= off > ROUGH_NOISE * self.points[POINTS, 1:]
        return found

    def search(
        self, states: Interpolant, directions: Sequence[int]
    ) -> tuple[float, list[int]] | None:
        """The first crossing in the last step, with its directions; None where there is none."""
        points = [(t, g) for t, *g in self.points[POINTS - 3 : POINTS].tolist()]
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
