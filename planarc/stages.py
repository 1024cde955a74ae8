"""The stages one by one: each a call with its clock, and with errors as a user needs them.

`compiler` calls them in a row; whoever wants to stop in between, or to begin with data of
another origin, calls them here. Imports of stages stand in the functions: a command loads
what it runs.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from time import perf_counter
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.clock import Clock
from planarc.core.diagnostic import (
    Diagnostic,
    HeldAgainst,
    Laborious,
    Miscounted,
    PlanarcError,
    Related,
    Runaway,
    Severity,
)
from planarc.core.mend import Accept
from planarc.core.options import ACCEPTING, Backend

if TYPE_CHECKING:
    from planarc.flatten.checks.balance import Lack
    from planarc.flatten.pipeline import Unbalanced
    from planarc.ir.dae import Dae
    from planarc.ir.derivatives import Scope
    from planarc.ir.flat import FlatModel
    from planarc.ir.insight import Insight
    from planarc.ir.kernel import Kernel
    from planarc.ir.mechanism import Mechanism
    from planarc.ir.program import Program
    from planarc.ir.result import Result
    from planarc.ir.sorted import SortedDae
    from planarc.request.request import Target


_TOO_MANY = (
    "there are too many joints or bars: leave some out, or put a joint where parts are fastened to "
    "each other;"
)


def flatten(target: Target, clock: Clock | None = None) -> FlatModel:
    """The flat model of a class; files of libraries are parsed on the way. Raises PlanarcError."""
    from planarc.flatten.pipeline import Unbalanced
    from planarc.flatten.pipeline import flatten as run_stage
    from planarc.flatten.typing.units import UnitCheck

    clock = clock or Clock()
    seconds = clock.seconds
    begin, parsed = perf_counter(), target.reader.seconds
    try:
        units = UnitCheck(target.units.value)
        model = run_stage(target.library, target.class_name, units, clock.watch)
        return replace(model, warnings=(*target.warnings, *model.warnings))
    except Unbalanced as problem:
        raise _who_is_to_blame(problem) from None
    finally:
        seconds["parse"] = target.reader.seconds
        seconds["flatten"] = perf_counter() - begin - (target.reader.seconds - parsed)


def _who_is_to_blame(problem: Unbalanced) -> PlanarcError:
    """The user's own equations and unknowns that are too many or missing, where there are any."""
    from planarc.flatten.checks.passed_over import with_branch
    from planarc.structure.blame import explain_discretes, explain_misfit
    from planarc.structure.unmatched import find_misfit, without_written

    if problem.reasons:
        return problem
    try:
        dae = to_dae(problem.model)
    except PlanarcError:
        return problem
    arrays = {n: n.rpartition("[")[0] or n for n in (v.name for v in dae.variables)}
    inputs = {n: array for n, array in arrays.items() if array in problem.imbalance.inputs}
    lack = problem.imbalance.lack
    told = _lacking(dae, lack, inputs) if lack is not None and lack.component else ()
    if not told:
        inputs = without_written(dae, inputs)
        misfit = find_misfit(dae, inputs, problem.imbalance.suspect)
        over, under = explain_misfit(dae, misfit, inputs)
        told = (*over, *under) or explain_discretes(dae) or _lacking(dae, lack, inputs)
    component = lack.component if lack is not None else ""
    told = tuple(with_branch(d, component, problem.imbalance.absent) for d in told)
    code, count = problem.diagnostics[0].code, Related(problem.imbalance.sizes, detail=True)
    found = [
        Miscounted(code, d.message, d.span, hint=d.hint, related=(*d.related, count)) for d in told
    ]
    return PlanarcError(found) if found else problem


def _lacking(dae: Dae, lack: Lack | None, inputs: Collection[str]) -> tuple[Diagnostic, ...]:
    """The class of the user's that has too few equations."""
    from planarc.flatten.checks.balance import lacking
    from planarc.ir.places import is_own
    from planarc.structure.unmatched import find_lack

    if lack is None or not is_own(dae, lack.class_span):
        return ()
    names, flows = find_lack(dae, lack.component, lack.flows, lack.given, inputs)
    inside = {name.removeprefix(f"{lack.component}.") for name in inputs}
    return (lacking(lack, names, flows, inside),)


def to_dae(
    model: FlatModel,
    clock: Clock | None = None,
    inputs: Sequence[str] = (),
    placed: bool = False,
) -> Dae:
    """The scalar hybrid system of a flat model, with some variables as inputs; `placed`: see
    `lower`. Raises PlanarcError."""
    from planarc.lower.pipeline import lower

    with (clock or Clock()).phase("lower"):
        dae = lower(model, placed=placed)
    if not inputs:
        return dae
    from planarc.request.opened import open_inputs

    return open_inputs(dae, inputs)


