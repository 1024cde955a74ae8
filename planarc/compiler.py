"""From a file to a result: the stages, one call each.

    stage       takes               gives               in
    ---------   -----------------   -----------------   --------------------
    parse       source text         syntax tree         parse/parser.py
    flatten     classes, a name     FlatModel           flatten/pipeline.py
    lower       FlatModel           Dae                 lower/pipeline.py
    structure   Dae                 SortedDae           structure/pipeline.py
    codegen     SortedDae           Program, code       codegen/pipeline.py
    load        Program, code       Kernel              solve/kernels/
    simulate    Kernel, options     Result              solve/simulate.py
    study       Result, Kernel      Insight             insight/study.py

Stages do not know each other; only this file calls them in a row. What a model was
compiled to is remembered (`remembered.py`), so that the second run starts at `load`.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity
from planarc.core.options import ACCEPTING, Backend, Redundant, RunOptions
from planarc.request.request import Request, Target, open_target

if TYPE_CHECKING:
    from planarc.ir.dae import Dae
    from planarc.ir.derivatives import Scope
    from planarc.ir.flat import FlatModel
    from planarc.ir.insight import Insight
    from planarc.ir.mechanism import Mechanism, Mobility
    from planarc.ir.program import Kernel, Program
    from planarc.ir.result import Result
    from planarc.ir.sorted import SortedDae
    from planarc.remembered import Checked


class Clock(Struct):
    """Wall seconds spent in each phase, in the order in which they began."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        begin = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - begin


class Compiled(Data):
    """A program and its code for one back end, ready to be loaded any number of times."""

    program: Program
    backend: Backend
    code: str | bytes  # NumPy source, or a native object file
    warnings: tuple[Diagnostic, ...] = ()
    remembered: bool = False  # True when it came from the cache
    _slopes: dict[Scope, str | bytes | None] = field(default_factory=dict)

    def load(self) -> Kernel:
        """A kernel with a workspace of its own."""
        from planarc.solve.kernels import load

        return load(self.program, self.code, self.slopes)

    def slopes(self, scope: Scope) -> str | bytes | None:
        """The code of derivatives, made when it is first asked for and remembered; None
        where the model calls a function that has none."""
        if scope not in self._slopes:
            self._slopes[scope] = to_slopes(self, scope)
        return self._slopes[scope]


def flatten(target: Target, clock: Clock | None = None) -> FlatModel:
    """Parse what is needed and flatten. Raises PlanarcError."""
    from planarc.flatten.pipeline import flatten as run_stage
    from planarc.flatten.typing.units import UnitCheck

    seconds = (clock or Clock()).seconds
    begin, parsed = perf_counter(), target.reader.seconds
    try:
        model = run_stage(target.library, target.class_name, UnitCheck(target.units.value))
        return replace(model, warnings=(*target.warnings, *model.warnings))
    finally:
        # Files of libraries are parsed on the way; that time counts as parsing.
        seconds["parse"] = target.reader.seconds
        seconds["flatten"] = perf_counter() - begin - (target.reader.seconds - parsed)


def to_dae(model: FlatModel, clock: Clock | None = None) -> Dae:
    from planarc.lower.pipeline import lower

    with (clock or Clock()).phase("lower"):
        return lower(model)


def find_mechanism(dae: Dae) -> Mechanism | None:
    """The links and joints of a model, for insight; the run needs nothing of it."""
    from planarc.insight.topology import find_mechanism as find

    return find(dae)


def to_sorted(dae: Dae, clock: Clock | None = None) -> SortedDae:
    from planarc.structure.pipeline import structure

    try:
        with (clock or Clock()).phase("structure"):
            return structure(dae)
    except PlanarcError as problem:
        # Without a connection that was left out, equations cannot fit: that is the one message.
        left_out = [replace(w, severity=Severity.ERROR) for w in dae.warnings if w.code == "F311"]
        if left_out:
            raise PlanarcError(left_out) from None
        raise PlanarcError(_held_too_often(dae, problem.diagnostics)) from None


