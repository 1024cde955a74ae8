"""The run of a model without states: rows, one after the other, and events between them.

A fully driven mechanism has nothing to integrate, but its nonlinear blocks still
follow their branch from point to point, so that steps must not be too long: where the
equations cannot be solved, the step is halved.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.kernel import Kernel
from planarc.solve.solvers.integrator import Cause, March, Outcome, Settings
from planarc.solve.solvers.stepping import SteppingIntegrator

_SHORTEST = 1e-12


class Stateless(SteppingIntegrator):
    name = "none"
    longest = 1 / 500

    def __init__(self, kernel: Kernel, settings: Settings) -> None:
        super().__init__(kernel, 0, settings)
        self._step = 0.0

    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        self._step = self._longest_step

    def step(self, limit: float) -> March:
        begin, self._step = self._t, min(2 * self._step, self._longest_step)
        while True:
            t = min(begin + self._step, limit)
            if limit - t < 1e-3 * self._step:
                t = limit
            if self._kernel.outputs(t, ()) == 0:
                break
            self._step /= 2
            if self._step < _SHORTEST * max(self._settings.span, abs(begin)):
                return March(Outcome.FAILED, cause=Cause.BLOCK)
        self._steps += 1
        return self._rooted(t, [], limit)

    def interpolate(self, t: float) -> Sequence[float]:
        return ()

    def last_step(self) -> float:
        return self._step
