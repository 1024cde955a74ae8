"""IDA: the equations in residual form, blocks and step solved by one Newton iteration.

Users of other Modelica tools look for a solver of differential-algebraic equations, and it is
the second, independent formulation that CVODE's runs are compared with.

The unknowns are the states and, beside them, what the torn blocks are solved for: dependent
coordinates and velocities, accelerations and forces that were torn.

    F(t, z, z') = | y' - f |   derivatives as the explicit formulas give them
                  |   r    |   residuals of all blocks, of index 1 after its reduction

So no block is solved within a step: where Newton's method for a block alone does not
converge, its unknowns are corrected together with the states, from a prediction of
the order of the method. The error test is that of the states, as with the other solvers,
which solve the blocks exactly, and of the same size. Rows and relations are evaluated
with blocks solved from IDA's values, which only polishes them. Every evaluation comes
back to Python, so it is slower than CVODE. Roots are located on IDA's interpolation.

Of larger models the Jacobian of F comes from formulas, in one evaluation, and by differences
only where a formula has no derivative. Evaluations of F, and CPU seconds of a run, native,
at 1e-6:

    unknowns                          differences      formulas
    five four-bars, 10 s        43    8795  0.19       1163  0.06
    chain of 10 rods, 2 s       20    1991  0.05        840  0.04
    chain of 40 rods, 2 s       80    8246  0.40        994  0.10

Reference: K. E. Brenan, S. L. Campbell, L. R. Petzold, Numerical Solution of
           Initial-Value Problems in Differential-Algebraic Equations, SIAM 1996.
"""

from __future__ import annotations

import ctypes as C
import math
from collections.abc import Sequence
from typing import Any

from planarc.core.options import Solver
from planarc.ir.kernel import Kernel, Unknowns
from planarc.ir.newton import DIFFERENCE
from planarc.runtime.differences import one_sided
from planarc.solve.solvers.integrator import Cause, Counts, March, Outcome, Settings
from planarc.solve.solvers.session import ONE_STEP, Session
from planarc.solve.solvers.stepping import SteppingIntegrator, Unsolved
from planarc.solve.solvers.sundials import Unavailable, open_ida

#: Length of a step, as a part of the run, and how many shorter ones in a row are a point that
#: cannot be passed.
SHORTEST, MOST_SHORT = 1e-11, 20
_CAUSES = {
    -2: Cause.ACCURACY,
    -3: Cause.ERROR_TEST,
    -4: Cause.CONVERGENCE,
    -6: Cause.CONVERGENCE,
    -7: Cause.CONVERGENCE,
    -8: Cause.BLOCK,
    -9: Cause.BLOCK,
    -12: Cause.BLOCK,
}
_RESIDUAL = C.CFUNCTYPE(C.c_int, C.c_double, *(C.c_void_p,) * 4)
_JACOBIAN = C.CFUNCTYPE(C.c_int, C.c_double, C.c_double, *(C.c_void_p,) * 8)
#: Unknowns from which compiling derivatives is cheaper than differences.
FEWEST_UNKNOWNS = 16
#: Least size of an unknown for differences of F, in its absolute tolerance.
SMALLEST = 1e3


def make(_: Solver, kernel: Kernel, states: int, settings: Settings) -> IdaIntegrator:
    return IdaIntegrator(kernel, states, settings)


