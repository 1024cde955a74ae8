"""What integrators that step in Python have in common.

Where they are, the zero functions there, the march by single steps, and roots located
on their own interpolation.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from planarc.ir.kernel import Kernel
from planarc.solve.solvers.integrator import Cause, Counts, Integrator, March, Outcome, Settings
from planarc.solve.solvers.locate import crossed, locate


class Unsolved(Exception):
    """The kernel's flag, on its way out of a step."""

    def __init__(self, flag: int) -> None:
        self.flag = flag

    def march(self) -> March:
        """The step that failed."""
        cause = Cause.NOT_FINITE if self.flag < 0 else Cause.BLOCK
        return March(Outcome.FAILED, cause=cause)


class SteppingIntegrator(Integrator):
    """No step is longer than `longest` times the run."""

    longest = 1 / 50

    def __init__(self, kernel: Kernel, states: int, settings: Settings) -> None:
        super().__init__(kernel, states, settings)
        self._t, self._y = 0.0, [0.0] * states
        self._directions: Sequence[int] = ()
        self._g: list[float] = []
        self._steps = self._calls = 0

    @property
    def t(self) -> float:
        return self._t

    @property
    def y(self) -> list[float]:
        return list(self._y)

    @property
    def _longest_step(self) -> float:
        return min(self._settings.span * self.longest, self._settings.longest_step)

    def restart(
        self,
        t: float,
        y: Sequence[float],
        absolute: Sequence[float],
        directions: Sequence[int],
        step: float | None = None,
    ) -> None:
        self._t, self._y = t, [float(v) for v in y]
        self._directions = directions
        self._begin_dips(t, self._y, directions)
        self._g = [0.0] * self._settings.relations
        if self._g:
            self._relations.roots(t, self._y, self._g)
        self._begin(absolute, step)

    @abstractmethod
    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        """Begin anew with these absolute tolerances, and the first step to try."""

    def _zeros(self) -> Sequence[float]:
        return self._g

    def _go_back(self, t: float, y: Sequence[float]) -> None:
        self._t, self._y = t, list(y)

    def counts(self) -> Counts:
        return Counts(self._steps, self._calls)

    def _rhs(self, t: float, y: Sequence[float]) -> list[float]:
        """The derivatives of the states, or `Unsolved`."""
        ydot = [0.0] * self._size
        self._calls += 1
        flag = self._kernel.rhs(t, y, ydot)
        if flag != 0:
            raise Unsolved(flag)
        return ydot

    def _rooted(self, t: float, y: list[float], limit: float) -> March:
        """Go to `t`, the end of a step, or to the first root in it."""
        g = [0.0] * len(self._g)
        if g:
            if self._relations.roots(t, y, g) != 0:
                return March(Outcome.FAILED, cause=Cause.BLOCK)
            if any(crossed(self._g, g, self._directions)):
                begin = (self._t, self._g)
                found = locate(self._relations, self.interpolate, begin, (t, g), self._directions)
                if found is None:
                    return March(Outcome.FAILED, cause=Cause.BLOCK)
                self._t, self._y = found[0], list(self.interpolate(found[0]))
                return March(Outcome.ROOT, tuple(found[1]))
        self._t, self._y, self._g = t, y, g
        return March(Outcome.LIMIT if t >= limit else Outcome.BUDGET)
