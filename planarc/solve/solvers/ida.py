"""IDA: the equations in residual form, blocks and step solved by one Newton iteration.

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

from planarc.ir.kernel import Kernel
from planarc.ir.newton import DIFFERENCE
from planarc.runtime.differences import one_sided
from planarc.solve.solvers.integrator import Cause, Counts, March, Outcome, Settings
from planarc.solve.solvers.scipy import ScipyIntegrator
from planarc.solve.solvers.sundials import Unavailable, open_ida

_ONE_STEP = 2
#: So many steps in a row shorter than this part of the run: a point that cannot be passed.
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
#: With fewer unknowns differences are cheaper than compiling their derivatives.
FEWEST_UNKNOWNS = 16
#: Differences of F are taken with this part of an unknown, or of what its tolerance says.
SMALLEST = 1e3


class IdaIntegrator(ScipyIntegrator):
    """Raises `Unavailable` where the library is missing."""

    ends_evaluated = False  # residuals are evaluated, and blocks not solved

    def __init__(self, kernel: Kernel, states: int, settings: Settings) -> None:
        form = kernel.capabilities.residual_form
        if form is None:
            raise Unavailable("this kernel has no residual form")
        super().__init__(kernel, states, settings, "BDF")
        self.formulas = False
        self._equations = form
        self._lib = open_ida()
        self.name = "ida"
        self._context = C.c_void_p()
        self._lib.SUNContext_Create(0, C.byref(self._context))
        self._lib.SUNContext_ClearErrHandlers(self._context)
        self._memory = C.c_void_p()
        self._vectors: list[int] = []
        self._total = Counts()
        self._raised: BaseException | None = None
        self._flag = 0
        self._short = 0
        self._reached = C.c_double()
        self._unknowns: Any = None
        self._smallest: list[float] = []

    # Setting up

    def _make(self, limit: float) -> None:
        """Begin anew at the present point, whose blocks are solved."""
        lib, kernel = self._lib, self._kernel
        self._free()
        self._unknowns = unknowns = self._equations.unknowns()
        ydot = [0.0] * self._size
        if kernel.rhs(self._t, self._y, ydot) != 0:
            raise _UnsolvedError
        size = self._size + len(unknowns.slots)
        self._vectors = [lib.N_VNew_Serial(size, self._context) for _ in range(5)]
        self._z, rates, absolute, kinds, self._dense = (
            self._numbers(v, size) for v in self._vectors
        )
        # IDA takes the mean over all unknowns though only states are tested: put that right.
        part = math.sqrt(self._size / size)
        w, tolerance = kernel.w, part * self._settings.tolerance
        self._z[:] = [*self._y, *(w[s] for s in unknowns.slots)]
        rates[:] = [*ydot, *(w[s] if s >= 0 else 0.0 for s in unknowns.rates)]
        nominals = (abs(w[s]) if s >= 0 else 1.0 for s in unknowns.nominals)
        absolute[:] = [
            *(part * a for a in self._absolute),
            *(tolerance * (n or 1.0) for n in nominals),
        ]
        self._smallest = list(absolute)
        kinds[:] = [1.0] * self._size + [0.0] * len(unknowns.slots)
        self._memory = C.c_void_p(lib.IDACreate(self._context))
        self._residual = _RESIDUAL(self._residuals)
        z, zdot, tolerances, differential, _ = self._vectors
        flag = lib.IDAInit(self._memory, self._residual, self._t, z, zdot)
        if flag < 0:
            raise Unavailable(f"IDAInit of SUNDIALS refused with {flag}")
        lib.IDASVtolerances(self._memory, tolerance, tolerances)
        lib.IDASetId(self._memory, differential)
        lib.IDASetSuppressAlg(self._memory, 1)
        self._matrix = lib.SUNDenseMatrix(size, size, self._context)
        self._linear = lib.SUNLinSol_Dense(z, self._matrix, self._context)
        lib.IDASetLinearSolver(self._memory, self._linear, self._matrix)
        self.formulas = size >= FEWEST_UNKNOWNS and self._derived() is not None
        if self.formulas:
            self._callback = _JACOBIAN(self._jacobian_of)
            lib.IDASetJacFn(self._memory, self._callback)
        lib.IDASetMaxNumSteps(self._memory, -1)
        lib.IDASetMaxErrTestFails(self._memory, 20)
        lib.IDASetMaxConvFails(self._memory, 20)
        if self._settings.span > 0:
            lib.IDASetMaxStep(self._memory, self._longest_step)
        if self._first:
            lib.IDASetInitStep(self._memory, min(self._first, limit - self._t))
        self._solver = self._memory
        self._first = None

    def _numbers(self, vector: int, size: int) -> Any:
        address = self._lib.N_VGetArrayPointer(vector)
        return (C.c_double * size).from_address(address)

    def _parts(self, z: Any) -> tuple[list[float], list[float]]:
        """The states, and the unknowns of the blocks."""
        values = z[:]
        return values[: self._size], values[self._size :]

    def _derived(self) -> Any:
        """d(f, r)/dz at the point to begin from, or None where there is no formula."""
        return self._equations.residual_jacobian(self._t, *self._parts(self._z), self._unknowns)

    def _form(self, t: float, z: Any) -> tuple[int, list[float]]:
        """The flag, and -f and r at these values."""
        flag, rates, residuals = self._equations.residual_form(t, *self._parts(z), self._unknowns)
        self._calls += 1
        return flag, [*(-f for f in rates), *residuals]

    def _residuals(self, t: float, z: int, zdot: int, result: int, _: object) -> int:
        """F as IDA calls it. No exception passes through C."""
        try:
            n, size = self._size, len(self._z)
            flag, values = self._form(t, self._numbers(z, size))
            if flag != 0:
                self._flag = flag
                return 1
            given = self._numbers(zdot, size)[:n]
            values[:n] = [a + b for a, b in zip(given, values[:n], strict=True)]
            self._numbers(result, size)[:] = values
            total = sum(values)
            return 0 if total - total == 0.0 else 1
        except BaseException as problem:
            self._raised = problem
            return -1

    def _jacobian_of(
        self, t: float, rate: float, z: int, zdot: int, result: int, matrix: int, *_: object
    ) -> int:
        """dF/dz + rate*dF/dz' as IDA calls it, column by column."""
        try:
            import numpy as np

            n, size = self._size, len(self._z)
            values = self._numbers(z, size)
            found = self._equations.residual_jacobian(t, *self._parts(values), self._unknowns)
            if found is None:
                found = self._differences(t, list(values))
            if found is None:
                return 1
            found[:n] *= -1.0
            found[range(n), range(n)] += rate
            data = self._lib.SUNDenseMatrix_Data(matrix)
            columns = (C.c_double * (size * size)).from_address(data)
            np.ctypeslib.as_array(columns).reshape(size, size)[:] = found.T
            return 0
        except BaseException as problem:
            self._raised = problem
            return -1

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
        lib = self._lib
        self._flag = 0
        if self._solver is None:
            try:
                self._make(limit)
            except _UnsolvedError:
                return March(Outcome.FAILED, cause=Cause.BLOCK)
        lib.IDASetStopTime(self._memory, limit)
        z, zdot = self._vectors[:2]
        flag = lib.IDASolve(self._memory, limit, C.byref(self._reached), z, zdot, _ONE_STEP)
        if self._raised is not None:
            problem, self._raised = self._raised, None
            raise problem
        if flag < 0:
            return March(Outcome.FAILED, cause=self._cause(flag))
        shortest = SHORTEST * max(self._settings.span, abs(self._reached.value))
        self._short = self._short + 1 if self.last_step() < shortest else 0
        if self._short > MOST_SHORT:
            return March(Outcome.FAILED, cause=Cause.NOT_FINITE if self._flag < 0 else Cause.STEP)
        self._steps += 1
        self._take(self._reached.value, self._z)
        return self._rooted(self._reached.value, list(self._z[: self._size]), limit)

    def _cause(self, flag: int) -> Cause:
        if self._flag < 0 and flag in (-8, -9, -12, -4):
            return Cause.NOT_FINITE
        return _CAUSES.get(flag, Cause.STEP)

    def _take(self, t: float, z: Any) -> None:
        """What the blocks start from when they are solved here."""
        flag, _, _ = self._equations.residual_form(t, *self._parts(z), self._unknowns)
        if flag == 0:
            self._kernel.accept(t)

    def interpolate(self, t: float) -> Sequence[float]:
        self._lib.IDAGetDky(self._memory, t, 0, self._vectors[4])
        self._take(t, self._dense)
        return self._dense[: self._size]  # type: ignore[no-any-return]

    def last_step(self) -> float:
        if self._memory.value is None:
            return 0.0
        step = C.c_double()
        self._lib.IDAGetLastStep(self._memory, C.byref(step))
        return step.value

    def errors(self) -> Sequence[float]:
        if self._memory.value is None:
            return ()
        size = len(self._z)
        own = [self._lib.N_VNew_Serial(size, self._context) for _ in range(2)]
        self._lib.IDAGetEstLocalErrors(self._memory, own[0])
        self._lib.IDAGetErrWeights(self._memory, own[1])
        errors, weights = (self._numbers(v, size)[: self._size] for v in own)
        for vector in own:
            self._lib.N_VDestroy(vector)
        return [e * w for e, w in zip(errors, weights, strict=True)]

    # What it did, and the end

    def _present_jacobians(self) -> int:
        return 0  # counted when the memory is given back

    def counts(self) -> Counts:
        return self._total + self._present()

    def _present(self) -> Counts:
        if self._memory.value is None:
            return Counts()
        names = ("NumSteps", "NumResEvals", "NumLinResEvals", "NumJacEvals", "NumErrTestFails")
        steps, calls, more, jacobians, failures = (self._number(n) for n in names)
        return Counts(steps, calls + more, jacobians, failures)

    def _number(self, name: str) -> int:
        value = C.c_long()
        getattr(self._lib, f"IDAGet{name}")(self._memory, C.byref(value))
        return value.value

    def _free(self) -> None:
        if self._memory.value is not None:
            self._total = self.counts()
            self._lib.IDAFree(C.byref(self._memory))
            self._lib.SUNLinSolFree(self._linear)
            self._lib.SUNMatDestroy(self._matrix)
            self._memory = C.c_void_p()
        for vector in self._vectors:
            self._lib.N_VDestroy(vector)
        self._vectors = []
        self._solver = None

    def close(self) -> None:
        self._free()
        if self._context.value is not None:
            self._lib.SUNContext_Free(C.byref(self._context))


class _UnsolvedError(Exception):
    """The blocks have no solution at the point to begin from."""
