"""The run of a model without states: rows, one after the other, and events between them.

A fully driven mechanism has nothing to integrate, but its nonlinear blocks still
follow their branch from point to point, so that steps must not be too long: where the
equations cannot be solved, or their unknowns move far, the step is halved. So what jumps
from one branch to another does so at an instant.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.kernel import Kernel
from planarc.solve.solvers.integrator import Cause, March, Outcome, Settings
from planarc.solve.solvers.stepping import SteppingIntegrator

_SHORTEST = 1e-12
#: A step within which an unknown moves by more than `FAR` relative to max(1, |x|) is no longer than
#: `JUMP`, a part of the run.
FAR, JUMP = 0.1, 1e-10


class Stateless(SteppingIntegrator):
    name = "none"
    longest = 1 / 500

    def __init__(self, kernel: Kernel, settings: Settings) -> None:
        super().__init__(kernel, 0, settings)
        self._step = 0.0

    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        self._step = self._longest_step
        self._here = self._tears()

    def _tears(self) -> list[float]:
        return [self._kernel.w[slot] for slot in self._settings.tears]

    def step(self, limit: float) -> March:
        begin, self._step = self._t, min(2 * self._step, self._longest_step)
        while True:
            t = min(begin + self._step, limit)
            if limit - t < 1e-3 * self._step:
                t = limit
            if self._kernel.outputs(t, ()) == 0 and self._is_near(t - begin):
                break
            self._step /= 2
            if self._step < _SHORTEST * max(self._settings.span, abs(begin)):
                return March(Outcome.FAILED, cause=Cause.BLOCK)
        self._steps += 1
        self._here = self._tears()
        return self._rooted(t, [], limit)

    def _is_near(self, step: float) -> bool:
        """Whether nothing has moved far, unless within next to no time."""
        pairs = zip(self._here, self._tears(), strict=True)
        near = all(abs(b - a) <= FAR * max(1.0, abs(a)) for a, b in pairs)
        return near or step <= JUMP * self._settings.span

    def interpolate(self, t: float) -> Sequence[float]:
        return ()

    def last_step(self) -> float:
        return self._step
