"""What a run works with, and what it does at every stop: rows, asserts, going on from a point."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isclose, isfinite
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.interruption import Interruption
from planarc.ir.expr import Expr
from planarc.ir.frame import angles_of_loops
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import Program
from planarc.ir.result import EventRecord, Held
from planarc.solve.effort import Effort
from planarc.solve.events.already import AlreadyTrue
from planarc.solve.events.asserts import AssertWatch
from planarc.solve.events.chatter import Chatter
from planarc.solve.events.delays import Delays
from planarc.solve.events.instants import Schedule
from planarc.solve.events.iteration import Events
from planarc.solve.events.jumps import Jumps
from planarc.solve.events.passed import Passed
from planarc.solve.messages.text import Reader
from planarc.solve.opened import set_workspace
from planarc.solve.recorder import Recorder
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.settings import Request
from planarc.solve.solvers.choice import make_integrator
from planarc.solve.solvers.integrator import Cause, Integrator, Settings
from planarc.solve.states.exchange import GoOn, States

if TYPE_CHECKING:
    from planarc.solve.messages.labour import Labour

#: A value that changes less between two rows of an instant is the same.
ROUNDING = 1e-12


class Bench:
    """The parts of one run. `y` are the values of the states at time `t`."""

    def __init__(
        self,
        program: Program,
        kernel: Kernel,
        request: Request,
        backend: str,
        known: Integrator | None = None,
    ) -> None:
        """`known` is the integrator of the kernel's last run; what becomes of it is the caller's
        to see (`integrator`)."""
        self.program, self.kernel, self.request = program, kernel, request
        self.backend = backend
        set_workspace(program, kernel, request)
        self.rescue = Rescue(program, kernel)
        self._jumps = Jumps(program, kernel)
        self._leaps: list[tuple[float, int]] = []  # the last ones: when, and the rows before
        self.events = Events(program, kernel, request, self.rescue)
        self._passed = Passed(self.events.crossings)
        self._already = AlreadyTrue(program, kernel)
        self._chatter = Chatter(program, self.events.crossings, request, self.events.touches)
        self.schedule = Schedule(program, kernel, request.start, request.stop)
        self.asserts = AssertWatch(program, kernel)
        self.recorder = Recorder(program, kernel, request.grid, self.asserts.slots)
        self.delays = Delays(program, kernel, request.start, request.span, request.tolerance)
        form = _form(program)
        settings = Settings(
            request.tolerance,
            request.span,
            len(program.relations),
            self.delays.longest_step,
            self.delays if self.delays.present else None,
            request.fixed_step,
            form.followed,
            form.waves,
            form.angles,
            bool(self.events.touches),
            _turning(program, kernel, request.start),
        )
        self.integrator: Integrator
        if request.stepping:
            from planarc.solve.stepping.moreau import Moreau

            self.integrator = Moreau(program, kernel, form.states, settings)
            self.reason = "steps with contacts"
        else:
            self.integrator, self.reason = make_integrator(
                request.solver, kernel, form.states, settings, known
            )
        looks, delayed = self.integrator.looks, self.delays.present
        self.effort = Effort(program, looks, request.start, request.span)
        self.states = States(program, kernel, self.recorder, delayed, looks)
        self.labour: Labour | None = None  # once a stretch takes many steps
        self.interruption = Interruption()
        self.ended: Diagnostic | None = None
        self.warnings: list[Diagnostic] = []
        self.held: tuple[Held, ...] = ()
        self.records: list[EventRecord] = []
        self.open_blocks: set[int] = set()  # of which unknowns were left open in some mode

    def close(self) -> None:
        self.integrator.close()

    def restart(self, t: float, y: Sequence[float], step: float | None = None) -> None:
        """Go on from here; the point becomes the one that nonlinear blocks start from."""
        self.delays.cross(t)
        if self.kernel.outputs(t, y) != 0:
            self.ended = self.ended or self._stopped(t, y)
            return
        self._go_on(t, y, step)

    def _go_on(self, t: float, y: Sequence[float], step: float | None = None) -> None:
        """The same, where the workspace holds this point already."""
        self.kernel.accept(t)
        self._judge_open(t, y)
        self.delays.resume(t)
        self.states.resume(t, y)
        self.integrator.sharp = sharp = self.events.sharpness()
        absolute = self.states.absolute(self.request.tolerance * sharp)
        directions = self.events.crossings.directions()
        self.integrator.shift(self.events.crossings.shifts())
        self.integrator.poles.begin(self.states.places(), absolute)
        self.integrator.restart(t, y, absolute, directions, step)

    def _follow(self, decision: GoOn | Diagnostic | None) -> None:
        """Do as the look at the states says."""
        if isinstance(decision, Diagnostic):
            self.ended = decision
        elif decision is not None:
            if decision.back:
                self.asserts.forget(self.recorder.count)
            self.restart(decision.t, decision.y, decision.step)

    def _stopped(
        self,
        t: float,
        y: Sequence[float],
        cause: Cause | None = None,
        block: int = -1,
        way: float | None = None,
    ) -> Diagnostic:
        """The message about a run that cannot go on from here."""
        from planarc.solve.messages import failure

        scene = failure.Scene(
            self.program,
            self.kernel,
            self.states.selection,
            self.request.span,
            self.integrator.errors(),
            self.recorder.last(),
            float(self.recorder.time[self.recorder.count - 1]) if self.recorder.count else -inf,
            way,
        )
        failed = self.kernel.failed_block if block < 0 else block
        return self.rescue.told(failure.stopped(scene, t, y, cause, block), t, failed)

    def _judge_open(self, t: float, y: Sequence[float]) -> None:
        """Warn of what the equations leave open in this mode, once for each block."""
        block = self.kernel.open_block
        if block < 0:
            return
        from planarc.solve.messages.open_unknowns import judge_open

        found = judge_open(self.program, self.kernel, t, y, self.open_blocks)
        if found is None:
            return
        if found.severity is Severity.ERROR:
            self.ended = self.ended or found
        else:
            self.open_blocks.add(block)
            self.warnings.append(found)

    def _row(self, t: float, y: Sequence[float]) -> bool:
        if self.kernel.outputs(t, y) != 0:
            self.ended = self.ended or self._stopped(t, y)
            return False
        self.recorder.take(t)
        return True

    def _row_where_new(self, t: float, y: Sequence[float]) -> None:
        """A row at the instant of the last one, where what a result shows is another."""
        shown, before = _shown(self.program), self.recorder.last()
        if self._row(t, y):
            pairs = [(v, before[s]) for s, v in self.recorder.last().items() if s in shown]
            if all(isclose(a, b, rel_tol=ROUNDING, abs_tol=ROUNDING) for a, b in pairs):
                self.recorder.cut(self.recorder.count - 1)

    def _note(self, ended: Diagnostic | None, warnings: Sequence[Diagnostic]) -> None:
        self.ended = self.ended or ended
        self.warnings.extend(warnings)

    def _check_values(self) -> None:
        """End the run before the first row without a finite number: an integrator that takes rows
        by itself looks at the states only."""
        row = self.recorder.first_not_finite()
        if row is None:
            return
        from planarc.solve.messages.failure import Place, not_finite

        recorder, t = self.recorder, float(self.recorder.time[row])
        for slot, column in recorder.stored.items():
            self.kernel.w[slot] = float(recorder.data[row, column])
        self.ended = not_finite(self.program, self.kernel, Place(t, "at"), t)
        recorder.cut(row)
        self.asserts.forget(row)

    def _check_asserts(self, all_rows: bool) -> None:
        """Asserts at new rows; the rows after a failed one are taken back."""
        found, row = self.asserts.check(self.recorder, all_rows)
        for diagnostic in found:
            self.ended = diagnostic
            self.recorder.cut(row + 1)


def _turning(program: Program, kernel: Kernel, t: float) -> tuple[tuple[int, float], ...]:
    """The slots of angles of which sines are asked, with how far these turn as those move by 1."""
    read = Reader(program, kernel, t)
    return tuple((slot, _size(read, e)) for slot, e in program.turning)


def _size(read: Reader, factor: Expr) -> float:
    try:
        size = abs(float(read(factor)))
    except (ArithmeticError, ValueError):
        return 1.0
    return size if isfinite(size) else 1.0


class _Form(Data):
    """What the settings of all integrators of a program have in common."""

    states: int
    followed: tuple[int, ...]  # the slots of unknowns that follow a branch from point to point
    waves: bool
    angles: tuple[int, ...]


@once
def _form(program: Program) -> _Form:
    blocks = (b for b in program.blocks if not b.height and not b.linear)
    return _Form(
        program.state_count,
        tuple(program.slots[repr(x)] for b in blocks for x in b.tears),
        any(r.waves for r in program.relations),
        tuple(slot for slot, _ in angles_of_loops(program)),
    )


@once
def _shown(program: Program) -> frozenset[int]:
    """The slots of what a result shows."""
    return frozenset(c.slot for c in program.columns if not c.name.startswith("$"))