def _held_too_often(dae: Dae, found: Sequence[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Says of equations that do not fit that there are too many joints, where that is so."""
    mechanism = find_mechanism(dae)
    if mechanism is None or mechanism.mobility >= 0:
        return tuple(found)
    from planarc.insight.facts import count_text
    from planarc.structure.report import TWICE

    known = found[0].hint or ""
    too_many = "there are too many joints or bars, leave some out:"
    hint = f"{known + ';' if TWICE in known else too_many} {count_text(mechanism)}"
    hint += f"; those that fit are accepted with {ACCEPTING}"
    return (replace(found[0], hint=hint), *found[1:])


def to_program(model: SortedDae, clock: Clock | None = None) -> Program:
    from planarc.codegen.pipeline import generate

    with (clock or Clock()).phase("codegen"):
        return generate(model)


def to_code(program: Program, backend: Backend, clock: Clock | None = None) -> str | bytes:
    """NumPy source, or a native object file."""
    with (clock or Clock()).phase("codegen"):
        try:
            if backend is Backend.NUMPY:
                from planarc.codegen.numpy.printer import source

                return source(program)
            from planarc.codegen.native.machine import compile_object

            return compile_object(program)
        except PlanarcError as problem:
            from planarc.codegen.refusal import located

            raise located(problem, program) from None


def to_slopes(compiled: Compiled, scope: Scope) -> str | bytes | None:
    """See `Compiled.slopes`; an empty entry of the cache stands for None."""
    from planarc.core import cache

    native = compiled.backend is Backend.NATIVE
    # Equal code may be of programs that differ in what may be asked of it.
    program = compiled.program
    asked = (
        [(c.slot, c.derivative) for c in program.candidates],
        [p.slot for p in program.parameter_slots if p.settable],
        [program.slots[name] for name in program.inputs],
    )
    key = cache.key("slopes", scope.value, compiled.code, repr(asked))
    known = cache.load("slopes", key)
    if known is None:
        with _no_collection():
            known = _derivatives(compiled, scope)
        cache.store("slopes", key, known)
    return (known if native else known.decode()) or None


def _derivatives(compiled: Compiled, scope: Scope) -> bytes:
    if compiled.backend is Backend.NATIVE:
        from planarc.codegen.native.machine import compile_slopes

        return compile_slopes(compiled.program, scope) or b""
    from planarc.codegen.numpy.printer import slopes_source

    return (slopes_source(compiled.program, scope) or "").encode()


@contextmanager
def _no_collection() -> Iterator[None]:
    """Without Python's search for cycles: trees have few, and it takes a third of the time."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


def check_model(request: Request, clock: Clock | None = None, start: bool = False) -> Checked:
    """All stages up to `structure`, or what an earlier check remembered of them.

    Mobility by rank is found where there are loops, whose conditions may depend on each other. A
    start that cannot be found is an error only with `start`.
    """
    from planarc.remembered import Checked, recall_check, remember_check

    clock = clock or Clock()
    with clock.phase("recall"):
        known = recall_check(request)
    if known is not None and not (start and known.mechanism and known.mobility is None):
        return known
    with _no_collection():
        target = open_target(request)
        flat = flatten(target, clock)
        dae = to_dae(flat, clock)
        model = to_sorted(dae, clock)
        sizes = model.equations_before, model.equations_after, model.state_count
        checked = Checked(flat.name, *sizes, flat.warnings, find_mechanism(dae))
        if checked.mechanism is not None and (start or checked.mechanism.loops > 0):
            try:
                checked = replace(checked, mobility=_find_mobility(model, checked.mechanism, clock))
            except PlanarcError:
                if start:
                    raise
    remember_check(request, target.reader, checked)
    return checked


def _find_mobility(model: SortedDae, mechanism: Mechanism | None, clock: Clock) -> Mobility | None:
    """With NumPy's back end, which is there at once."""
    from planarc.probe.mobility import mobility_at_start

    program = replace(to_program(model, clock), mechanism=mechanism)
    code = to_code(program, Backend.NUMPY, clock)
    with clock.phase("start"):
        return mobility_at_start(Compiled(program, Backend.NUMPY, code))


def compile_model(
    request: Request, backend: Backend = Backend.NATIVE, clock: Clock | None = None
) -> Compiled:
    """All stages up to code for one back end, or what an earlier run remembered of them."""
    from planarc.remembered import Remembered, recall, remember

    clock = clock or Clock()
    with clock.phase("recall"):
        known = recall(request, backend)
    if known is not None:
        return Compiled(known.program, backend, known.code, known.warnings, remembered=True)
    with _no_collection():
        target = open_target(request)
        model = flatten(target, clock)
        try:
            dae = to_dae(model, clock)
            program, notes = find_program(dae, request.redundant, clock)
        except PlanarcError as problem:  # a warning may tell what led to it
            told = {(e.code, e.span) for e in problem.diagnostics}
            others = (w for w in model.warnings if (w.code, w.span) not in told)
            raise PlanarcError((*others, *problem.diagnostics)) from None
        program = replace(program, figures=model.figures)
        code = to_code(program, backend, clock)
    warnings = (*model.warnings, *notes)
    remember(request, backend, target.reader, Remembered(program, code, warnings))
    return Compiled(program, backend, code, warnings)


def find_program(
    dae: Dae, redundant: Redundant, clock: Clock | None = None
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """With what is to be told of it."""
    clock = clock or Clock()
    mechanism = find_mechanism(dae)
    if redundant is Redundant.ACCEPT and mechanism is not None:
        from planarc.probe.redundancy import accept_redundancy

        return accept_redundancy(dae, mechanism, clock)
    return replace(to_program(to_sorted(dae, clock), clock), mechanism=mechanism), ()


def run(
    compiled: Compiled,
    options: RunOptions,
    clock: Clock | None = None,
    progress: Callable[[float], None] | None = None,
    kernel: Kernel | None = None,
) -> Result:
    """One run of a compiled model; it may be run any number of times. A `kernel` that was
    loaded before is used again."""
    from planarc.ir.dae import START_TIME
    from planarc.solve.simulate import simulate as run_stage

    clock = clock or Clock()
    if options.start is not None and START_TIME in compiled.program.slots:
        options = replace(options, values={**options.values, START_TIME: options.start})
    if kernel is None:
        with clock.phase("load"):
            kernel = compiled.load()
    with clock.phase("simulate"):
        return run_stage(compiled.program, kernel, options, progress=progress)


def study(result: Result, kernel: Kernel | None = None) -> Insight:
    """What is known of a run's mechanism; of the ranks only with the run's kernel."""
    from planarc.insight.study import study as run_stage

    return run_stage(result, kernel)


def simulate(
    file: Path | None = None,
    class_name: str | None = None,
    *,
    libraries: Sequence[Path] = (),
    options: RunOptions | None = None,
) -> Result:
    """Compile and run a file, or a class of a library."""
    options = options or RunOptions()
    request = Request(
        file, class_name, tuple(libraries), redundant=options.redundant or Redundant.REFUSE
    )
    return run(compile_model(request, options.backend), options)
