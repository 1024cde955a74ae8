"""Poles of derivatives that a step has gone across, as that of der(x) = -1/x at x = 0.

An integrator knows states to its tolerance only: below that it steps over a pole, and follows a
root of its implicit formula that is no solution. There a derivative changes its sign, and the
step is far from what its ends say, by the trapezoidal rule. Between such ends is searched: where
the sign changes, a derivative vanishes, jumps, or grows beyond all bounds.

Across a pole as that of der(x) = -1/x^2 no sign changes. Before it the derivative is so large that
a time that cannot be told from the present one moves the state by more than its tolerance: there
the way of the step is followed beyond its end.

In machine code the march compares the ends of steps (`codegen.native.march`); this searches.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from operator import itemgetter
from typing import TYPE_CHECKING

from planarc.ir.kernel import Kernel
from planarc.ir.march import GROWTH, MISFIT

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Halvings of the way between the ends of a step.
HALVINGS = 40
#: Derivatives must be so many times larger before ends are looked between once more.
LARGER = 4.0
#: Steps like the last one that are looked along for a pole ahead; parts of the golden section.
AHEAD, SECTION = 16.0, (math.sqrt(5) - 1) / 2
#: Parts after which a derivative that has not grown has no pole on the way.
SOON = 12
#: Times that differ by less than this part cannot be told apart: a thousand roundings.
ROUNDING = 2.0**-42


class Poles:
    """`trail`: the time of the last point (nan: there is none), the states there, their
    derivatives, the sizes below which these are not looked at where their sign changes, the
    products with the time below which they are not elsewhere, and the absolute tolerances: what
    hardly moves its state in a step is noise. `places` are the slots of states and
    derivatives, those of the workspace: an implicit method evaluates beside the end that it
    accepts. Poles without a change of sign are looked for only with `ahead`."""

    def __init__(self, kernel: Kernel, states: int, ahead: bool = True) -> None:
        import numpy as np

        self.kernel, self.size, self.ahead = kernel, states, ahead
        self.places = np.zeros(2 * states, dtype=np.int64)
        self.trail = np.zeros(1 + 5 * states)
        self.begin([0] * (2 * states), [math.inf] * states)  # nothing to look at yet

    def renew(self) -> None:
        """Know nothing of a run before `begin`."""
        self.trail.fill(0.0)

    def begin(self, places: Sequence[int], absolute: Sequence[float]) -> None:
        """Go on anew, with these slots of the states and of their derivatives, and these absolute
        tolerances."""
        self.places[:] = places
        self.trail[1 + 4 * self.size :] = absolute
        ways = self.trail[1 + 3 * self.size : 1 + 4 * self.size]
        ways[:] = [a / ROUNDING for a in absolute] if self.ahead else math.inf
        self._least_way = min(absolute, default=math.inf) / ROUNDING if self.ahead else math.inf
        self.trail[0] = math.nan
        self._pick = itemgetter(0, *places)  # of the workspace: the time, states, derivatives
        self._last: Sequence[float] = ()  # the last point that `note` took

    @property
    def point(self) -> tuple[float, list[float]]:
        """The last point before the step that was looked at."""
        return float(self.trail[0]), self.trail[1 : 1 + self.size].tolist()

    def note(self) -> bool:
        """Take the point of the workspace, of a step's end or of the last row in the step; whether
        a pole lies before it."""
        n, before = 1 + self.size, self._last
        self._last = here = self._pick(self.kernel.w)
        if not before:
            return False
        steep = self._least_way / abs(here[0]) if here[0] else math.inf
        for i in range(n, len(here)):  # asked after every step
            a, b = before[i], here[i]
            turned = a < 0.0 < b or b < 0.0 < a
            if b > steep or b < -steep or (turned and self._is_off(i - n, before, here)):
                break
        else:
            return False
        self.trail[: 2 * n - 1] = before
        return self.lies_before()

    def _is_off(self, i: int, before: Sequence[float], here: Sequence[float]) -> bool:
        """Whether state i is far from where the trapezoidal rule leads between two points."""
        n = self.size
        h, y0, y1 = float(here[0] - before[0]), float(before[1 + i]), float(here[1 + i])
        f0, f1 = float(before[1 + n + i]), float(here[1 + n + i])
        size = max(abs(f0), abs(f1))
        if f0 == 0 or f1 == 0 or not size > self.trail[1 + 2 * n + i]:
            return False
        if not h * size * GROWTH > self.trail[1 + 4 * n + i]:
            return False
        return abs(y1 - y0 - h * (f0 + f1) / 2) > MISFIT * h * size

    def _here(self) -> tuple[float, Vector]:
        import numpy as np

        t, *ends = self._pick(self.kernel.w)
        return float(t), np.array(ends)

    def lies_before(self) -> bool:
        """Whether a derivative that changes its sign between the last point and the workspace's has
        a pole there. If not, that becomes the last point."""
        import numpy as np

        n, (begin, start), (t, ends) = self.size, self.point, self._here()
        if math.isnan(begin):  # the first point after an event
            self.trail[0], self.trail[1 : 1 + 2 * n] = t, ends
            return False
        f0, (y, f1) = self.trail[1 + n : 1 + 2 * n].copy(), ends.reshape(2, n)
        least, ways, absolute = self.trail[1 + 2 * n :].reshape(3, n)
        size = np.maximum(abs(f0), abs(f1))
        odd = (np.sign(f0) * np.sign(f1) < 0) & ((t - begin) * size * GROWTH > absolute)
        step = (begin, start), (t, y.tolist())
        for i in np.flatnonzero(odd).tolist():
            if self._grows(i, float(f0[i]), float(size[i]), *step):
                return True
        way = abs(t * f1) / (1 + abs(y))
        steep = (way > ways) & ~odd
        rates_at = self._along(*step)
        for i in np.flatnonzero(steep).tolist():
            if self._rises(i, float(size[i]), rates_at):
                return True
        self.kernel.rhs(t, y.tolist(), [0.0] * n)
        least[odd] = np.maximum(least[odd], LARGER * size[odd])
        ways[steep] = 2 * way[steep]
        self._least_way = float(ways.min(initial=math.inf))
        self.trail[0], self.trail[1 : 1 + 2 * n] = t, ends
        return False

    def _along(
        self, begin: tuple[float, Sequence[float]], end: tuple[float, Sequence[float]]
    ) -> Callable[[float], tuple[int, Sequence[float]]]:
        """The kernel's flag and the derivatives at a part of a step, each evaluated once: the
        sections of several states meet at the same parts."""
        (t0, y0), (t1, y1) = begin, end

        @cache
        def rates_at(part: float) -> tuple[int, Sequence[float]]:
            y, rates = [a + part * (b - a) for a, b in zip(y0, y1, strict=True)], [0.0] * self.size
            return self.kernel.rhs(t0 + part * (t1 - t0), y, rates), rates

        return rates_at

    def _rises(
        self, i: int, size: float, rates_at: Callable[[float], tuple[int, Sequence[float]]]
    ) -> bool:
        """Whether derivative i has a pole where the step leads: by golden section."""

        def height(part: float) -> float:
            flag, rates = rates_at(part)
            if flag > 0:  # a block has no solution so far ahead: that is no pole
                return 0.0
            return abs(rates[i]) if flag == 0 and math.isfinite(rates[i]) else math.inf

        low, high = 0.0, 1.0 + AHEAD
        if rates_at(high)[0] > 0:
            return False  # a loop does not close there: near its dead point rates grow, too
        a, b = high - SECTION * (high - low), low + SECTION * (high - low)
        left, right = height(a), height(b)
        for done in range(2 * HALVINGS):
            highest = max(left, right)
            if highest > GROWTH * size or (done > SOON and highest < 2 * size):
                return highest > GROWTH * size
            if left > right:
                high, b, right = b, a, left
                a = high - SECTION * (high - low)
                left = height(a)
            else:
                low, a, left = a, b, right
                b = low + SECTION * (high - low)
                right = height(b)
        return False

    def _grows(
        self,
        i: int,
        first: float,
        size: float,
        begin: tuple[float, Sequence[float]],
        end: tuple[float, Sequence[float]],
    ) -> bool:
        (t0, y0), (t1, y1) = begin, end
        low, high, ends, ydot = 0.0, 1.0, [abs(first), size], [0.0] * self.size
        for _ in range(HALVINGS):
            part = 0.5 * (low + high)
            y = [a + part * (b - a) for a, b in zip(y0, y1, strict=True)]
            flag = self.kernel.rhs(t0 + part * (t1 - t0), y, ydot)
            if flag < 0 or not math.isfinite(ydot[i]):
                return min(ends) > size / GROWTH
            if flag > 0:
                return False
            if ydot[i] * first > 0:
                low, ends[0] = part, abs(ydot[i])
            else:
                high, ends[1] = part, abs(ydot[i])
            if min(ends) > GROWTH * size:
                return True
            if max(ends) < size / LARGER:  # it goes through zero
                return False
        return False