class IdaIntegrator(SteppingIntegrator):
    """IDA with the kernel's residual form. Raises `Unavailable` where the library is missing."""

    name = "ida"

    def __init__(self, kernel: Kernel, states: int, settings: Settings) -> None:
        form = kernel.capabilities.residual_form
        if form is None:
            raise Unavailable("this kernel has no residual form")
        super().__init__(kernel, states, settings)
        self._equations = form
        self._session = Session(open_ida(), "IDA")
        self._begun = False
        self._total = Counts()
        self._flag = self._short = 0
        self._reached = C.c_double()
        self._unknowns = Unknowns([], [], [], [])
        self._smallest: list[float] = []

    # Setting up

    def _begin(self, absolute: Sequence[float], step: float | None) -> None:
        self._absolute, self._first, self._begun = list(absolute), step, False

    def _make(self, limit: float) -> None:
        """Begin anew at the present point, whose blocks are solved."""
        session = self._session
        self._free()
        ydot = self._rhs(self._t, self._y)
        self._unknowns = self._equations.unknowns()
        size = self._size + len(self._unknowns.slots)
        self._vectors, numbers = session.vectors(5, size)
        tolerance = self._fill(numbers, ydot)
        z, zdot, tolerances, differential, _ = self._vectors
        session.create()
        self._residual = _RESIDUAL(session.guarded(self._residuals))
        session.check("Init", self._residual, self._t, z, zdot)
        session.call("SVtolerances", tolerance, tolerances)
        session.call("SetId", differential)
        session.call("SetSuppressAlg", 1)
        session.eliminate(size, z)
        self.formulas = size >= FEWEST_UNKNOWNS and self._derived(self._t, self._z) is not None
        if self.formulas:
            self._callback = _JACOBIAN(session.guarded(self._jacobian_of))
            session.call("SetJacFn", self._callback)
        session.call("SetMaxNumSteps", -1)
        session.call("SetMaxErrTestFails", 20)
        session.call("SetMaxConvFails", 20)
        if self._settings.span > 0:
            session.call("SetMaxStep", self._longest_step)
        if self._first:
            session.call("SetInitStep", min(self._first, limit - self._t))
        self._begun, self._first = True, None

    def _fill(self, numbers: Sequence[Any], ydot: Sequence[float]) -> float:
        """The vectors of values, rates, tolerances and kinds; gives the relative tolerance."""
        self._z, rates, absolute, kinds, self._dense = numbers
        unknowns, w = self._unknowns, self._kernel.w
        # IDA takes the mean over all unknowns though only states are tested: put that right.
        part = math.sqrt(self._size / len(self._z))
        tolerance = part * self._settings.tolerance
        self._z[:] = [*self._y, *(w[s] for s in unknowns.slots)]
        rates[:] = [*ydot, *(w[s] if s >= 0 else 0.0 for s in unknowns.rates)]
        nominals = (abs(w[s]) if s >= 0 else 1.0 for s in unknowns.nominals)
        absolute[:] = [
            *(part * a for a in self._absolute),
            *(tolerance * (n or 1.0) for n in nominals),
        ]
        self._smallest = list(absolute)
        kinds[:] = [1.0] * self._size + [0.0] * len(unknowns.slots)
        return tolerance

    # The equations as IDA calls them

    def _parts(self, z: Any) -> tuple[list[float], list[float]]:
        """The states, and the unknowns of the blocks."""
        values = z[:]
        return values[: self._size], values[self._size :]

    def _derived(self, t: float, z: Any) -> Any:
        """d(f, r)/dz, or None where there is no formula."""
        return self._equations.residual_jacobian(t, *self._parts(z), self._unknowns)

    def _form(self, t: float, z: Any) -> tuple[int, list[float]]:
        """The flag, and -f and r at these values."""
        flag, rates, residuals = self._equations.residual_form(t, *self._parts(z), self._unknowns)
        self._calls += 1
        return flag, [*(-f for f in rates), *residuals]

    def _residuals(self, t: float, z: int, zdot: int, result: int, _: object) -> int:
        """F."""
        n, size, numbers = self._size, len(self._z), self._session.numbers
        flag, values = self._form(t, numbers(z, size))
        if flag != 0:
            self._flag = flag
            return 1
        given = numbers(zdot, size)[:n]
        values[:n] = [a + b for a, b in zip(given, values[:n], strict=True)]
        numbers(result, size)[:] = values
        total = sum(values)
        return 0 if total - total == 0.0 else 1

    def _jacobian_of(
        self, t: float, rate: float, z: int, zdot: int, result: int, matrix: int, *_: object
    ) -> int:
        """dF/dz + rate*dF/dz'."""
        n, values = self._size, self._session.numbers(z, len(self._z))
        found = self._derived(t, values)
        if found is None:
            found = self._differences(t, list(values))
        if found is None:
            return 1
        found[:n] *= -1.0
        found[range(n), range(n)] += rate
        self._session.fill(matrix, found)
        return 0

    def _differences(self, t: float, z: list[float]) -> Any:
        """d(f, r)/dz by forward differences, or None."""
        import numpy as np

        def form(at: Any) -> Any:
            flag, values = self._form(t, at.tolist())
            return None if flag else values

        sizes = zip(z, self._smallest, strict=True)
        steps = [DIFFERENCE * max(abs(v), SMALLEST * least) for v, least in sizes]
        found = one_sided(form, z, steps)
        if found is None or not np.isfinite(found).all():
            return None
        found[: self._size] *= -1.0
        return found

    # On the way

    def step(self, limit: float) -> March:
        session, self._flag = self._session, 0
        if not self._begun:
            try:
                self._make(limit)
            except Unsolved:
                return March(Outcome.FAILED, cause=Cause.BLOCK)
        session.call("SetStopTime", limit)
        z, zdot = self._vectors[:2]
        flag = session.call("Solve", limit, C.byref(self._reached), z, zdot, ONE_STEP)
        session.reraise()
        if flag < 0:
            return March(Outcome.FAILED, cause=self._cause(flag))
        shortest = SHORTEST * max(self._settings.span, abs(self._reached.value))
        self._short = self._short + 1 if self.last_step() < shortest else 0
        if self._short > MOST_SHORT:
            return March(Outcome.FAILED, cause=Cause.NOT_FINITE if self._flag < 0 else Cause.STEP)
        self._take(self._reached.value, self._z)
        return self._rooted(self._reached.value, list(self._z[: self._size]), limit)

    def _cause(self, flag: int) -> Cause:
        if self._flag < 0 and flag in (-8, -9, -12, -4):
            return Cause.NOT_FINITE
        return _CAUSES.get(flag, Cause.STEP)

    def _take(self, t: float, z: Any) -> None:
        """Let the blocks start from these values when they are solved here."""
        flag, _, _ = self._equations.residual_form(t, *self._parts(z), self._unknowns)
        if flag == 0:
            self._kernel.accept(t)

    def interpolate(self, t: float) -> Sequence[float]:
        self._session.call("GetDky", t, 0, self._vectors[4])
        self._take(t, self._dense)
        return self._dense[: self._size]  # type: ignore[no-any-return]

    # What it did, and the end

    def last_step(self) -> float:
        return self._session.last_step()

    def errors(self) -> Sequence[float]:
        if not self._session.present:
            return ()
        return self._session.errors(len(self._z))[: self._size]

    def counts(self) -> Counts:
        if not self._session.present:
            return self._total
        names = ("NumSteps", "NumResEvals", "NumLinResEvals", "NumJacEvals", "NumErrTestFails")
        steps, calls, more, jacobians, failures = map(self._session.number, names)
        return self._total + Counts(steps, calls + more, jacobians, failures)

    def _free(self) -> None:
        self._total = self.counts()
        self._session.free()

    def close(self) -> None:
        self._free()
        self._session.close()
