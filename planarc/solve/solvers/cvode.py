"""CVODE: variable-order BDF and Adams methods, the integrator planarc prefers.

With a native kernel the right-hand side and the zero functions go to CVODE as
machine addresses, and the march itself runs in machine code (`driver`); with
another kernel, or without llvmlite, the same steps are made from Python.

The linear systems of the corrector are dense: an acceleration depends on all angles
of a chain. Up to `LARGEST_DENSE` states they are eliminated. Beyond, GMRES solves them
from products of the Jacobian with vectors, one evaluation of the right-hand side each,
so that a step costs as much as a few right-hand sides, and these are linear in the size
of the mechanism. Microseconds a step of a chain of N rods, 2N states, tolerance 1e-6:

    N                 80    160    320
    elimination      125    350   1550
    GMRES            110    260    750

(with all variables stored; the Jacobian by differences and its elimination take 2/3 of
350). GMRES has no preconditioner: where stiffness makes it take many products a step,
the run goes on with elimination.

The Jacobian of machine code is differenced: of a chain of N rods that costs 2N right-hand
sides. From formulas it takes a third of that from N = 20 on, and as long for N = 5,

    N                            20     80
    us for differences           92   1300
    us from formulas             24    450
    ms to compile these          60    250

so that a run of 10 s (45 Jacobians) becomes 10 to 17 % shorter, and compiling pays only where
there are a hundred times as many: from `MOST_DIFFERENCES` on, they are compiled.

`tolerance` T is passed on as it is: relative tolerance T, absolute tolerance T times
the nominal value of each state. No factor is hidden here. It bounds the error of one step,
in the mean over the states, so the error of a run is some hundred times as large: for a
pendulum of 5 s 3e-5 at 1e-6, 4e-7 at 1e-8, 7e-9 at 1e-10, 2e-10 at 1e-12 (Adams and LSODA: a
half to a tenth of it). The last digits of T, or of a parameter, change the steps, and with
these the error by a factor of up to 4 either way.

Reference: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31(3), 2005, 363-396.
"""

from __future__ import annotations

import ctypes as C
from collections.abc import Callable, Sequence
from typing import Any

from planarc.ir.kernel import Kernel
from planarc.ir.newton import DIFFERENCE
from planarc.runtime.differences import one_sided
from planarc.solve.recorder import Recorder
from planarc.solve.solvers.driver import Arguments, Driver, Where, open_driver
from planarc.solve.solvers.integrator import (
    Cause,
    Counts,
    March,
    Outcome,
    Settings,
    march_steps,
)
from planarc.solve.solvers.scipy import FEWEST_DERIVED
from planarc.solve.solvers.sundials import Unavailable, open_sundials
from planarc.solve.solvers.watch import Watch

_ADAMS, _BDF = 1, 2
_ONE_STEP = 2
_STOP_REACHED, _ROOT_FOUND, _WARNING = 1, 2, 99

#: No step is longer than this part of the run, so that no short pulse is stepped over.
LONGEST_STEP = 1 / 50

#: Larger systems are solved by GMRES.
LARGEST_DENSE = 200
#: So many right-hand sides a run spends on differences before formulas are compiled: about
#: where these would have paid for it.
MOST_DIFFERENCES = 50_000
#: With fewer states differences of machine code are quicker.
FEWEST_COMPILED = 16
#: Vectors that GMRES keeps before it gives up; the number CVODE recommends.
KRYLOV_VECTORS = 5
#: More evaluations a step than this mean that GMRES does not converge well.
MOST_PRODUCTS = 14
#: So many steps are taken before that is judged, and before differences are.
JUDGED_STEPS, JUDGED_OFTEN = 40, 500

#: Return flags of CVODE; every other failure is one of the setup.
_CAUSES = {
    -1: Cause.STEP,
    -2: Cause.ACCURACY,
    -3: Cause.ERROR_TEST,
    -4: Cause.CONVERGENCE,
    -6: Cause.CONVERGENCE,
    -7: Cause.CONVERGENCE,
    -8: Cause.NOT_FINITE,
    -9: Cause.BLOCK,
    -10: Cause.BLOCK,
    -11: Cause.BLOCK,
    -12: Cause.BLOCK,
}

_RHS = C.CFUNCTYPE(C.c_int, C.c_double, C.c_void_p, C.c_void_p, C.c_void_p)
_JACOBIAN = C.CFUNCTYPE(C.c_int, C.c_double, *(C.c_void_p,) * 7)
_ROOTS = C.CFUNCTYPE(C.c_int, C.c_double, C.c_void_p, C.POINTER(C.c_double), C.c_void_p)