def to_lead(model: FlatModel, clock: Clock | None = None) -> Program | None:
    """The program that goes from `simplified` to `actual` of each `homotopy`; None where it has
    no structure that is the same all the way."""
    from planarc.lower.pipeline import lower

    try:
        with (clock or Clock()).phase("lower"):
            dae = lower(model, blended=True)
        return to_program(to_sorted(dae, clock), clock)
    except PlanarcError:
        return None


def find_mechanism(dae: Dae) -> Mechanism | None:
    """The links and joints of a model, for insight; the run needs nothing of it."""
    from planarc.insight.attachment import locked
    from planarc.insight.copied import find_copied
    from planarc.insight.topology import find_mechanism as find

    found = find(dae)
    if found is None:
        return None
    return replace(found, locked=locked(dae, found), copied=find_copied(dae))


def to_sorted(dae: Dae, clock: Clock | None = None) -> SortedDae:
    """The model reduced to index 1 and sorted. Raises PlanarcError, in words of the mechanism
    where it has too many joints or lacks a connection."""
    from planarc.structure.pipeline import structure

    try:
        with (clock or Clock()).phase("structure"):
            return structure(dae)
    except PlanarcError as problem:
        from planarc.ir.flat import LeftOut

        # Without a connection that was left out, equations cannot fit: that is the one message.
        left_out = [
            replace(w, severity=Severity.ERROR) for w in dae.warnings if isinstance(w, LeftOut)
        ]
        if left_out:
            raise PlanarcError(left_out) from None
        from planarc.insight.misfit import part_of_others

        if (part := part_of_others(dae)) is not None:
            raise PlanarcError(part) from None
        mechanism = find_mechanism(dae)
        floating = None if mechanism is None else _floating(dae, mechanism)
        if floating is not None:
            raise PlanarcError(floating) from None
        found = _in_words_of_parts(dae, mechanism, problem)
        if mechanism is not None:
            found = (mechanism.with_copied(found[0]), *found[1:])
        raise type(problem)(found) from None


def _floating(dae: Dae, mechanism: Mechanism) -> Diagnostic | None:
    """Parts that nothing joins to the ground: their equations cannot fit, whatever these say."""
    from planarc.insight.attachment import attachment_error

    return attachment_error(dae, mechanism)


def _in_words_of_parts(
    dae: Dae, mechanism: Mechanism | None, problem: PlanarcError
) -> tuple[Diagnostic, ...]:
    """What was connected wrongly, where that is why equations do not fit; else the equations."""
    from planarc.insight.misfit import explain_misfit
    from planarc.structure.report import StructurallySingular

    reason = None
    if isinstance(problem, StructurallySingular):
        reason = explain_misfit(dae, mechanism, problem.undetermined, problem.givers)
    first = problem.diagnostics[0]
    if reason is None and mechanism is not None and isinstance(first, HeldAgainst):
        reason = _without_load(dae, mechanism, first)
    return (reason,) if reason else _held_too_often(dae, mechanism, problem.diagnostics)


def _without_load(dae: Dae, mechanism: Mechanism, held: Diagnostic) -> Diagnostic | None:
    """The error about a start value against the equations, where these are those of a drive that
    has nothing to accelerate."""
    from planarc.insight.massless import idle_drives

    idle = next((d for d in idle_drives(dae, mechanism) if d.span == held.span), None)
    if idle is None:
        return None
    notes = (Related(held.message, held.span),)
    return replace(idle, code=held.code, severity=held.severity, related=notes)


def find_held(model: SortedDae, mechanism: Mechanism | None) -> Diagnostic | None:
    """The warning about parts that are held where they are, or may be for that a bar is connected
    by one end; None where a count of joints says so."""
    from planarc.insight import locked

    doubled = None if mechanism is None else locked.find_doubled(model.dae, mechanism)
    if doubled is not None or (mechanism is not None and mechanism.locked is not None):
        return doubled
    if mechanism is None:
        return locked.find_held(model)
    rigid = locked.find_rigid_loop(model.dae, mechanism)
    return rigid or locked.find_held_angle(model.dae, mechanism) or locked.find_held(model)


def attachment_warnings(
    dae: Dae, mechanism: Mechanism | None, held: Diagnostic | None = None
) -> tuple[Diagnostic, ...]:
    """What a user may not have meant: parts that float, that change nothing, and that are held."""
    from planarc.insight.suspicions import find_suspicions

    return find_suspicions(dae, mechanism, held)


