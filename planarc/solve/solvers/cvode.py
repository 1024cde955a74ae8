"""CVODE: variable-order BDF and Adams methods, the integrator planarc prefers.

With a native kernel the right-hand side and the zero functions go to CVODE as
machine addresses, and the march itself runs in machine code (`driver`); with
another kernel the same steps are made from Python.

The linear systems of the corrector are dense: an acceleration depends on all angles
of a chain. Up to `LARGEST_DENSE` states they are eliminated. Beyond, GMRES solves them
from products of the Jacobian with vectors, one evaluation of the right-hand side each,
so that a step costs as much as a few right-hand sides, and these are linear in the size
of the mechanism. Microseconds a step of a chain of N rods, 2N states, tolerance 1e-6, all
variables stored 500 times:

    N                 30     50     80    160    320
    elimination       60    145    260    930   5800
    GMRES             50     95    110    205    570

GMRES has no preconditioner: where stiffness makes it take many products a step, the run goes on
with elimination.

The Jacobian of machine code is differenced: of a chain of N rods that costs 2N right-hand
sides. From formulas it takes a third of that from N = 20 on, and as long for N = 5,

    N                            20     80
    us for differences           92   1300
    us from formulas             24    450
    ms to compile these          60    250

so that a run of 10 s of 20 rods (160 Jacobians) becomes a third shorter, and compiling pays
where there are three times as many: from `MOST_DIFFERENCES` on, they are compiled.

CVODE's own differences are some 1e-17 long for states near zero where steps are short, so that
rounding tells what depends on what, and bodies that hang still drift apart by some 1e-10 m a step.
Where touches tell that from rest, differences suit the nominal values of the states.

Of the `tolerance` T, steps are held to the relative tolerance `SHARE` T and the absolute tolerance
`SHARE` T times the nominal value of each state, or where it has none what it is measured by
(`solve.measure`). That bounds the error of one step, in the mean over the states, so the error of a
run is some hundred times as large: for the pendulum of the README, in 5 s, 8e-5 at 1e-6, 2e-6 at
1e-8, 1e-8 at 1e-10, 4e-10 at 1e-12 (Adams and LSODA: twice to a tenth of it). The last digits of T,
or of a parameter, change the steps, and with these the error by a factor of up to 4 either way.

Reference: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31(3), 2005, 363-396.

The file is long because all that CVODE is told, before, on and between runs, is about one memory.
"""

from __future__ import annotations

import ctypes as C
from collections.abc import Sequence
from typing import Any

from msgspec.structs import replace

from planarc.core.options import Solver
from planarc.ir.kernel import Kernel, Machine
from planarc.ir.march import WARNING
from planarc.solve.recorder import Recorder
from planarc.solve.solvers.callbacks import Callbacks
from planarc.solve.solvers.dips import Suspicion
from planarc.solve.solvers.driver import Driver, Where
from planarc.solve.solvers.integrator import (
    FEWEST_DERIVED,
    UNSOLVED,
    Cause,
    Counts,
    Integrator,
    March,
    Outcome,
    Settings,
)
from planarc.solve.solvers.session import ONE_STEP, Session
from planarc.solve.solvers.sundials import open_sundials
from planarc.solve.solvers.watch import Watch

_ADAMS, _BDF = 1, 2
_STOP_REACHED, _ROOT_FOUND = 1, 2

#: No step is longer than this part of the run, so that no short pulse is stepped over.
LONGEST_STEP = 1 / 50
#: Nor shorter than this part: time itself is known to 1e-16 of it, so that thousands of such steps
#: would not move it, and what they follow is no solution (a fall into a point).
SHORTEST_STEP = 1e-20

#: States up to which the corrector eliminates; beyond, GMRES.
LARGEST_DENSE = 100
#: Steps that one Jacobian may serve, until the corrector's matrix is set up next; CVODE's own
#: choice is 51. One of a point beside a singular position has huge entries: Newton's steps with
#: it are next to nothing, pass for convergence, and neither corrector nor error test sees
#: anything.
JACOBIAN_FOR = 2
#: Part of the tolerance that steps are held to: what they err adds up along a run.
SHARE = 0.7
#: Right-hand sides spent on differences before formulas are compiled: about where these would
#: have paid for it.
MOST_DIFFERENCES = 30_000
#: States from which compiled formulas are quicker than differences of machine code.
FEWEST_COMPILED = 16
#: Vectors that GMRES keeps before it gives up; the number CVODE recommends.
KRYLOV_VECTORS = 5
#: Evaluations a step beyond which GMRES does not converge well.
MOST_PRODUCTS = 14
#: Steps from one judgement of GMRES to the next, and from one of differences.
JUDGED_STEPS, JUDGED_OFTEN = 40, 500