class Cvode:
    """One run's integrator. Owns its context, vectors and callbacks until `close`."""

    ends_evaluated = True

    def __init__(self, kernel: Kernel, states: int, settings: Settings, adams: bool) -> None:
        self._lib = lib = open_sundials()
        self._kernel, self._size, self._settings = kernel, states, settings
        self._adams = adams
        offered = kernel.capabilities
        self._formulas, self._machine = offered.formulas, offered.machine
        self._addresses = None
        if self._machine is not None:
            self._addresses = self._machine.addresses(lib.address("N_VGetArrayPointer"))
        self._context = C.c_void_p()
        lib.SUNContext_Create(0, C.byref(self._context))
        lib.SUNContext_ClearErrHandlers(self._context)
        self._vectors = [lib.N_VNew_Serial(states, self._context) for _ in range(3)]
        self._y, self._dense, self._absolute = (self._numbers(v) for v in self._vectors)
        self._raised: BaseException | None = None
        self._flag = 0  # of the last evaluation
        self._rhs, self._roots, user = self._functions()
        self._memory = C.c_void_p()
        self._matrix = self._linear = None
        self.krylov = states > LARGEST_DENSE
        self.formulas = self._derives = False
        self._for_differences = 0
        self._user = user
        self._time = C.c_double()
        self._total = Counts()
        self._driver = self._native_driver()
        self.looks = self._driver is not None
        self._arguments: Arguments | None = None
        self.name = f"cvode-{'adams' if adams else 'bdf'}"
        if self._addresses is not None:
            self.name += " (native)"

    def _numbers(self, vector: int) -> C.Array[C.c_double]:
        address = self._lib.N_VGetArrayPointer(vector)
        return (C.c_double * self._size).from_address(address)

    # The right-hand side

    def _functions(self) -> tuple[object, object, int | None]:
        """Right-hand side, zero functions, and what CVODE hands to both."""
        addresses = self._addresses
        if addresses is not None:
            roots = addresses.cv_roots or None
            return C.c_void_p(addresses.cv_rhs), C.c_void_p(roots), addresses.context
        rhs, roots_function = self._callbacks()
        return rhs, roots_function, None

    def _callbacks(self) -> tuple[object, object]:
        kernel, pointer, size = self._kernel, self._lib.N_VGetArrayPointer, self._size
        seen: dict[int, C.Array[C.c_double]] = {}

        def numbers(vector: int) -> C.Array[C.c_double]:
            address = pointer(vector)
            if address not in seen:
                seen[address] = (C.c_double * size).from_address(address)
            return seen[address]

        def rhs(t: float, y: int, ydot: int, _: object) -> int:
            flag = self._flag = kernel.rhs(t, numbers(y), numbers(ydot))  # type: ignore[arg-type]
            return abs(flag)  # positive: CVODE tries a shorter step, up to what has no value

        def roots(t: float, y: int, g: object, _: object) -> int:
            return kernel.roots(t, numbers(y), g)  # type: ignore[arg-type]

        return _RHS(self._guarded(rhs)), _ROOTS(self._guarded(roots))

    def _jacobian_function(self) -> Any:
        """The Jacobian from the kernel's formulas. Those of a native one are compiled only
        where they pay (`MOST_DIFFERENCES`)."""
        kernel, size, data = self._kernel, self._size, self._lib.SUNDenseMatrix_Data
        if self._user is not None:
            return self._native_jacobian() if self._derives else None
        formulas = self._formulas
        if formulas is None or size < FEWEST_DERIVED:
            return None

        def jacobian(t: float, y: int, f: int, matrix: int, *_: object) -> int:
            import numpy as np

            pointer = self._lib.N_VGetArrayPointer(y)
            states = list((C.c_double * size).from_address(pointer))
            found = formulas.state_jacobian(t, states)
            if found is None:  # a function without derivative, a singular mode
                found = _differences(kernel, t, states, list(self._absolute))
            if found is None:
                return 1
            columns = (C.c_double * (size * size)).from_address(data(matrix))
            np.ctypeslib.as_array(columns).reshape(size, size)[:] = np.transpose(found)
            return 0

        return _JACOBIAN(self._guarded(jacobian))

    def _native_jacobian(self) -> Any:
        scales = [1e3 * a for a in self._absolute]
        assert self._machine is not None
        address = self._machine.cv_jacobian(scales, self._lib.address("SUNDenseMatrix_Data"))
        return C.c_void_p(address) if address else None

    def _judge(self, steps: int) -> int:
        """Whether to go on as before, and after how many steps at most to judge again: at
        numbers of steps, so that a run does not depend on the speed of the machine."""
        compiles = self._user is not None and not self._adams and not self._derives
        if self.krylov:
            every, judge = JUDGED_STEPS, self._judge_krylov
        elif compiles and self._size >= FEWEST_COMPILED:
            every, judge = JUDGED_OFTEN, self._judge_differences
        else:
            return steps
        done = self._number("NumSteps") % every
        if done == 0:
            judge()
        return min(steps, every - done)

    def _judge_differences(self) -> None:
        """From here on formulas, where differences have cost as much as compiling these."""
        if self._differenced() >= MOST_DIFFERENCES:
            self._derives = True
            self._set_jacobian()

    def _set_jacobian(self) -> None:
        self._jacobian = None if self.krylov else self._jacobian_function()
        self.formulas = self._jacobian is not None
        if self.formulas:
            self._lib.CVodeSetJacFn(self._memory, self._jacobian)

    def _differenced(self) -> int:
        """Right-hand sides taken for differences since the run began."""
        return self._for_differences + self._number("NumLinRhsEvals")

    def _guarded(self, function: Callable[..., int]) -> Callable[..., int]:
        """No exception passes through C: it is kept, and raised when CVODE has returned."""

        def call(*arguments: object) -> int:
            try:
                return function(*arguments)
            except BaseException as problem:
                self._raised = problem
                return -1

        return call

    def _native_driver(self) -> Driver | None:
        if self._addresses is None or self._settings.past is not None:
            return None  # every step comes back to Python
        return open_driver(self._lib)

    # Where it is

    @property
    def t(self) -> float:
        return self._time.value

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
        lib = self._lib
        self._time.value = t
        self._y[:] = list(y)
        self._absolute[:] = list(absolute)
        if self._memory.value is None:
            self._create(t)
        else:
            self._total, self._for_differences = self.counts(), self._differenced()
            self._check(lib.CVodeReInit(self._memory, t, self._vectors[0]), "CVodeReInit")
        lib.CVodeSVtolerances(self._memory, self._settings.tolerance, self._vectors[2])
        lib.CVodeSetInitStep(self._memory, step or 0.0)
        if directions:
            ways = (C.c_int * len(directions))(*directions)
            lib.CVodeSetRootDirection(self._memory, ways)

    def _create(self, t: float) -> None:
        lib = self._lib
        method = _ADAMS if self._adams else _BDF
        self._memory = C.c_void_p(lib.CVodeCreate(method, self._context))
        self._check(lib.CVodeInit(self._memory, self._rhs, t, self._vectors[0]), "CVodeInit")
        # Tolerances must stand before anything else is set up.
        lib.CVodeSVtolerances(self._memory, self._settings.tolerance, self._vectors[2])
        if self._user is not None:
            lib.CVodeSetUserData(self._memory, self._user)
        self._set_linear_solver()
        if self._settings.span > 0:
            own = self._settings.span * LONGEST_STEP
            lib.CVodeSetMaxStep(self._memory, min(own, self._settings.longest_step))
        lib.CVodeSetMaxNumSteps(self._memory, -1)
        lib.CVodeSetMaxHnilWarns(self._memory, -1)
        lib.CVodeSetMaxErrTestFails(self._memory, 12)
        lib.CVodeSetMaxConvFails(self._memory, 20)
        if self._settings.relations:
            lib.CVodeRootInit(self._memory, self._settings.relations, self._roots)
            lib.CVodeSetNoInactiveRootWarn(self._memory)

    def _set_linear_solver(self) -> None:
        lib, context = self._lib, self._context
        if self.krylov:
            self._matrix = None
            self._linear = lib.SUNLinSol_SPGMR(self._vectors[0], 0, KRYLOV_VECTORS, context)
        else:
            self._matrix = lib.SUNDenseMatrix(self._size, self._size, context)
            self._linear = lib.SUNLinSol_Dense(self._vectors[0], self._matrix, context)
        flag = lib.CVodeSetLinearSolver(self._memory, self._linear, self._matrix)
        self._check(flag, "CVodeSetLinearSolver")
        self._set_jacobian()

    def _free_linear_solver(self) -> None:
        self._lib.SUNLinSolFree(self._linear)
        if self._matrix is not None:
            self._lib.SUNMatDestroy(self._matrix)

    def _judge_krylov(self) -> None:
        """Eliminate from here on where GMRES takes too many products."""
        steps = self._number("NumSteps")
        if steps < JUDGED_STEPS:
            return
        calls = self._number("NumRhsEvals") + self._number("NumLinRhsEvals")
        failures = self._number("NumLinConvFails")
        if calls <= MOST_PRODUCTS * steps and 4 * failures <= steps:
            return
        lib, step = self._lib, self.last_step()
        self.krylov = False
        self._total = self.counts()
        self._check(lib.CVodeReInit(self._memory, self.t, self._vectors[0]), "CVodeReInit")
        self._free_linear_solver()
        self._set_linear_solver()
        lib.CVodeSetInitStep(self._memory, step)

    def _check(self, flag: int, function: str) -> None:
        if flag < 0:
            raise Unavailable(f"{function} of SUNDIALS refused with {flag}")

    # On the way

    def march(self, limit: float, recorder: Recorder, watch: Watch, steps: int) -> March:
        steps = self._judge(steps)
        self._lib.CVodeSetStopTime(self._memory, limit)
        if self._driver is None:
            past = self._settings.past
            return march_steps(self, self._kernel, limit, recorder, watch, steps, past)
        if self._arguments is None:
            memory = self._memory.value or 0
            where = Where(memory, self._vectors[0], self._vectors[1], self._time)
            assert self._addresses is not None
            self._arguments = self._driver.prepare(where, self._addresses, recorder, watch)
        driver, arguments = self._driver, self._arguments
        flag, failed, looks = driver.march(arguments, limit, recorder, watch, steps)
        if failed:
            return March(Outcome.FAILED, cause=Cause.BLOCK)
        return March(Outcome.LOOK) if looks else self._meaning(flag)

    def step(self, limit: float) -> March:
        self._raised = None
        flag = self._lib.CVode(
            self._memory, limit, self._vectors[0], C.byref(self._time), _ONE_STEP
        )
        if self._raised is not None:
            problem, self._raised = self._raised, None
            raise problem
        return self._meaning(flag)

    def _meaning(self, flag: int) -> March:
        if flag in (0, _WARNING):
            return March(Outcome.BUDGET)
        if flag == _STOP_REACHED:
            return March(Outcome.LIMIT)
        if flag == _ROOT_FOUND:
            found = (C.c_int * self._settings.relations)()
            self._lib.CVodeGetRootInfo(self._memory, found)
            return March(Outcome.ROOT, directions=tuple(found))
        cause = Cause.NOT_FINITE if self._flag < 0 else _CAUSES.get(flag, Cause.STEP)
        return March(Outcome.FAILED, cause=cause)

    def interpolate(self, t: float) -> Sequence[float]:
        self._lib.CVodeGetDky(self._memory, t, 0, self._vectors[1])
        return self._dense  # type: ignore[return-value]

    # What it did

    def last_step(self) -> float:
        step = C.c_double()
        self._lib.CVodeGetLastStep(self._memory, C.byref(step))
        return step.value

    def errors(self) -> Sequence[float]:
        if self._memory.value is None:
            return ()
        own = [self._lib.N_VNew_Serial(self._size, self._context) for _ in range(2)]
        self._lib.CVodeGetEstLocalErrors(self._memory, own[0])
        self._lib.CVodeGetErrWeights(self._memory, own[1])
        errors, weights = (list(self._numbers(v)) for v in own)
        for vector in own:
            self._lib.N_VDestroy(vector)
        return [e * w for e, w in zip(errors, weights, strict=True)]

    def counts(self) -> Counts:
        """Since the run began: CVODE's own counters start again at every restart."""
        if self._memory.value is None:
            return self._total
        return self._total + Counts(
            self._number("NumSteps"),
            self._number("NumRhsEvals") + self._number("NumLinRhsEvals"),
            self._number("NumJacEvals"),
            self._number("NumErrTestFails"),
        )

    def _number(self, name: str) -> int:
        value = C.c_long()
        getattr(self._lib, f"CVodeGet{name}")(self._memory, C.byref(value))
        return value.value

    def close(self) -> None:
        lib = self._lib
        if self._memory.value is not None:
            self._total = self.counts()
            lib.CVodeFree(C.byref(self._memory))
            self._free_linear_solver()
            self._memory = C.c_void_p()
        for vector in self._vectors:
            lib.N_VDestroy(vector)
        self._vectors = []
        if self._context.value is not None:
            lib.SUNContext_Free(C.byref(self._context))


def _differences(kernel: Kernel, t: float, y: list[float], absolute: Sequence[float]) -> Any:
    """The Jacobian by forward differences, a row for each derivative; None where there is none."""

    def rhs(at: Any) -> list[float] | None:
        there = [0.0] * len(y)
        return there if kernel.rhs(t, at.tolist(), there) == 0 else None

    steps = [DIFFERENCE * max(abs(v), 1e3 * a) for v, a in zip(y, absolute, strict=True)]
    return one_sided(rhs, y, steps)
