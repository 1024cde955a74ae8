"""The integrators of scipy: LSODA and BDF, where CVODE is missing or was not asked for.

Their steps are Python, so they are slower, and they know nothing of events: roots are
located on their dense output. Where a trial point cannot be evaluated, they are started
again from the last accepted point with a shorter step.

Near an isolated singular position (the flat N-four-bar) accelerations are the quotient of
two small numbers. CVODE, IDA and LSODA step over it at any tolerance; scipy's `BDF` does at
1e-6, but at 1e-9 its steps shrink towards it until it gives up, and says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

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

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_NAMES = {"LSODA": "lsoda (scipy)", "BDF": "scipy-bdf"}
_LONGEST = 1 / 50
_RETRIES = 12
#: With fewer states differences of the right-hand side are cheaper than its derivatives.
FEWEST_DERIVED = 8


class _Failed(Exception):
    """The kernel's flag, on its way through scipy."""

    def __init__(self, flag: int) -> None:
        self.flag = flag


class ScipyIntegrator:
    def __init__(self, kernel: Kernel, states: int, settings: Settings, method: str) -> None:
        self.name = _NAMES[method]
        self._method, self._kernel, self._settings = method, kernel, settings
        self._size = states
        self._solver: Any = None
        self._dense: Any = None
        self._limit: float | None = None
        self._steps = self._calls = self._jacobians = 0
        self._t, self._y = 0.0, [0.0] * states
        self._absolute: list[float] = []
        self._directions: Sequence[int] = ()
        self._g: list[float] = []
        self._first: float | None = None

    @property
    def t(self) -> float:
        return self._t

    @property
    def y(self) -> list[float]:
        return list(self._y)

    def restart(
        self,
        t: float,
        y: Sequence[float],
        absolute: Sequence[float],
        directions: Sequence[int],
        step: float | None = None,
    ) -> None:
        self._t, self._y = t, [float(v) for v in y]
        self._absolute, self._directions = list(absolute), directions
        self._g = [0.0] * self._settings.relations
        if self._g:
            self._kernel.roots(t, self._y, self._g)
        self._forget(step)

    def _forget(self, step: float | None) -> None:
        """The next step begins anew, of the first order."""
        self._jacobians += self._present_jacobians()
        self._solver, self._limit, self._first = None, None, step

    def _present_jacobians(self) -> int:
        return int(self._solver.njev or 0) if self._solver is not None else 0

    def _rhs(self, t: float, y: NDArray[np.float64]) -> list[float]:
        ydot = [0.0] * self._size
        self._calls += 1
        flag = self._kernel.rhs(t, y.tolist(), ydot)
        if flag != 0:
            raise _Failed(flag)
        return ydot

    def _jacobian(self, t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """From the formulas; by differences at a point where these have no derivative."""
        import numpy as np

        found = self._kernel.state_jacobian(t, y.tolist())  # type: ignore[attr-defined]
        if found is not None:
            return found  # type: ignore[no-any-return]
        here = np.array(self._rhs(t, y))
        columns = []
        for j in range(self._size):
            moved = y.copy()
            moved[j] += 1.5e-8 * max(1.0, abs(y[j]))
            columns.append((np.array(self._rhs(t, moved)) - here) / (moved[j] - y[j]))
        return np.array(columns).T

    @property
    def _longest_step(self) -> float:
        return min(self._settings.span * _LONGEST, self._settings.longest_step)

    def _make(self, limit: float) -> None:
        import numpy as np
        from scipy import integrate

        room = limit - self._t
        first = min(self._first, room, self._longest_step) if self._first else None
        self._jacobians += self._present_jacobians()
        self._limit = limit
        derived = self._size >= FEWEST_DERIVED and hasattr(self._kernel, "state_jacobian")
        self._solver = getattr(integrate, self._method)(
            self._rhs,
            self._t,
            np.array(self._y),
            limit,
            rtol=max(self._settings.tolerance, 3e-14),
            atol=np.array(self._absolute),
            max_step=max(self._longest_step, 1e-300),
            first_step=first,
            jac=self._jacobian if derived else None,
        )

    def march(self, limit: float, recorder: Recorder, watch: Watch, steps: int) -> March:
        past = self._settings.past
        return march_steps(self, self._kernel, limit, recorder, watch, steps, past)

    def step(self, limit: float) -> March:
        shorter = 0
        while True:
            try:
                if self._solver is None or self._limit != limit:
                    self._make(limit)
                message = self._solver.step()
                break
            except _Failed as problem:
                last = self._solver.step_size if self._solver is not None else None
                step = (last or self._settings.span * _LONGEST) * 0.1 ** (shorter + 1)
                self._forget(step)
                shorter += 1
                if shorter > _RETRIES:
                    cause = Cause.NOT_FINITE if problem.flag < 0 else Cause.BLOCK
                    return March(Outcome.FAILED, cause=cause)
        if self._solver.status == "failed":
            cause = Cause.ERROR_TEST if "step" in str(message) else Cause.CONVERGENCE
            return March(Outcome.FAILED, cause=cause)
        self._steps += 1
        self._dense = None
        return self._rooted(float(self._solver.t), self._solver.y, limit)

    def _rooted(self, t: float, state: NDArray[np.float64], limit: float) -> March:
        """The step to `t`, or to the first root in it."""
        begin = self._t
        g = [0.0] * len(self._g)
        if g:
            if self._kernel.roots(t, state.tolist(), g) != 0:
                return March(Outcome.FAILED, cause=Cause.BLOCK)
            if any(crossed(self._g, g, self._directions)):
                found = locate(
                    self._kernel, self.interpolate, (begin, self._g), (t, g), self._directions
                )
                if found is None:
                    return March(Outcome.FAILED, cause=Cause.BLOCK)
                self._t, self._y = found[0], list(self.interpolate(found[0]))
                return March(Outcome.ROOT, tuple(found[1]))
        self._t, self._y, self._g = t, state.tolist(), g
        return March(Outcome.LIMIT if t >= limit else Outcome.BUDGET)

    def interpolate(self, t: float) -> Sequence[float]:
        if self._dense is None:
            self._dense = self._solver.dense_output()
        return self._dense(t).tolist()  # type: ignore[no-any-return]

    def last_step(self) -> float:
        return float(self._solver.step_size or 0.0) if self._solver is not None else 0.0

    def counts(self) -> Counts:
        return Counts(self._steps, self._calls, self._jacobians + self._present_jacobians())

    def close(self) -> None:
        self._solver = self._dense = None