_MADE, _NOTHING = March(Outcome.BUDGET), Counts()

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


def _is_alone(settings: Settings) -> bool:
    """Whether nobody else must see every step."""
    return settings.past is None and not settings.waves


def make(solver: Solver, kernel: Kernel, states: int, settings: Settings) -> Cvode:
    return Cvode(kernel, states, settings, solver is Solver.CVODE_ADAMS)


class Cvode(Integrator):
    """One run's integrator. Owns its session and callbacks until `close`."""

    ends_evaluated = True

    def __init__(self, kernel: Kernel, states: int, settings: Settings, adams: bool) -> None:
        super().__init__(kernel, states, settings)
        self._lib = lib = open_sundials()
        self._session = Session(lib)
        self._adams = adams
        self._vectors, numbers = self._session.vectors(3, states)
        self._y, self._dense, self._absolute = numbers
        callbacks = Callbacks(self._session, kernel, states, self._absolute, self._is_far)
        self._callbacks = callbacks
        self._machine, self._addresses = kernel.capabilities.machine, None
        if self._machine is not None:
            self._addresses = self._machine.addresses(lib.address("N_VGetArrayPointer"))
        self._rhs, self._roots = self._functions()
        self.krylov = states > LARGEST_DENSE
        self.remark = f", GMRES {states} states" if self.krylov else ""
        self.formulas = self._derives = False
        self._jacobian: Any = None
        self._for_differences = 0  # right-hand sides, before CVODE's counters began again
        self._differenced = 0  # Jacobians since then, before there were formulas
        self._time = C.c_double()
        self._total = Counts()
        # Who must see every step lets it come back to Python.
        self.looks = self._addresses is not None and _is_alone(settings)
        self._driver: Driver | None = None
        self._bounds: tuple[float, float] | None = None  # of steps, as CVODE knows them
        self.name = f"cvode-{'adams' if adams else 'bdf'}"
        if self._addresses is not None:
            self.name += " (native)"

    def _functions(self) -> tuple[object, object]:
        """Right-hand side and zero functions."""
        if self._addresses is None:
            return self._callbacks.rhs(), self._callbacks.roots(
                self._relations, self._settings.relations
            )
        return C.c_void_p(self._addresses.cv_rhs), C.c_void_p(self._addresses.cv_roots or None)

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
        session = self._session
        self._time.value = t
        self._y[:] = list(y)
        self._begin_dips(t, y, directions)
        self._absolute[:] = [SHARE * a for a in absolute]
        if session.begun:
            self._begin_anew(t)
        elif session.present:
            self._begin_another(t)
        else:
            self._create(t)
        session.begun = True
        self._measure()
        session.call("SVtolerances", self._relative, self._vectors[2])
        session.call("SetInitStep", step or 0.0)
        if directions:
            session.call("SetRootDirection", (C.c_int * len(directions))(*directions))

    @property
    def _relative(self) -> float:
        """The relative error that a step may have."""
        return SHARE * self._settings.tolerance * self.sharp

    def shift(self, shifts: Sequence[float]) -> None:
        super().shift(shifts)
        if self._machine is not None:
            self._machine.shift(shifts)

    def _begin_anew(self, t: float) -> None:
        """CVODE's own counters start again."""
        self._for_differences += self._differences()
        self._total, self._differenced = self.counts(), 0
        self._session.check("ReInit", t, self._vectors[0])

    def _create(self, t: float) -> None:
        session, settings = self._session, self._settings
        session.create(_ADAMS if self._adams else _BDF)
        session.check("Init", self._rhs, t, self._vectors[0])
        # Tolerances must stand before anything else is set up.
        session.call("SVtolerances", self._relative, self._vectors[2])
        if self._addresses is not None:
            session.call("SetUserData", self._addresses.context)
        self._set_linear_solver()
        self._bound_steps()
        session.call("SetMaxNumSteps", -1)
        session.call("SetMaxHnilWarns", -1)
        session.call("SetMaxErrTestFails", 12)
        session.call("SetMaxConvFails", 20)
        if settings.relations:
            session.call("RootInit", settings.relations, self._roots)
            session.call("SetNoInactiveRootWarn")

    def _bound_steps(self) -> None:
        session, settings = self._session, self._settings
        bounds = settings.span, settings.longest_step
        if settings.span > 0 and bounds != self._bounds:
            self._bounds = bounds
            session.call("SetMinStep", 0.0)  # lest it be above the longest one
            own = settings.span * LONGEST_STEP
            session.call("SetMaxStep", min(own, settings.longest_step))
            session.call("SetMinStep", settings.span * SHORTEST_STEP)

    # From run to run

    @property
    def keeps(self) -> bool:  # type: ignore[override]
        """Machine code, with its first choice of how the corrector solves."""
        first = self.krylov == (self._size > LARGEST_DENSE) and not self._derives
        return self.looks and first and self._session.begun

    def renew(self, solver: Solver, settings: Settings) -> bool:
        method = solver.home == "cvode" and (solver is Solver.CVODE_ADAMS) == self._adams
        if not method or settings.relations != self._settings.relations or not _is_alone(settings):
            return False
        self._settings, self._session.begun = settings, False
        self.poles.renew()
        self._dips.renew()
        self._total, self._for_differences, self._differenced = Counts(), 0, 0
        self._time.value = 0.0
        return True

    def rest(self) -> None:
        if self._driver is not None:
            self._driver.part()

    def _begin_another(self, t: float) -> None:
        """CVODE's memory as it was created, for another run."""
        session, relations = self._session, self._settings.relations
        session.check("ReInit", t, self._vectors[0])
        self._bound_steps()
        if relations:  # which functions are inactive is forgotten with them
            session.call("RootInit", 0, None)
            session.call("RootInit", relations, self._roots)

    # The linear systems of the corrector

    def _set_linear_solver(self) -> None:
        if self.krylov:
            self._session.multiply(self._vectors[0], KRYLOV_VECTORS)
        else:
            self._session.eliminate(self._size, self._vectors[0])
            self._session.call("SetJacEvalFrequency", JACOBIAN_FOR)
        self._set_jacobian()

    def _set_jacobian(self) -> None:
        self._jacobian = None if self.krylov else self._jacobian_function()
        if self._jacobian is not None:
            self._session.call("SetJacFn", self._jacobian)
            self._measure()

    def _measure(self) -> None:
        """Tell the nominal values of the states to whoever differences them."""
        if self._machine is not None and self._jacobian is not None:
            self._machine.measure([a / self._relative for a in self._absolute])

    def _jacobian_function(self) -> Any:
        """The Jacobian from the kernel's formulas. Those of a native one are compiled only
        where they pay (`MOST_DIFFERENCES`)."""
        formulas = self._kernel.capabilities.formulas
        if self._machine is not None:
            return self._native_jacobian(self._machine)
        if formulas is None or self._size < FEWEST_DERIVED:
            return None
        self.formulas = True
        return self._callbacks.jacobian(formulas)

    def _native_jacobian(self, machine: Machine) -> Any:
        matrix_numbers = self._lib.address("SUNDenseMatrix_Data")
        found = machine.cv_jacobian(matrix_numbers) if self._derives else 0
        self.formulas = found != 0
        if not found and self._settings.touches:
            found = machine.cv_differences(matrix_numbers)
        return C.c_void_p(found) if found else None

    def _judge(self, steps: int) -> int:
        """Whether to go on as before, and after how many steps at most to judge again: at
        numbers of steps, so that a run does not depend on the speed of the machine."""
        compiles = self._machine is not None and not self._adams and not self._derives
        if self.krylov:
            every, judge = JUDGED_STEPS, self._judge_krylov
        elif compiles and self._size >= FEWEST_COMPILED:
            every, judge = JUDGED_OFTEN, self._judge_differences
        else:
            return steps
        done = self._session.number("NumSteps") % every
        if done == 0:
            judge()
        return min(steps, every - done)

    def _judge_differences(self) -> None:
        """Take formulas where differences have cost as much as compiling these."""
        if self._for_differences + self._differences() >= MOST_DIFFERENCES:
            self._differenced = self._session.number("NumJacEvals")
            self._derives = True
            self._set_jacobian()

    def _differences(self) -> int:
        """Right-hand sides taken for them since CVODE's counters began."""
        return self._session.number("NumLinRhsEvals") + self._own_differences()

    def _own_differences(self) -> int:
        """Those of them that CVODE does not count."""
        if self._machine is None or not self._settings.touches:
            return 0
        asked = self._differenced if self.formulas else self._session.number("NumJacEvals")
        return self._size * asked

    def _judge_krylov(self) -> None:
        """Eliminate from here on where GMRES takes too many products."""
        number = self._session.number
        steps = number("NumSteps")
        if steps < JUDGED_STEPS:
            return
        calls = number("NumRhsEvals") + number("NumLinRhsEvals")
        if calls <= MOST_PRODUCTS * steps and 4 * number("NumLinConvFails") <= steps:
            return
        step = self.last_step()
        self.krylov = False
        self._total = self.counts()
        self._session.check("ReInit", self.t, self._vectors[0])
        self._session.free_linear_solver()
        self._set_linear_solver()
        self._session.call("SetInitStep", step)

    # On the way

    def march(self, limit: float, recorder: Recorder, watch: Watch, steps: int) -> March:
        steps = self._judge(steps)
        self._session.call("SetStopTime", limit)
        if self._addresses is None or not self.looks:
            return super().march(limit, recorder, watch, steps)
        if self._driver is None:
            memory = self._session.memory.value or 0
            where = Where(memory, self._vectors[0], self._vectors[1], self._time)
            self._driver = Driver(self._lib, where, self._addresses, self._dips, self.poles)
        flag, told = self._driver.march(limit, recorder, watch, steps)
        taken = told.taken
        while told.dips:
            if (found := self._dip(Suspicion(told.dips), flag == _ROOT_FOUND)) is not None:
                rows = self._take_rows(recorder, self.t - recorder.near)
                return replace(found if rows else UNSOLVED, steps=taken + 1)
            flag, told = self._driver.march(limit, recorder, watch, steps - taken, flag)
            taken += told.taken
        if told.failed:
            return replace(UNSOLVED, steps=taken)
        if told.poles:
            crossed = self.poles.lies_before()
            found = self._before_pole() if crossed else March(Outcome.BUDGET)
            return replace(found, steps=taken)
        if told.looks:
            return March(Outcome.LOOK, steps=taken)
        return replace(self._meaning(flag), steps=taken)

    def step(self, limit: float) -> March:
        memory, time = self._session.memory, C.byref(self._time)
        if self._addresses is None:
            self._begin_step()
        flag = self._lib.CVode(memory, limit, self._vectors[0], time, ONE_STEP)
        if flag < 0:
            self._session.reraise()
        return self._meaning(flag)

    def _meaning(self, flag: int) -> March:
        if flag in (0, WARNING):
            return _MADE
        if flag == _STOP_REACHED:
            return March(Outcome.LIMIT)
        if flag == _ROOT_FOUND:
            found = (C.c_int * self._settings.relations)()
            self._session.call("GetRootInfo", found)
            return March(Outcome.ROOT, directions=tuple(found))
        failed = self._callbacks.flag
        cause = Cause.NOT_FINITE if failed < 0 else _CAUSES.get(flag, Cause.STEP)
        return March(Outcome.FAILED, cause=cause)

    def interpolate(self, t: float) -> Sequence[float]:
        self._lib.CVodeGetDky(self._session.memory, t, 0, self._vectors[1])
        return self._dense  # type: ignore[no-any-return]

    def _zeros(self) -> Sequence[float]:
        if self._addresses is None:
            return self._callbacks.zeros
        found = [0.0] * self._settings.relations
        return found if self._relations.roots(self.t, self.y, found) == 0 else ()

    def _go_back(self, t: float, y: Sequence[float]) -> None:
        self._time.value, self._y[:] = t, list(y)

    # What it did

    def last_step(self) -> float:
        return self._session.last_step()

    def errors(self) -> Sequence[float]:
        return self._session.errors(self._size)

    def counts(self) -> Counts:
        """Since the run began: CVODE's own counters start again at every restart."""
        if not self._session.begun:
            return self._total
        own = Counts(*self._session.statistics()) + Counts(rhs_calls=self._own_differences())
        return own if self._total == _NOTHING else self._total + own

    def close(self) -> None:
        self._session.close()
