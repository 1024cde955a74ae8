"""Steps of one length: Euler's explicit method and the classical method of Runge and Kutta.

As a controller in real time takes them: H is never shortened for accuracy, so the
tolerance does not count and a step that is too long is seen only in the result.

Events are located to the step: a relation that has switched within a step is treated
at the step's end, at most H late. Instants known beforehand (`time >= t0`, `sample`) and
the end of the run are met exactly: the step before them is shorter, and the next one
starts there. Rows between two steps are interpolated by a cubic through values and
derivatives at both ends.

Reference: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential
           Equations I, Springer 1993, sections II.1 and II.6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from planarc.core.options import Solver
from planarc.ir.kernel import Kernel
from planarc.solve.solvers.integrator import Cause, March, Outcome, Settings
from planarc.solve.solvers.locate import crossed
from planarc.solve.solvers.stepping import SteppingIntegrator, Unsolved
from planarc.solve.solvers.sundials import Unavailable

#: A rest shorter than this part of a step is added to the step before it.
REST = 1e-9

Values = list[float]


def make(solver: Solver, kernel: Kernel, states: int, settings: Settings) -> FixedStep:
    if settings.fixed_step is None:
        raise Unavailable("it needs the length of its steps")
    return FixedStep(kernel, states, settings, solver.value, settings.fixed_step)


class FixedStep(SteppingIntegrator):
    """`length` is the step in seconds; `method` is `euler` or `rk4`."""

    adapts = False

    def __init__(
        self, kernel: Kernel, states: int, settings: Settings, method: str, length: float
    ) -> None:
        super().__init__(kernel, states, settings)
        self.name = f"{method} (fixed step {length:g} s)"
        self._length = min(length, settings.longest_step)
        steps: dict[str, Callable[[float, float], Values]] = {
            "euler": self._euler,
            "rk4": self._rk4,
        }
        self._advance = steps[method]
        self._origin, self._index = 0.0, 0  # times are multiples of the step, not their sums
        self._slope = [0.0] * states
        self._before = (0.0, self._y, self._slope)

    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        self._origin, self._index = self._t, 0
        self._slope = [0.0] * self._size
        self._calls += 1
        self._kernel.rhs(self._t, self._y, self._slope)
        self._before = (self._t, self._y, self._slope)

    def step(self, limit: float) -> March:
        begin, t = self._t, self._next(limit)
        try:
            y = self._advance(begin, t - begin)
            if not all(map(math.isfinite, y)):
                return March(Outcome.FAILED, cause=Cause.NOT_FINITE)
            slope = self._rhs(t, y)
        except Unsolved as problem:
            return problem.march()
        self._before = (begin, self._y, self._slope)
        self._slope = slope
        self._steps += 1
        return self._rooted(t, y, limit)

    def _next(self, limit: float) -> float:
        """Where the next step ends; at a limit the steps begin anew."""
        t = self._origin + (self._index + 1) * self._length
        if t > limit - REST * self._length:
            self._origin, self._index = limit, 0
            return limit
        self._index += 1
        return t

    def _rooted(self, t: float, y: Values, limit: float) -> March:
        """Whether a relation has switched within the step: it is treated at its end."""
        self._t, self._y = t, y
        if self._g:
            g = [0.0] * len(self._g)
            if self._relations.roots(t, y, g) != 0:
                return March(Outcome.FAILED, cause=Cause.BLOCK)
            found = crossed(self._g, g, self._directions)
            self._g = g
            if any(found):
                return March(Outcome.ROOT, tuple(found))
        return March(Outcome.LIMIT if t >= limit else Outcome.BUDGET)

    def _zeros(self) -> Values:
        return []  # what is switched within a step is treated at its end

    # The methods

    def _moved(self, h: float, slope: Values) -> Values:
        return [y + h * k for y, k in zip(self._y, slope, strict=True)]

    def _euler(self, t: float, h: float) -> Values:
        return self._moved(h, self._slope)

    def _rk4(self, t: float, h: float) -> Values:
        k1, half = self._slope, h / 2
        k2 = self._rhs(t + half, self._moved(half, k1))
        k3 = self._rhs(t + half, self._moved(half, k2))
        k4 = self._rhs(t + h, self._moved(h, k3))
        sums = [a + 2 * (b + c) + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        return self._moved(h / 6, sums)

    # Between the steps

    def interpolate(self, t: float) -> Sequence[float]:
        begin, y0, f0 = self._before
        h = self._t - begin
        if h <= 0 or t >= self._t:
            return list(self._y)
        s = (t - begin) / h
        a, b = s * s * (3 - 2 * s), s * (1 - s) * h
        return [
            p + a * (q - p) + b * ((1 - s) * u - s * v)
            for p, q, u, v in zip(y0, self._y, f0, self._slope, strict=True)
        ]

    def last_step(self) -> float:
        return self._length
