"""One run of `planarc simulate`: compile, integrate, write, tell."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter

from msgspec.structs import replace

from planarc import compiler, stages
from planarc.cli import console
from planarc.cli.exits import Exit, exit_code
from planarc.cli.files import Destinations, destinations, replaced, save
from planarc.cli.outcome import Outcome
from planarc.cli.progress import progress_line
from planarc.cli.settings import Setting, apply_settings
from planarc.cli.summary import details, moving_states, start_values, state_reasons, summary
from planarc.compiled import Compiled
from planarc.core.clock import Clock
from planarc.core.data import Data
from planarc.core.diagnostic import (
    Diagnostic,
    Exhausted,
    PlanarcError,
    Related,
    Repelling,
    Runaway,
    Severity,
    UsageError,
    led_to,
    unexplained,
)
from planarc.core.interruption import Interruption
from planarc.core.options import RunOptions
from planarc.core.prose import both, counted
from planarc.ir.kernel import Kernel
from planarc.ir.result import Interrupted, Result
from planarc.request.request import Request
from planarc.view.storage import refuse_no_match

#: Ctrl-C while files are written: they are written to their ends.
LATE = Diagnostic("C130", "interrupted after the run, whose results are saved")


class Job(Data):
    """The request of one run: model, options, files."""

    request: Request
    options: RunOptions
    settings: tuple[Setting, ...]
    output: Path | None
    report: Path | None
    no_output: bool
    no_report: bool
    variables: re.Pattern[str] | None = None  # of the result file
    units: bool = False
    start_from: str | None = None


class Run:
    """One run of the command; keeps what is known so far, so that a failure can say it."""

    def __init__(self, job: Job, as_json: bool) -> None:
        self.job = job
        self.as_json = as_json
        self.clock = Clock()
        self.begin = perf_counter()
        self.outcome = Outcome(ok=False, backend=job.options.backend.value)
        self._late = False  # Ctrl-C came when the run was over

    def finish(self) -> int:
        """Run, tell, and give the exit code."""
        try:
            result, remembered = self._simulate()
        except PlanarcError as error:
            self.outcome.diagnostics = led_to(self.outcome.diagnostics, error.diagnostics)
            self._tell(())
            return exit_code(error)
        if len(result.time):
            rows = summary(result, self._seconds(), remembered, self._written())
            self._tell((*rows, *details(result)) if console.is_verbose() else rows)
        else:
            self._tell(())
        return Exit.INTERRUPTED if self._late else _exit_of(result)

    def _simulate(self) -> tuple[Result, bool]:
        job, clock, outcome = self.job, self.clock, self.outcome
        compiled = compiler.compile_model(job.request, job.options.backend, clock)
        program = compiled.program
        outcome.model, outcome.diagnostics = program.name, compiled.warnings
        outcome.equations = program.equations_before, program.equations_after
        places = destinations(program.name, job.output, job.report, job.no_output, job.no_report)
        own = tuple(replaced(program.name, places.output))
        outcome.diagnostics += own
        if places.output is not None:
            refuse_no_match(program, job.variables)
        with clock.phase("compile again"):
            request, compiled, options, notes = apply_settings(
                job.settings, job.request, compiled, job.options
            )
        if notes:
            program = compiled.program
            outcome.equations = program.equations_before, program.equations_after
            outcome.diagnostics = (*compiled.warnings, *own, *notes)
        else:
            del clock.seconds["compile again"]
        if job.start_from is not None:
            with clock.phase("find start"):
                compiled, options = _at_place(job.start_from, request, compiled, options)
        with clock.phase("load"):
            kernel = compiled.load()
        with progress_line() as progress:
            result = compiler.run(compiled, options, clock, progress, kernel)
        self._know(result)
        outcome.diagnostics += tuple(_idle_inputs(result))
        if len(result.time):
            with clock.phase("write"), Interruption() as interruption:
                self._write(result, places, kernel)
            self._late = interruption.asked
        if self._late:
            outcome.diagnostics += (LATE,)
        outcome.ok = _exit_of(result) == Exit.DONE and not self._late
        return result, compiled.remembered

    def _know(self, result: Result) -> None:
        outcome, statistics = self.outcome, result.statistics
        for name in ("solver", "backend", "steps", "events"):
            setattr(outcome, name, getattr(statistics, name))
        outcome.states = next((c.states for c in reversed(moving_states(result))), ())
        outcome.rows = len(result.time)
        # What explains that something grows without end is told once.
        every = (*outcome.diagnostics, *result.warnings)
        repelling = next((d for d in every if isinstance(d, Repelling)), None)
        reason = repelling or next((d for d in every if isinstance(d, Runaway)), None)
        warnings = unexplained(outcome.diagnostics, result.warnings)
        ended = result.ended
        if reason is not None and isinstance(ended, Exhausted):
            outcome.diagnostics = tuple(d for d in outcome.diagnostics if d is not reason)
            warnings = [w for w in warnings if w is not reason]
            place = Related(reason.message, reason.span)
            related = (place, *reason.related, *ended.related)
            ended = replace(ended, hint=reason.hint, related=related)
        outcome.diagnostics += (*warnings, *([] if ended is None else [ended]))

    def _write(self, result: Result, places: Destinations, kernel: Kernel) -> None:
        """All files that can be written; raises UsageError of those that cannot."""
        from planarc.view.table.files import write_table
        from planarc.view.table.origin import Origin

        request = self.job.request
        origin = Origin(file=request.file, libraries=request.libraries)

        def table(path: Path) -> None:
            write_table(path, result, self.job.variables, self.job.units, origin)

        refused: list[Diagnostic] = []
        if places.output is not None:
            try:
                save(places.output, table)
                self.outcome.output = str(places.output)
            except UsageError as problem:
                refused += problem.diagnostics
        if places.report is not None:
            try:
                write_page(places.report, result, kernel)
                self.outcome.report = str(places.report)
            except UsageError as problem:
                refused += problem.diagnostics
        if refused:
            raise UsageError(refused)

    def _seconds(self) -> dict[str, float]:
        return {**self.clock.seconds, "total": perf_counter() - self.begin}

    def _written(self) -> tuple[str, ...]:
        found = []
        if self.outcome.output:
            found.append(f"{self.outcome.output} ({counted(self.outcome.rows or 0, 'row')})")
        if self.outcome.report:
            found.append(self.outcome.report)
        return tuple(found)

    def _tell(self, rows: Sequence[tuple[str, str]]) -> None:
        if self.as_json:
            self.outcome.seconds = self._seconds()
            console.say(self.outcome.as_json())
            return
        if rows and not console.is_quiet():
            console.say_rows(rows)
        console.complain(self.outcome.diagnostics)


def _at_place(
    place: str, request: Request, compiled: Compiled, options: RunOptions
) -> tuple[Compiled, RunOptions]:
    """The model to run at a place, and the options with its start values."""
    from planarc.api.analysis.starting import put_at
    from planarc.api.model import Model

    model, options = put_at(Model(request, options.backend, compiled), options, place)
    return model.compiled(), options


def write_page(path: Path, result: Result, kernel: Kernel | None = None) -> None:
    """The report; it holds no times, so that equal runs give equal pages."""
    from planarc.view.page import typeset
    from planarc.view.page.data import shown_unit
    from planarc.view.page.report import write_report
    from planarc.view.scene import make_scene

    rows = []
    units = {c.name: shown_unit(c) for c in result.program.columns}
    shown = {n: (factor, typeset.unit(unit)) for n, (factor, unit) in units.items()}
    for label, text in summary(result, {"total": 0.0}, False, ()):
        if label != "time":
            rows.append((label, start_values(result.held, shown) if label == "start" else text))
        if label == "states" and (why := state_reasons(result)):
            rows.append(("why these", why))
    rows += [row for row in details(result) if row[0] == "calls"]
    insight = stages.study(result, kernel)
    write_report(path, result, make_scene(result), rows, insight=insight)


def _exit_of(result: Result) -> Exit:
    if result.ended is None or result.ended.severity is not Severity.ERROR:
        return Exit.DONE
    if not len(result.time):
        return Exit.MODEL  # it has no start
    return Exit.INTERRUPTED if isinstance(result.ended, Interrupted) else Exit.RUN


def _idle_inputs(result: Result) -> Iterator[Diagnostic]:
    """The note about inputs of the model itself, which a command gives no signal, and which have no
    value of their own."""
    program = result.program
    names = [n for n in program.inputs if "." not in n and n in result and "(" not in n]
    idle = [n for n in names if len(result.time) and not result[n].any()]
    if idle:
        told = f"the inputs {both(idle)} values: they are 0"
        told = told if len(idle) > 1 else f"the input `{idle[0]}` a value: it is 0"
        yield Diagnostic(
            "C125",
            f"nothing gives {told}",
            severity=Severity.NOTE,
            hint=f'in Python write `model.simulate(inputs={{"{idle[0]}": ...}})`; '
            f"`--set {idle[0]}.start=...` gives it one value",
        )
