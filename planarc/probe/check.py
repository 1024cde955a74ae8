"""A model checked without a run: all stages up to `structure`, and what its mechanism can do.

In:   Request
Out:  Checked, or what an earlier check remembered of it

Where there are loops, their conditions may depend on each other: the mechanism is put together at
its start, on NumPy's back end, which is there at once. The rank of the loops' conditions tells how
many of them are independent; each that is not gives back a degree of freedom that the count takes.

Example: a parallelogram with a third bar parallel to the others. By count 4*3 - 6*2 = 0; the rank
of its four conditions is three, so that it moves with one degree of freedom.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc import stages
from planarc.core.clock import Clock
from planarc.core.data import Data, without_collection
from planarc.core.diagnostic import Bound, Diagnostic, Locked, PlanarcError, Severity, in_one
from planarc.core.options import Backend
from planarc.core.prose import counted
from planarc.ir.mechanism import Mobility
from planarc.probe.doubts import find_doubts
from planarc.probe.open import open_program
from planarc.remembered import Checked, recall_check, remember_check
from planarc.request.request import Request, Target, open_target

if TYPE_CHECKING:
    from planarc.ir.dae import Dae
    from planarc.ir.flat import FlatModel
    from planarc.ir.mechanism import Mechanism
    from planarc.ir.sorted import SortedDae


def check_model(request: Request, clock: Clock | None = None, start: bool = False) -> Checked:
    """All stages up to `structure`. A start that cannot be found is an error with `start`, else a
    warning where more is fixed than is free, or where loops are put together anyway."""
    clock = clock or Clock()
    with clock.phase("recall"):
        known = recall_check(request)
    if known is not None and not (start and not known.started):
        return known
    with without_collection():
        target = open_target(request)
        checked = judge(look_at(target, clock), clock, start)
    remember_check(request, target, checked)
    return checked


class Seen(Data):
    """What the stages made of a model, and what they told; nothing is put together yet."""

    checked: Checked
    flat: FlatModel
    dae: Dae
    model: SortedDae
    wrong: tuple[Diagnostic, ...] = ()  # values that end any run
    held: Diagnostic | None = None  # what is told of parts that cannot move


def look_at(target: Target, clock: Clock) -> Seen:
    """A class whose libraries are open, taken up to `structure`."""
    flat = stages.flatten(target, clock)
    dae = stages.to_dae(flat, clock)
    model = stages.to_sorted(dae, clock)
    sizes = model.equations_before, model.equations_after, model.state_count
    mechanism = stages.find_mechanism(dae)
    held = stages.find_held(model, mechanism)
    doubts = tuple(find_doubts(flat, dae))
    likely = (d for d in doubts if d.severity is Severity.WARNING)
    warnings = (*dae.warnings, *likely, *stages.attachment_warnings(dae, mechanism, held))
    checked = Checked(flat.name, *sizes, in_one(warnings), mechanism)
    wrong = tuple(d for d in doubts if d.severity is Severity.ERROR)
    return Seen(checked, flat, dae, model, wrong, held)


def judge(seen: Seen, clock: Clock, start: bool = False) -> Checked:
    """What `check_model` tells: also whether loops can be closed, and how they may move."""
    checked, mechanism = seen.checked, seen.checked.mechanism
    if seen.wrong:
        raise PlanarcError(seen.wrong).after(checked.warnings)
    loops = mechanism is not None and mechanism.loops > 0
    if not (start or loops or _fixes_too_much(seen.model)):
        return checked
    found, warnings = None, checked.warnings
    try:
        found = _put_together(seen, clock)
    except PlanarcError as problem:
        if start:
            raise
        # A bar with both its ends in one place is why its loop does not close.
        doubled = any(isinstance(w, Locked) and w.code == "S323" for w in warnings)
        reasons = {w.span for w in warnings if w.code == "S323"}
        found_there = () if doubled else (d for d in problem.diagnostics if d.span not in reasons)
        told = tuple(_warning(d) for d in found_there if _tells(d))
        said = {(d.message, d.span) for d in told}  # as the reason why it cannot start
        warnings = tuple(w for w in warnings if (w.message, w.span) not in said)
        warnings = in_one((*warnings, *told))
        if told:  # by that they cannot move, too
            return replace(checked, warnings=warnings)
    if found is not None and found.redundant is not None:  # what follows from others holds nothing
        warnings = tuple(w for w in warnings if not isinstance(w, Bound))
    # What cannot be assembled cannot move either.
    locked = None if mechanism is None else mechanism.locked
    if locked is not None and (found is None or found.rank <= 0):
        warnings = (*warnings, locked)
    return replace(checked, mobility=found, warnings=warnings, started=start)


def _fixes_too_much(model: SortedDae) -> bool:
    """Whether more start values are fixed than states are free: some follow from others, or
    contradict them."""
    fixed = sum(c.fixed for c in model.candidates) + sum(f.fixed for f in model.fixed)
    return fixed + len(model.initial_residuals) > model.state_count


def _tells(problem: Diagnostic) -> bool:
    return problem.code in ("R410", "R411", "R412", "R415")


def _warning(problem: Diagnostic) -> Diagnostic:
    return replace(problem, severity=Severity.WARNING)


def summary_of(checked: Checked) -> Iterator[str]:
    """What a check says of a model that is right, in a line or two."""
    equations = counted(checked.equations_before, "equation")
    yield (
        f"{checked.name} is complete: {equations} for as many unknowns, "
        f"{checked.equations_after} after reduction, {counted(checked.states, 'state')}"
    )
    if checked.mechanism is not None and checked.mechanism.bodies:
        yield _told(checked.mechanism, checked.mobility)


def _told(mechanism: Mechanism, mobility: Mobility | None) -> str:
    from planarc.insight.facts import count_text

    text = count_text(mechanism)
    if mobility is None:
        return text
    told = "all conditions are independent"
    if mobility.dependent:
        verb = "condition follows" if mobility.dependent == 1 else "conditions follow"
        told = f"{mobility.dependent} {verb} from the others"
        if mobility.redundant is not None:
            told += ", in every position: `--redundant accept` shares the forces"
    return f"{text}, {mobility.rank} by rank at the start ({told})"


def _put_together(seen: Seen, clock: Clock) -> Mobility | None:
    """The model at its start, as a run does it, and how its mechanism may move there. Raises
    PlanarcError where there is no start."""
    from planarc.insight.rank import deficiency
    from planarc.solve.start.redundancy import Redundant

    mechanism = seen.checked.mechanism
    program = stages.to_program(seen.model, clock)
    program = replace(program, mechanism=mechanism, locked=seen.held)
    code = stages.to_code(program, Backend.NUMPY, clock)
    with clock.phase("start"):
        opened, redundant = open_program(program, str(code)), None
        try:
            opened.start()
        except Redundant as problem:
            redundant = problem.diagnostics[0]
            if mechanism is not None:
                redundant = mechanism.with_copied(redundant)
            redundant = replace(redundant, severity=Severity.WARNING)
        except PlanarcError as problem:
            from planarc.solve.simulate import with_reason

            raise with_reason(problem, program) from None
        if mechanism is None:
            return None
        return Mobility(mechanism.mobility, deficiency(program, opened.kernel), redundant)
