"""When the choice of states is to be looked at again.

In:   the sensitivities at a look, the coordinates and their velocities
Out:  Watch    how far a coordinate, and how much faster than the states, may move before

In Python a look at the sensitivities X costs as much as ten steps of the integrator, so
it is put off. Two things bring it about. The ratio of velocities, compared after every step: as the
velocities of what is determined are -X times those of the states, it is the sensitivity
itself where a mechanism has one degree of freedom and no constraint holds time; then nothing
else is asked, but for the sizes of columns, which change slowly. Where a mechanism has more, it
is a bound from below.
And the way of the coordinates: what X is in other directions than that of the motion
changes with the angle psi = atan(x), x the largest entry of X. It turns evenly while x
goes to infinity (psi = pi/2), as fast as paths are curved, which is taken from X here and
a little farther along the motion, and not below what was seen on the way here.

Example: a slider s on a crank: psi is the crank's own angle, and s'/phi' = tan(psi).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import sub

from planarc.ir.kernel import Kernel
from planarc.ir.newton import GROWN
from planarc.ir.program import Program
from planarc.solve.solvers.watch import Watch

#: Turning of psi with the coordinates (per radian or metre) that is reckoned with at least.
RATE = 0.5
#: Factors on the turning seen on the way, and on that seen at a look.
SEEN, PRESENT = 1.5, 1.25
#: Part of the turn that is left to use up before the next look.
CAUTION = 0.75
#: The least turn taken to be left.
LEAST = 0.04
#: Way along the motion to the second place.
BESIDE = 1e-4
#: A dead centre so much way ahead (radians or metres), as psi turns now, is near.
SOON = 0.5
#: Sensitivities so small are far from a dead centre: what was seen on the way is enough.
CALM = 2.0
#: Relative difference from a ratio of velocities to the sensitivity that it is.
EXACT = 1e-6
#: Way (radians or metres) on which the sizes of columns hardly change.
STEADY = 0.5

Rows = Sequence[Sequence[float]]
#: A velocity's slot with its weight, negative for a state: groups of a block after another.
Paces = list[tuple[int, float]]


class Outlook:
    """The distance to the next look at the states. `sensitivities` gives |X| of all open blocks at
    the workspace's values."""

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        watch: Watch,
        sensitivities: Callable[[], Sequence[Rows]],
    ) -> None:
        self.watch = watch
        self._kernel = kernel
        self._motion = [(c.slot, c.derivative) for c in program.candidates]
        self._slots = self.watch.slots
        rates = {c.slot: c.derivative for c in program.candidates}
        self._velocities = [rates[s] for s in self._slots]
        self._sensitivities = sensitivities
        self._seen = [0.0] * len(self._slots)
        self._psi, self._rate = 0.0, RATE

    def plan(
        self, worst: float, bound: float, changed: bool, paces: Paces, single: bool = False
    ) -> None:
        """Plan the next look, which must come before `bound`, after one that found `worst`.
        Where the choice `changed`, psi is another angle than before. `single`: there is one
        block, with one state."""
        values = [float(self._kernel.w[s]) for s in self._slots]
        way = max(map(abs, map(sub, values, self._seen)), default=0.0)
        psi = math.atan(worst)
        known = way > 1e-3 and not changed
        if known:
            self._rate = max(0.8 * self._rate, SEEN * abs(self._psi - psi) / way)
        self._seen, self._psi = values, psi
        self._pace(paces, bound)
        if single and abs(self.watch.ratio(self._kernel.w) - worst) <= EXACT * worst:
            self.watch.pace, least = bound, STEADY
        else:
            turning = PRESENT * self._turning() if worst > CALM or not known else 0.0
            self._rate, least = max(self._rate, turning), 0.0
        self._rate = max(RATE, self._rate)
        self._begin(max(math.atan(bound) - psi, LEAST), least)

    def hurry(self, paces: Paces) -> None:
        """The last look ahead was too far: look much sooner from here."""
        self._rate *= 4
        self._seen = [float(self._kernel.w[s]) for s in self._slots]
        self._begin(LEAST)
        self._pace(paces, 0.0)

    def _begin(self, left: float, least: float = 0.0) -> None:
        self.watch.begin(self._seen, max(CAUTION * left / self._rate, least))

    def _pace(self, paces: Paces, bound: float) -> None:
        watch = self.watch
        watch.speeds[:] = [slot for slot, _ in paces]
        watch.weights[:] = [weight for _, weight in paces]
        watch.pace = max(bound, GROWN * watch.ratio(self._kernel.w))

    def heads_for_dead_centre(self) -> bool:
        """Whether the largest psi grows so fast that it is a right angle before long."""
        pairs = self._along()
        psi, slope = max(pairs, default=(0.0, 0.0))
        return (math.pi / 2 - psi) < SOON * slope

    def _turning(self) -> float:
        """How fast psi turns along the motion here, of any entry of X."""
        return max((abs(slope) for _, slope in self._along()), default=0.0)

    def _along(self) -> list[tuple[float, float]]:
        """psi of every entry of X, and its slope along the motion; nothing at rest."""
        w = self._kernel.w
        speed = max((abs(float(w[s])) for s in self._velocities), default=0.0)
        if not 0.0 < speed < math.inf:
            return []
        here = self._sensitivities()
        kept = [float(w[slot]) for slot, _ in self._motion]
        rates = [float(w[slot]) for _, slot in self._motion]
        for (slot, _), value, rate in zip(self._motion, kept, rates, strict=True):
            w[slot] = value + BESIDE / speed * rate
        beside = self._sensitivities()
        for (slot, _), value in zip(self._motion, kept, strict=True):
            w[slot] = value
        return [
            (math.atan(a), (math.atan(b) - math.atan(a)) / BESIDE)
            for x, y in zip(here, beside, strict=True)
            for row, other in zip(x, y, strict=True)
            for a, b in zip(row, other, strict=True)
        ]
