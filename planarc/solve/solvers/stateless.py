"""The run of a model without states: rows, one after the other, and events between them.

A fully driven mechanism has nothing to integrate, but its nonlinear blocks still
follow their branch from point to point, so that steps must not be too long: where the
equations cannot be solved, the step is halved.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.program import Kernel
from planarc.solve.recorder import Recorder
from planarc.solve.solvers.integrator import (
    Cause,
    Counts,
    March,
    Outcome,
    Settings,
    Watch,
    march_steps,
)
from planarc.solve.solvers.locate import crossed, locate

_LONGEST, _SHORTEST = 1 / 500, 1e-12


class Stateless:
    name = "none"

    def __init__(self, kernel: Kernel, settings: Settings) -> None:
        self._kernel, self._settings = kernel, settings
        self._t, self._step, self._count = 0.0, 0.0, 0
        self._directions: Sequence[int] = ()
        self._g: list[float] = []

    @property
    def t(self) -> float:
        return self._t

    @property
    def y(self) -> list[float]:
        return []

    def restart(
        self,
        t: float,
        y: Sequence[float],
        absolute: Sequence[float],
        directions: Sequence[int],
        step: float | None = None,
    ) -> None:
        self._t, self._directions = t, directions
        self._step = self._longest_step
        self._g = [0.0] * self._settings.relations
        self._kernel.roots(t, (), self._g)

    @property
    def _longest_step(self) -> float:
        return min(self._settings.span * _LONGEST, self._settings.longest_step)

    def march(self, limit: float, recorder: Recorder, watch: Watch, steps: int) -> March:
        past = self._settings.past
        return march_steps(self, self._kernel, limit, recorder, watch, steps, past)

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
        self._count += 1
        return self._roots(begin, t, limit)

    def _roots(self, begin: float, t: float, limit: float) -> March:
        g = [0.0] * len(self._g)
        if g:
            if self._kernel.roots(t, (), g) != 0:
                return March(Outcome.FAILED, cause=Cause.BLOCK)
            if any(crossed(self._g, g, self._directions)):
                found = locate(
                    self._kernel, lambda _: (), (begin, self._g), (t, g), self._directions
                )
                if found is None:
                    return March(Outcome.FAILED, cause=Cause.BLOCK)
                self._t = found[0]
                return March(Outcome.ROOT, tuple(found[1]))
        self._t, self._g = t, g
        return March(Outcome.LIMIT if t >= limit else Outcome.BUDGET)

    def interpolate(self, t: float) -> Sequence[float]:
        return ()

    def last_step(self) -> float:
        return self._step

    def counts(self) -> Counts:
        return Counts(steps=self._count)

    def close(self) -> None:
        pass