def _held_too_often(
    dae: Dae, mechanism: Mechanism | None, found: Sequence[Diagnostic]
) -> tuple[Diagnostic, ...]:
    """Messages of equations that do not fit, with the count of joints where these are too many;
    where it is those of one loop, this alone is said."""
    if mechanism is None:
        return tuple(found)
    from planarc.insight.askew import find_askew
    from planarc.insight.misfit import (
        borne_twice,
        held_beside,
        held_twice,
        overdriven,
        overheld,
        rigid_ring,
    )
    from planarc.structure.report import Held, Overdone, Repeated

    first = found[0]
    ring = rigid_ring(dae, mechanism) if isinstance(first, Overdone | Held) else None
    if ring is not None:
        return (Diagnostic(first.code, *ring[:2], hint=ring[2]),)
    skew = find_askew(dae, mechanism) if isinstance(first, Overdone | Held | Repeated) else None
    if skew is not None:
        return (Diagnostic(first.code, *skew[:2], hint=skew[2]),)
    borne = borne_twice(dae, mechanism) if isinstance(first, Overdone | Held | Repeated) else None
    if borne is not None:
        return (Diagnostic(first.code, *borne[:2], hint=borne[2], mend=Accept()),)
    twice = held_twice(dae, mechanism, first.holders) if isinstance(first, Repeated) else None
    if twice is not None:
        found = (replace(first, message=twice[0], span=twice[1], hint=twice[2]), *found[1:])
    if mechanism.mobility == 0 and mechanism.locked is not None and isinstance(first, Overdone):
        # What is driven besides cannot be.
        locked = mechanism.locked
        others = (Related(first.message), *first.related)
        told = (*locked.related, *(replace(r, detail=True) for r in others))
        driven = f"{locked.message}{', so that nothing can be driven' if dae.drives else ''}"
        return (replace(first, message=driven, hint=locked.hint, related=told), *found[1:])
    if mechanism.mobility >= 0:
        holders = first.holders if isinstance(first, Overdone) else ()
        drives = overdriven(dae, mechanism, holders)
        return (Diagnostic(first.code, *drives[:2], hint=drives[2]),) if drives else tuple(found)
    from planarc.insight.facts import count_text

    beside = held_beside(dae, mechanism, first.span) if isinstance(first, Held) else None
    if beside is not None:
        found = (replace(first, message=beside[0], span=beside[1], hint=beside[2]), *found[1:])
    loop = None if twice or beside else overheld(dae, mechanism)
    known = f"{found[0].hint};" if twice or beside or (isinstance(first, Held) and not loop) else ""
    if loop is not None:
        found = (Diagnostic(found[0].code, *loop[:2]),)
        known = loop[2] or known
    hint = f"{known or _TOO_MANY} "
    hint += f"those that fit are accepted with {ACCEPTING}"
    told = (*found[0].related, Related(count_text(mechanism)))
    return (replace(found[0], hint=hint, related=told, mend=Accept()), *found[1:])


def to_program(model: SortedDae, clock: Clock | None = None) -> Program:
    """The statements of a sorted model over a workspace, the same for both back ends."""
    from planarc.codegen.pipeline import generate

    with (clock or Clock()).phase("codegen"):
        return generate(model)


def to_code(program: Program, backend: Backend, clock: Clock | None = None) -> str | bytes:
    """NumPy source, or a native object file."""
    with (clock or Clock()).phase("codegen"):
        try:
            if backend is Backend.NUMPY:
                from planarc.codegen.numpy.printer import kernel_source

                return kernel_source(program)
            from planarc.codegen.native.machine import compile_object

            if not program.switches:
                return compile_object(program)
            from planarc.instance.reaction import texts_of

            return compile_object(program, texts_of(program))
        except PlanarcError as problem:
            from planarc.codegen.refusal import located

            raise located(problem, program) from None


def to_slopes(program: Program, backend: Backend, scope: Scope) -> str | bytes | None:
    """The code of derivatives; None where the model calls a function that has none."""
    if backend is Backend.NATIVE:
        from planarc.codegen.native.machine import compile_slopes

        return compile_slopes(program, scope)
    from planarc.codegen.numpy.printer import slopes_source

    return slopes_source(program, scope)


def explain(result: Result, tolerance: float | None) -> Result:
    """A run's events in words of its components, and warnings where it lost energy, where parts of
    the user's own break the third law or miscount their energy, of absurd motions, and where
    nothing moves."""
    from planarc.insight.verdicts import judge

    program = result.program
    found = judge(result, tolerance or program.experiment.tolerance)
    if result.events and any(d.kind == "event" for d in program.declared):
        from planarc.insight.happenings import name_events

        result = replace(result, events=name_events(result))
    if any(isinstance(d, Runaway) for d in found):  # why the run took so many steps
        kept = (w for w in result.warnings if not isinstance(w, Laborious))
        result = replace(result, warnings=tuple(kept))
    return replace(result, warnings=(*result.warnings, *found)) if found else result


def study(result: Result, kernel: Kernel | None = None, peaks: bool = True) -> Insight:
    """What is known of a run's mechanism; of the ranks only with the run's kernel."""
    from planarc.insight.study import study as run_stage

    return run_stage(result, kernel, peaks)
