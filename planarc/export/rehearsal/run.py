"""A run of an instance, as a result like that of any other run.

In:   Compiled, RunOptions
Out:  Result

Start, steps, events and the choice of states are those of FMUs and pages. Python asks for the rows,
names events, gathers warnings, and asks any other run why one cannot begin or go on. As in an FMU,
start values are looked for from the assembly that was found at export, and steps pass by the rows.

Ctrl-C is noted, and looked for behind each row: an exception on the way from machine code to Python
would be lost.

Raises:    UsageError R407 for what an exported model knows not, R400 for values that it cannot
           take; PlanarcError where no start exists, C300 where a model cannot be exported.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from planarc.core.clock import Clock
from planarc.core.diagnostic import Diagnostic, PlanarcError, usage_error
from planarc.core.interruption import Interruption
from planarc.core.options import Backend, RunOptions, Solver
from planarc.export.endings import ends_of
from planarc.export.rehearsal.library import Instance, Library
from planarc.export.wishes import finer
from planarc.ir.result import EventRecord, Held, Interrupted, Result, StateChoice, Statistics
from planarc.solve.contact.messages import told
from planarc.solve.contact.touches import TOLD, Points
from planarc.solve.doubts import doubts
from planarc.solve.events.asserts import AssertWatch
from planarc.solve.messages.event import ticked
from planarc.solve.messages.text import Reader
from planarc.solve.recorder import Recorder, constants
from planarc.solve.settings import Request, resolve

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.core.arrays import Vector

#: Machine code alone leads no further.
_STUCK = "R484"


def rehearse(
    compiled: Compiled,
    options: RunOptions,
    clock: Clock,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Run the exported model."""
    if options.backend is not Backend.NATIVE:
        raise usage_error("R407", f"the solver `{options.solver}` is machine code alone",
                          hint="leave the back end out")  # fmt: skip
    request = resolve(compiled.program, options)
    try:
        with clock.phase("load"):
            library = _library(compiled, options.solver is Solver.EXPORTED_STIFF)
    except PlanarcError as problem:
        if problem.diagnostics[0].code == "C300":
            raise
        told = _simulated(compiled, options)
        if told.ended is None:
            raise
        return told
    with clock.phase("simulate"), library.instance() as instance:
        run = _Run(library, instance, request)
        if not run.begin():
            brief = replace(options, stop=request.start, interval=None, intervals=1)
            told = _simulated(compiled, brief)
            if told.ended is not None:
                return told
            raise PlanarcError(run.without_start())
        result = run.go(progress)
    if result.ended is not None and result.ended.code == _STUCK:
        usual = _simulated(compiled, options).ended
        if usual is not None:
            result = replace(result, ended=usual)
    found = doubts(compiled.program, options)
    return replace(result, warnings=(*result.warnings, *found)) if found else result


def _simulated(compiled: Compiled, options: RunOptions) -> Result:
    """Any other run, which tells why it cannot begin or go on."""
    from planarc.solve.simulate import simulate

    return simulate(compiled.program, compiled.load(), replace(options, solver=Solver.AUTO))


def _library(compiled: Compiled, stiff: bool) -> Library:
    known: dict[bool, Library] = compiled.beside.setdefault("rehearsal", {})
    if stiff not in known:
        known[stiff] = Library(compiled, stiff)
    return known[stiff]


