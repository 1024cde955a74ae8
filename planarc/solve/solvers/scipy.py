"""The integrators of scipy: LSODA and BDF, where CVODE is missing or was not asked for.

Their steps are Python, so they are slower, and they know nothing of events: roots are
located on their dense output. Where a trial point cannot be evaluated, they are started
again from the last accepted point with a shorter step.

Near an isolated singular position (the flat N-four-bar) accelerations are the quotient of
two small numbers. An angle d away from it positions are known to 1e-16/d, velocities to
1e-16/d^2 and accelerations to 1e-15/d^3: no better than 1e-6 within a thousandth of a radian.
Who lands there rejects the step, comes nearer with shorter ones, and gives up. At 1e-6 all
solvers step over it; scipy's `BDF` fails below 1e-8, as its steps grow again only after
several of one length, LSODA at most tolerances below 1e-9, and the others where they are
unlucky, mostly from 1e-11 on. The run then says where it ended.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from planarc.core.options import Solver
from planarc.ir.kernel import Kernel
from planarc.ir.newton import DIFFERENCE
from planarc.runtime.differences import one_sided
from planarc.solve.solvers.integrator import (
    FEWEST_DERIVED,
    Cause,
    Counts,
    March,
    Outcome,
    Settings,
)
from planarc.solve.solvers.stepping import SteppingIntegrator, Unsolved

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_NAMES = {"LSODA": "lsoda (scipy)", "BDF": "scipy-bdf"}
_RETRIES = 12


def make(solver: Solver, kernel: Kernel, states: int, settings: Settings) -> ScipyIntegrator:
    return ScipyIntegrator(
        kernel, states, settings, "BDF" if solver is Solver.SCIPY_BDF else "LSODA"
    )


class ScipyIntegrator(SteppingIntegrator):
    ends_evaluated = True

    def __init__(self, kernel: Kernel, states: int, settings: Settings, method: str) -> None:
        super().__init__(kernel, states, settings)
        self.name, self._method = _NAMES[method], method
        offered = kernel.capabilities
        self._formulas = offered.formulas
        # Differences of machine code cost less than compiling its derivatives.
        derives = offered.formulas is not None and offered.machine is None
        self.formulas = derives and states >= FEWEST_DERIVED
        self._solver: Any = None
        self._dense: Any = None
        self._limit: float | None = None
        self._jacobians = 0
        self._absolute: list[float] = []
        self._first: float | None = None

    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        self._absolute = list(absolute)
        self._forget(step)

    def _forget(self, step: float | None) -> None:
        """The next step begins anew, of the first order."""
        self._jacobians += self._present_jacobians()
        self._solver, self._limit, self._first = None, None, step

    def _present_jacobians(self) -> int:
        return int(self._solver.njev or 0) if self._solver is not None else 0

    def _of_array(self, t: float, y: NDArray[np.float64]) -> list[float]:
        ydot = self._rhs(t, y.tolist())
        if self._is_far():
            raise Unsolved(1)
        return ydot

    def _jacobian(self, t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        """The Jacobian from formulas; by differences at a point where these have no derivative."""
        assert self._formulas is not None
        found = self._formulas.state_jacobian(t, y.tolist())
        if found is not None:
            return found  # type: ignore[no-any-return]
        steps = [DIFFERENCE * max(1.0, abs(v)) for v in y]
        found = one_sided(lambda at: self._of_array(t, at), y, steps)
        assert found is not None
        return found

    def _make(self, limit: float) -> None:
        import numpy as np
        from scipy import integrate

        room = limit - self._t
        first = min(self._first, room, self._longest_step) if self._first else None
        self._jacobians += self._present_jacobians()
        self._limit = limit
        self._solver = getattr(integrate, self._method)(
            self._of_array,
            self._t,
            np.array(self._y),
            limit,
            rtol=max(self._settings.tolerance, 3e-14),
            atol=np.array(self._absolute),
            max_step=max(self._longest_step, 1e-300),
            first_step=first,
            jac=self._jacobian if self.formulas else None,
        )

    def step(self, limit: float) -> March:
        shorter = 0
        self._begin_step()
        while True:
            try:
                if self._solver is None or self._limit != limit:
                    self._make(limit)
                message = self._solver.step()
                break
            except Unsolved as problem:
                last = self._solver.step_size if self._solver is not None else None
                step = (last or self._settings.span * self.longest) * 0.1 ** (shorter + 1)
                self._forget(step)
                shorter += 1
                if shorter > _RETRIES:
                    return problem.march()
        if self._solver.status == "failed":
            cause = Cause.ERROR_TEST if "step" in str(message) else Cause.CONVERGENCE
            return March(Outcome.FAILED, cause=cause)
        self._steps += 1
        self._dense = None
        return self._rooted(float(self._solver.t), self._solver.y.tolist(), limit)

    def interpolate(self, t: float) -> Sequence[float]:
        if self._dense is None:
            self._dense = _interpolant(self._solver.dense_output())
        return self._dense(t)  # type: ignore[no-any-return]

    def last_step(self) -> float:
        return float(self._solver.step_size or 0.0) if self._solver is not None else 0.0

    def counts(self) -> Counts:
        return Counts(self._steps, self._calls, self._jacobians + self._present_jacobians())

    def close(self) -> None:
        self._solver = self._dense = None


def _interpolant(dense: Any) -> Callable[[float], list[float]]:
    """scipy's dense output of one step, for single times: its arrays of a few numbers take
    longer than the numbers. LSODA's is a polynomial in (t - its t)/h for each state."""
    if not all(hasattr(dense, name) for name in ("yh", "h", "t")):
        return lambda t: dense(t).tolist()
    end, h = float(dense.t), float(dense.h)
    rows = [row[::-1] for row in dense.yh.tolist()]

    def states(t: float) -> list[float]:
        x, found = (t - end) / h, []
        for row in rows:
            value = 0.0
            for coefficient in row:
                value = value * x + coefficient
            found.append(value)
        return found

    return states
