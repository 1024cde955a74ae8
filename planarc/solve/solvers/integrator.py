"""What every integrator offers, and the march that takes rows on the way.

An integrator holds a time and the states there. It is told where to go on from
(`restart`), and then marches to a limit, to the first root of a relation, or until
it has used up its budget of steps, whatever comes first. On the way it takes every
row that is due and tells the kernel of every accepted step.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.options import Solver
from planarc.ir.kernel import Kernel
from planarc.ir.march import POINTS, REACH
from planarc.solve.recorder import Recorder
from planarc.solve.solvers.dips import Dips, Suspicion
from planarc.solve.solvers.poles import Poles
from planarc.solve.solvers.watch import Watch
from planarc.solve.solvers.zeros import Zeros

if TYPE_CHECKING:
    from planarc.solve.solvers.looks import Looks
    from planarc.solve.solvers.waves import Waves

#: Roots that differ by less than this part of their time are one.
SAME = 1e-12
#: States from which derivatives of the right-hand side are cheaper than its differences.
FEWEST_DERIVED = 8


class Outcome(Enum):
    LIMIT = "the limit was reached"
    ROOT = "a relation switches here"
    BUDGET = "the steps allowed are used up"
    LOOK = "the choice of states is to be looked at"
    FAILED = "no further step was possible"


class Cause(Enum):
    """The reason for which no further step was possible."""

    ERROR_TEST = "the error test failed with the smallest step"
    CONVERGENCE = "the corrector did not converge with the smallest step"
    BLOCK = "the equations could not be solved"
    NOT_FINITE = "a value is not finite"
    ACCURACY = "the tolerance is below what double precision can give here"
    STEP = "the step became too small"
    POLE = "a derivative grows beyond all bounds"


class March(Data):
    """`directions[i]`: +1 or -1 where the zero function i rises or falls through zero; `steps`
    were accepted on the way."""

    outcome: Outcome
    directions: tuple[int, ...] = ()
    cause: Cause | None = None
    steps: int = 0


#: A block could not be solved, whatever the steps made before.
UNSOLVED = March(Outcome.FAILED, cause=Cause.BLOCK)


class Counts(Data):
    steps: int = 0
    rhs_calls: int = 0
    jacobians: int = 0
    error_test_failures: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(
            self.steps + other.steps,
            self.rhs_calls + other.rhs_calls,
            self.jacobians + other.jacobians,
            self.error_test_failures + other.error_test_failures,
        )


class Past(Protocol):
    """An observer that must see every step."""

    def take(self, stepper: Integrator, begin: float) -> bool:
        """The step from `begin` to where the integrator is; false where the run cannot go on."""


class Settings(Data):
    """The settings that do not change during a run."""

    tolerance: float
    span: float
    relations: int  # number of zero functions
    longest_step: float = math.inf  # besides an integrator's own limit
    past: Past | None = None
    fixed_step: float | None = None  # seconds
    tears: tuple[int, ...] = ()  # slots of the unknowns of nonlinear blocks of the top
    waves: bool = False  # zero functions may switch any number of times within a step
    angles: tuple[int, ...] = ()  # slots of those that close loops
    touches: bool = False  # whether something must rest to the last digits
    #: Slots of what sines are asked of, where there are relations, and how far these turn with it.
    turning: tuple[tuple[int, float], ...] = ()


class Integrator(ABC):
    """Steps from Python: whoever marches elsewhere has a `march` of its own."""

    name = ""
    looks = False  # whether a march measures the choice of states at every step
    formulas = False  # whether the Jacobian comes from formulas
    sharp = 1.0  # part of the tolerance that the next stretch is followed with
    remark = ""  # behind the reason for it in a run's summary
    #: Whether a step's last evaluation lies within the tolerance of its end, as where an
    #: implicit method has converged: good enough for the blocks of the next one to start from.
    ends_evaluated = False
    #: Whether steps are as short as the tolerance asks; others may grow without a pole ahead.
    adapts = True
    #: Why no further step is possible, where the steps themselves know it.
    trouble: Diagnostic | None = None
    #: A row that lies so far behind a step's end is one at its end: times are rounded.
    slack = 0.0

    def __init__(self, kernel: Kernel, states: int, settings: Settings) -> None:
        self._kernel, self._size, self._settings = kernel, states, settings
        self.poles = Poles(kernel, states, self.adapts)
        self._angles_before: list[float] = []  # the angles of loops where the present step began
        self._relations = Zeros(kernel)
        self._dips = Dips(self._relations, settings.relations, settings.turning)
        self._crossing: tuple[int, ...] = ()

    @property
    @abstractmethod
    def t(self) -> float: ...

    @property
    @abstractmethod
    def y(self) -> list[float]: ...

    @abstractmethod
    def restart(
        self,
        t: float,
        y: Sequence[float],
        absolute: Sequence[float],
        directions: Sequence[int],
        step: float | None = None,
    ) -> None:
        """Go on from here. `absolute` are the absolute tolerances; `directions[i]` is the
        only way in which zero function i may cross; `step` the first step to try."""

    def shift(self, shifts: Sequence[float]) -> None:
        """Move the zero functions by so much from the next `restart` on; none: by nothing."""
        self._relations.shifts = shifts

    @abstractmethod
    def step(self, limit: float) -> March:
        """One step, not beyond `limit`; `BUDGET` stands for an ordinary one."""

    @abstractmethod
    def interpolate(self, t: float) -> Sequence[float]:
        """The states at a time within the last step."""

    @abstractmethod
    def last_step(self) -> float: ...

    def errors(self) -> Sequence[float]:
        """The error of each state in the last step tried, as a part of its tolerance; nothing
        where that is not known."""
        return ()

    @abstractmethod
    def counts(self) -> Counts: ...

    def close(self) -> None:  # noqa: B027 (most have nothing to give back)
        """Give back what the integrator holds outside of Python."""

    # From run to run

    #: Whether it may go on with another run of the same kernel (`renew`).
    keeps = False

    def renew(self, solver: Solver, settings: Settings) -> bool:
        """Be as one that was just made for another run; false where this one cannot."""
        return False

    def rest(self) -> None:  # noqa: B027 (most hold nothing that is large)
        """Let go of what belongs to the run that has ended."""

    def march(self, limit: float, recorder: Recorder, watch: Watch, steps: int) -> March:
        """March on; at `ROOT` and `LIMIT` the rows up to, not at, the time reached are taken."""
        kernel, past, switches = self._kernel, self._settings.past, self._settings.relations
        ydot, t = [0.0] * self._size, self.t
        for done in range(1, steps + 1):
            begin = t
            march = self.step(limit)
            if march.outcome is Outcome.FAILED:
                return replace(march, steps=done - 1)
            is_root = march.outcome is Outcome.ROOT
            zeros = self._zeros() if switches and not is_root else ()
            suspicion = self._dips.note(self.t, zeros) if zeros else Suspicion.NONE
            if suspicion or (is_root and (suspicion := self._dips.turn())):
                march = self._dip(suspicion, is_root) or march
            if self._settings.waves:
                march = self._switch(begin) or march
            if past is not None and not past.take(self, begin):
                return replace(UNSOLVED, steps=done)
            t = self.t
            ordinary = march.outcome is Outcome.BUDGET
            before = recorder.count
            if not self._take_rows(recorder, t + self.slack if ordinary else t - recorder.near):
                return replace(UNSOLVED, steps=done)
            if not ordinary:
                return replace(march, steps=done)
            if recorder.count == before:  # no row to begin the next step's blocks from
                known = self.ends_evaluated and kernel.w[0] == t
                if not known and kernel.rhs(t, self.y, ydot) != 0:
                    return replace(UNSOLVED, steps=done)
                kernel.accept(t)
            if self._size and self.poles.note():
                return replace(self._before_pole(), steps=done)
            if watch.moved(kernel.w):
                return March(Outcome.LOOK, steps=done)
        return March(Outcome.BUDGET, steps=steps)

    # How far loops may move in a step, where steps come from Python

    def _begin_step(self) -> None:
        w = self._kernel.w
        self._angles_before = [w[slot] for slot in self._settings.angles]

    def _is_far(self) -> bool:
        """Whether a loop may be closed in another way at the workspace's point than where the step
        began."""
        w, pairs = self._kernel.w, zip(self._settings.angles, self._angles_before, strict=False)
        return any(abs(w[slot] - before) > REACH for slot, before in pairs)

    # What zero functions do within a step

    def _zeros(self) -> Sequence[float]:
        """The zero functions at the end of the last step; nothing where it counts alone."""
        return ()

    @abstractmethod
    def _go_back(self, t: float, y: Sequence[float]) -> None:
        """Be at a place within the last step; `restart` follows."""

    def _begin_dips(self, t: float, y: Sequence[float], directions: Sequence[int]) -> None:
        self._dips.begin(t, y)
        self._crossing = tuple(directions)

    def _before_pole(self) -> March:
        """Back at the point before the step that went across a pole."""
        self._go_back(*self.poles.point)
        return March(Outcome.FAILED, cause=Cause.POLE)

    def _dip(self, suspicion: Suspicion, is_root: bool) -> March | None:
        """Go back to the first crossing within the last step, if there is one before its end, which
        may be a root itself."""
        dips = self._dips
        if suspicion is Suspicion.ROUGH:
            *_, before, last = ((t, g) for t, *g in dips.points[:POINTS].tolist())
            begin, end = before, last
            if is_root:
                begin, end = last, self._looks.point(self.interpolate, self.t)
            told = begin, end, dips.farthest, dips.points[POINTS, 1:]
            found = self._looks.search(self.interpolate, *told, self._crossing)
        else:
            found = dips.search(self.interpolate, self._crossing)
        if found is None or (is_root and found[0] >= self.t - SAME * abs(self.t)):
            return None
        t, directions = found
        self._go_back(t, list(self.interpolate(t)))
        return March(Outcome.ROOT, tuple(directions))

    def _switch(self, begin: float) -> March | None:
        """Go back to the first crossing since `begin`, however often functions switch."""
        found = self._waves.search(self.interpolate, begin, self.t, self._crossing)
        if found is None or not begin < found[0] < self.t:
            return None
        self._go_back(found[0], list(self.interpolate(found[0])))
        return March(Outcome.ROOT, tuple(found[1]))

    @cached_property
    def _looks(self) -> Looks:
        from planarc.solve.solvers.looks import Looks

        return Looks(self._relations, self._settings.relations)

    @cached_property
    def _waves(self) -> Waves:
        from planarc.solve.solvers.waves import Waves

        return Waves(self._relations, self._settings.relations)

    def _take_rows(self, recorder: Recorder, until: float) -> bool:
        """Every row due up to a time; false where the equations could not be solved."""
        while (due := recorder.due(until)) is not None:
            if self._kernel.outputs(due, self.interpolate(due)) != 0:
                return False
            recorder.take(due)
            recorder.next += 1
            self._kernel.accept(due)
        return True
