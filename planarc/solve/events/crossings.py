"""The zero functions of relations: stored truths, and what crosses zero where.

Between events the truth of every relation is stored in the workspace. A relation is
true where its zero function is negative; which of two neighbouring truths holds at zero
itself is said by the direction of the crossing, never by the sign of a number near zero.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.kernel import Kernel
from planarc.ir.program import Program

#: A zero function below this part of its largest value has no sign.
NOISE = 1e-14
#: One that was never above this is zero by its equations; what is seen of it are rounding
#: errors (the torque limit of an open clutch).
SILENCE = 1e-12


class Crossings:
    """`now` are the values of the zero functions where they were evaluated last, `largest`
    the greatest sizes seen in the run."""

    def __init__(self, program: Program, kernel: Kernel, span: float) -> None:
        self.program, self.kernel = program, kernel
        self.now = [0.0] * len(program.relations)
        self.largest = [0.0] * len(program.relations)
        self._ahead = 1e-7 * (span or 1.0)

    def truths(self) -> list[bool]:
        return [self.kernel.w[r.slot] != 0 for r in self.program.relations]

    def directions(self) -> list[int]:
        """The only way in which each zero function may cross next."""
        return [1 if truth else -1 for truth in self.truths()]

    def evaluate(self, t: float, y: Sequence[float]) -> int:
        """The kernel's flag; `now` and `largest` are up to date after it."""
        flag = self.kernel.roots(t, y, self.now)
        self.largest = [max(a, abs(b)) for a, b in zip(self.largest, self.now, strict=True)]
        return flag

    def forget(self) -> None:
        """Sizes seen while the start was searched for say nothing of the run."""
        self.largest = [0.0] * len(self.largest)

    def sign(self, i: int) -> bool:
        """The truth that the value of zero function i stands for."""
        return self.now[i] < 0 or (self.now[i] == 0 and not self.program.relations[i].strict)

    def missed(self, t: float, y: Sequence[float]) -> dict[int, bool]:
        """Relations whose stored truth no longer agrees with their zero function."""
        if not self.now or self.evaluate(t, y) != 0:
            return {}
        wrong = {}
        for i, relation in enumerate(self.program.relations):
            if abs(self.now[i]) > 1e3 * NOISE * max(1.0, self.largest[i]):
                truth = self.now[i] < 0
                if truth != (self.kernel.w[relation.slot] != 0):
                    wrong[i] = truth
        return wrong

    def rises(self, t: float, y: Sequence[float]) -> list[float] | None:
        """How far each zero function moves within a short time from here, to first order."""
        now = [0.0] * len(self.now)
        ydot = [0.0] * len(y)
        if self.kernel.rhs(t, y, ydot) != 0 or self.kernel.roots(t, y, now) != 0:
            return None
        later = [a + self._ahead * d for a, d in zip(y, ydot, strict=True)]
        ahead = list(now)
        if self.kernel.roots(t + self._ahead, later, ahead) != 0:
            return None
        return [b - a for a, b in zip(now, ahead, strict=True)]

    def real(self, directions: Sequence[int], rises: Sequence[float] | None) -> dict[int, bool]:
        """The crossings among those that an integrator reports, with the truth that follows.

        A function that rises where it was seen to fall has not crossed: the integrator saw
        the errors of its own first steps. One that neither rises nor falls (the speed of
        what is stuck) has none but rounding errors; should it leave zero, `missed` tells.
        """
        found = {i: d < 0 for i, d in enumerate(directions) if d}
        if rises is None:
            return found
        return {
            i: truth
            for i, truth in found.items()
            if self.largest[i] > SILENCE and directions[i] * rises[i] > 4 * NOISE * self.largest[i]
        }

    def amplitude(self, i: int, rise: float, since: float) -> float:
        """The height of a bounce that took the time `since`, as a part of the largest seen."""
        return abs(rise) / self._ahead * since / 4 / max(self.largest[i], 1e-300)