class _Run:
    """One run. The instance stands in the place of a kernel: it has a workspace `w`."""

    def __init__(self, library: Library, instance: Instance, request: Request) -> None:
        self.program = program = library.program
        self._library, self._instance, self._request = library, instance, request
        kernel: Any = instance
        self._asserts = AssertWatch(program, kernel)
        self._recorder = Recorder(program, kernel, request.grid, self._asserts.slots)
        self._events: list[EventRecord] = []
        self._choices: list[StateChoice] = []
        self._taken: tuple[int, ...] = ()  # the slots of the present states
        self._touches = Points(program)
        self._names = {c.slot: c.display for c in program.candidates}
        self._before: Mapping[str, Vector] = {}
        self._due: tuple[list[int], list[int]] = [], []
        self._held: tuple[Held, ...] = ()
        self._interruption = Interruption()

    def go(self, progress: Callable[[float], None] | None) -> Result:
        ended: Diagnostic | None
        try:
            with self._interruption:
                ended = self._march(progress)
        except KeyboardInterrupt:
            ended = Interrupted("R440", f"interrupted at t = {self._instance.w[0]:.6g} s")
        self._asserts.check(self._recorder, True)
        return self._result(ended)

    def _march(self, progress: Callable[[float], None] | None) -> Diagnostic | None:
        """Through all rows, or up to what ends the run. Raises KeyboardInterrupt."""
        ended: Diagnostic | None = None
        grid, recorder = self._request.grid, self._recorder
        while ended is None and recorder.next < len(grid):
            t = float(grid[recorder.next])
            flag = self._instance.go(t)
            ended = self._end(flag)
            arrived = flag >= 0 and t - self._instance.w[0] <= recorder.near
            if arrived and recorder.due(t) is not None:  # no event has taken its place
                recorder.take(t)
                recorder.pass_by(t)
            self._asserts.check(recorder, flag >= 0 and recorder.next <= 1)
            self._note_states(t if ended is None else min(t, float(self._instance.w[0])))
            if progress is not None:
                progress(t)
            self._break_off()
        return ended

    def _break_off(self) -> None:
        if self._interruption.asked:
            raise KeyboardInterrupt

    def begin(self) -> bool:
        """Whether there is a start."""
        program, request, instance = self.program, self._request, self._instance
        candidates = {c.start: c.slot for c in program.candidates}
        names = {p.slot: p.name for p in program.parameter_slots} | self._names
        names |= {d.start: d.name for d in program.discretes}
        names |= {f.start: f.display for f in program.fixed}
        given = {**request.values} | {candidates.get(k, k): v for k, v in request.starts.items()}
        for slot, value in given.items():
            if value != instance.w[slot] and not instance.set(slot, value):
                name = names.get(slot, program.name)
                raise usage_error(
                    "R400",
                    f"`{name}` cannot be set in an exported model",
                    hint="the solver `auto` takes any value",
                )
        if request.stepping and request.fixed_step is not None:
            instance.step_by(request.fixed_step)
        if program.relations or program.samplers:
            instance.listen(self._heard)
        with self._interruption:
            refused = instance.begin(request.start, finer(request.tolerance))
        self._break_off()
        if refused:
            return False
        self._held = tuple(
            Held(self._names[slot], float(instance.w[start]), float(instance.w[slot]), True)
            for slot, start in self._library.held
            if slot in self._names
        )
        self._note_states(request.start)
        self._note_struck(request.start)
        return True

    def _note_struck(self, t: float) -> None:
        """Tell of impacts at the start."""
        if not self._touches.all:
            return
        import numpy as np

        after = self._of_touches()
        before = {name: np.zeros_like(values) for name, values in after.items()}
        if texts := told(self._touches, before, after, begins=True):
            self._events.insert(0, EventRecord(t, tuple(texts)))

    def without_start(self) -> Diagnostic:
        return Diagnostic(
            _STUCK,
            "with these parameters and start values no start is found from the assembly that the "
            f"model is exported with: {self._instance.blame()}",
            hint="the solver `auto` finds one",
        )

    def _heard(self, time: float, behind: bool, crossing: list[int], fired: list[int]) -> None:
        """An event: its rows, and what it is told with."""
        recorder, count = self._recorder, self._recorder.count
        recorder.take(time)
        if not behind:
            self._before, self._due = self._of_touches(), (crossing, fired)
            return
        meets = told(self._touches, self._before, self._struck()) if self._touches.all else []
        own, (crossing, fired) = self._touches.components, self._due
        switched = [self.program.relations[i] for i in crossing]
        others = [(r.text, r.component) for r in switched if r.component not in own]
        kernel: Any = self._instance
        read = Reader(self.program, kernel, 0.0)
        texts = [*(text for text, _ in others), *(ticked(self.program, read, i) for i in fired)]
        if meets or texts:
            owners = ("",) * len(meets) + tuple(owner for _, owner in others)
            self._events.append(EventRecord(time, (*meets, *texts), owners))
        if meets or crossing or fired:
            recorder.pass_by(time)
        else:
            recorder.cut(count - 1)

    def _of_touches(self) -> dict[str, Vector]:
        w = self._instance.w
        return {n: w[[touch.slots[n] for touch in self._touches.all]] for n in TOLD}

    def _struck(self) -> dict[str, Vector]:
        """Behind an event; an impulse that is the last one's is none."""
        import numpy as np

        found = self._of_touches()
        same = found["impulse"] == self._before["impulse"]
        return found | {"impulse": np.where(same, 0.0, found["impulse"])}

    def _note_states(self, t: float) -> None:
        slots = self._instance.states
        if slots != self._taken or not self._choices:
            self._taken = slots
            self._choices.append(StateChoice(t, tuple(self._names[slot] for slot in slots)))

    def _end(self, flag: int) -> Diagnostic | None:
        """Why the run ends here, if it does."""
        if flag == 0:
            return None
        if flag < 0:
            return Diagnostic(
                _STUCK,
                f"the exported model cannot go on {self._instance.blame()}",
                hint="the solver `auto` gets on",
            )
        message = self._instance.message(flag)
        known = [*ends_of(self.program)]
        if flag > len(known):  # a delay
            return Diagnostic(_STUCK, message, hint="the solver `auto` gets on")
        return replace(known[flag - 1], message=message)

    def _result(self, ended: Diagnostic | None) -> Result:
        program, instance, recorder = self.program, self._instance, self._recorder
        kernel: Any = instance
        time, data = recorder.rows()
        return Result(
            program=program,
            time=time,
            data=data,
            stored=recorder.stored,
            constants=dict(constants(program, kernel)),
            statistics=Statistics(
                solver=str(self._request.solver),
                backend=str(Backend.NATIVE),
                steps=None,
                events=len(self._events),
                reason="asked for; what FMUs and pages run",
            ),
            states=tuple(self._choices),
            held=self._held,
            events=tuple(self._events),
            warnings=tuple(self._asserts.warnings()),
            ended=ended,
        )
