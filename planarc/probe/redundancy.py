"""Redundant joints accepted: a program in which they are held once, and share their forces.

In:   Dae, Mechanism
Out:  Program; its `sharing` tells what was left out, None where nothing is redundant

    surplus     equations that find no unknown are left out, by structure
    share       the forces that are open then get equations (`structure.sharing`)
    assemble    at the start, with all conditions met, those left out among them
    depend      rows that follow from others wherever it can be (`solve.start.dependence`)

Where other rows are dependent than those left out, these are left out instead, and the program is
made once more. By how much each of them is missed stays a variable: a joint that does not fit is
told, and a loop closes on the side on which the redundant joint fits, too.

The forces that share are those at the frames of joints. Rigid parts that close a loop without a
joint leave forces open that no joint knows of: then those at all frames of the model share.

Example: of a parallelogram with a third bar one condition of four is left out; one force is open.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from planarc.codegen.pipeline import equation_info
from planarc.core.arrays import Vector
from planarc.core.clock import Clock
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, Severity
from planarc.core.source import NOWHERE
from planarc.insight.askew import find_askew
from planarc.insight.attachment import changes
from planarc.insight.connectors import find_frames
from planarc.ir.dae import MISFIT, Dae, Equation, Variable
from planarc.ir.flat import StateSelect
from planarc.ir.mechanism import Mechanism
from planarc.ir.places import own_part, point_home
from planarc.ir.program import Condition, EquationInfo, Program, Sharing
from planarc.ir.sorted import Fixed, SortedDae
from planarc.probe.open import Opened, open_program
from planarc.solve.messages import trouble
from planarc.solve.start.dependence import dependent_rows, least_misfit
from planarc.solve.start.failure import row_info
from planarc.solve.start.refused import NotAssembled
from planarc.solve.start.sharing import left_out_rows, strict
from planarc.solve.start.system import System
from planarc.solve.start.unevaluated import NotEvaluated
from planarc.stages import to_program, to_sorted
from planarc.structure.pipeline import structure
from planarc.structure.report import StructurallySingular
from planarc.structure.sharing import share_forces, surplus_equations

#: Rounds of looking for what is left out.
_ROUNDS = 3


def accept_redundancy(
    dae: Dae, mechanism: Mechanism, clock: Clock
) -> tuple[Program, tuple[Diagnostic, ...]]:
    """The program, and a note where nothing is redundant.

    Raises PlanarcError: what `structure` tells where equations are missing that no joint explains,
    R417 where redundant joints do not fit, S316 where forces are open that cannot be shared.
    """
    with clock.phase("redundancy"):
        made = _find(dae, mechanism, clock)
    if made.program.sharing is not None:
        return made.program, tuple(_still(dae, mechanism, made))
    return made.program, (_nothing(made),)


def _still(dae: Dae, mechanism: Mechanism, made: _Made) -> Iterator[Diagnostic]:
    """The warning that no motion is left, and nothing in the model changes with time."""
    sharing = made.program.sharing
    if made.program.state_count or dae.inputs or changes(dae):
        return
    held = [c.info.component for c in sharing.conditions] if sharing else []
    last = own_part(dae, [*held, *(j.name for j in mechanism.joints), ""][0])
    span = dae.span if last is None else last.span
    told = find_askew(dae, mechanism)
    message, where, hint = told or (
        "no motion is left with the joints that are accepted",
        span,
        _MEANT,
    )
    yield Diagnostic("S322", f"nothing moves: {message}", where, Severity.WARNING, hint=hint)


_MEANT = "a structure is meant, or a joint is missing"


class _Made(Data):
    """A program, and where its equations come from."""

    program: Program
    model: SortedDae
    kept: tuple[int, ...]  # numbers of its equations in the model as it is
    left_out: tuple[int, ...]


def _find(dae: Dae, mechanism: Mechanism, clock: Clock) -> _Made:
    frames = {frame for link in mechanism.links for frame in link.frames}
    components = {frame.rpartition(".")[0] for frame in frames}
    forces = frozenset(_cut_forces(dae, mechanism, everywhere=True))
    left_out = surplus_equations(dae, components, forces)
    made = _make(dae, mechanism, left_out, clock)
    for _ in range(_ROUNDS):
        found = _dependent(made)
        if found == left_out:
            break
        left_out = found
        made = _make(dae, mechanism, left_out, clock)
    if made.program.sharing is not None and not _can_be_solved(made.program):
        made = _make(dae, mechanism, left_out, clock, everywhere=True)
    return made


def _make(
    dae: Dae,
    mechanism: Mechanism,
    left_out: Sequence[int],
    clock: Clock,
    everywhere: bool = False,
) -> _Made:
    kept = tuple(i for i in range(len(dae.equations)) if i not in left_out)
    misfits = [_misfit_of(dae, k, i) for k, i in enumerate(left_out, 1)]
    without = replace(
        dae,
        variables=(*dae.variables, *(v for v, _ in misfits)),
        equations=(*(dae.equations[i] for i in kept), *(e for _, e in misfits)),
    )
    shared = share_forces(without, _cut_forces(dae, mechanism, everywhere))
    try:
        model = to_sorted(shared.dae, clock)
    except StructurallySingular:
        if not everywhere:
            return _make(dae, mechanism, left_out, clock, everywhere=True)
        structure(dae)  # what it tells of the model as it is
        raise
    model, names = _held_misfits(model, [v.name for v, _ in misfits])
    program = replace(
        to_program(model, clock), mechanism=mechanism, equations_before=len(dae.equations)
    )
    if shared.open:
        held = dict(zip(names, program.fixed[len(program.fixed) - len(names) :], strict=True))
        conditions = tuple(
            Condition(v.name, held.get(v.name), equation_info(dae.equations[i]))
            for (v, _), i in zip(misfits, left_out, strict=True)
        )
        program = replace(
            program,
            fixed=program.fixed[: len(program.fixed) - len(names)],
            sharing=Sharing(shared.open, conditions, everywhere),
        )
    return _Made(program, model, kept, tuple(left_out))


def _misfit_of(dae: Dae, number: int, equation: int) -> tuple[Variable, Equation]:
    """The variable that tells by how much an equation is missed that is left out."""
    source, name = dae.equations[equation], f"{MISFIT}[{number}]"
    residual = dae.table.sub(source.left, source.right)
    told = Variable(
        name,
        state_select=StateSelect.NEVER,
        protected=True,
        component=source.component,
        span=source.span,
    )
    return told, replace(source, left=dae.table.symbol(name), right=residual, generated=False)


def _held_misfits(model: SortedDae, names: Sequence[str]) -> tuple[SortedDae, list[str]]:
    """The model with those misfits among its start conditions that move, and their names."""
    targets = {a.name: a.target for a in model.aliases}
    unknowns = {v.name for v in model.dae.variables}
    # They follow from positions; what there is above them is there for few.
    height = min(2, max((level.height for level in model.levels), default=0))
    moving, added = [], []
    for name in names:
        symbol = targets.get(name, model.dae.table.symbol(name))
        if symbol.is_symbol and symbol.name in unknowns:
            moving.append(name)
            zero = model.dae.table.zero
            added.append(Fixed(symbol, zero, name, NOWHERE, False, False, height=height))
    return replace(model, fixed=(*model.fixed, *added)), moving


def _cut_forces(dae: Dae, mechanism: Mechanism, everywhere: bool) -> list[str]:
    """The cut forces at all frames of joints, or of the model."""
    frames: Iterable[str] = dict.fromkeys(f for joint in mechanism.joints for f in joint.frames)
    if everywhere:
        frames = find_frames(v.name for v in dae.variables)
    return [f"{frame}.{name}" for frame in frames for name in ("f[1]", "f[2]", "t")]


# Numbers at the start


def _dependent(made: _Made) -> tuple[int, ...]:
    """The equations of the model that are to be left out."""
    program = made.program
    conditions = program.sharing.conditions if program.sharing else ()
    numbered = list(zip(conditions, made.left_out, strict=True))
    held = [i for c, i in numbered if c.held is not None]
    found = [i for c, i in numbered if c.held is None]

    def judge(system: System, values: Vector) -> None:
        others = dict(zip(left_out_rows(system), held, strict=True))
        for row in dependent_rows(system, values, tuple(others)):
            found.append(others[row] if row in others else _equation(made, system, row))

    try:
        _open_strictly(program).start(judge)
    except NotAssembled as problem:
        raise _does_not_fit(problem, made) from None
    return tuple(sorted(found))


def _equation(made: _Made, system: System, row: int) -> int:
    """The number in the model of the equation behind a row of a block."""
    equations = made.model.equations
    for i, block in system.blocks:
        if row in system.block_rows[i]:
            number = block.equations[row - system.block_rows[i].start]
            while (before := equations[number].derived_from) is not None:
                number = before
            return made.kept[number]
    raise AssertionError(f"row {row} belongs to no equation")


def _can_be_solved(program: Program) -> bool:
    try:
        open_program(program).start(judge=lambda system, values: None)
    except NotEvaluated:
        return False
    except PlanarcError:  # told by the run
        pass
    return True


def _open_strictly(program: Program) -> Opened:
    """Held to what was left out as well, and without accelerations and forces."""
    opened = open_program(program)
    opened.kernel.forgive()
    return replace(opened, program=strict(program))


# What is told


def _misfit(made: _Made) -> tuple[str, EquationInfo] | None:
    """The one condition without which the mechanism can be assembled as its start values say:
    who does not fit, and by how much."""
    opened = _open_strictly(made.program)
    system = System(opened.program, opened.kernel, opened.t)
    guess = np.array([opened.kernel.w[c.start] for c in made.program.candidates])
    found = least_misfit(system, guess, left_out_rows(system))
    info = None if found is None else row_info(system, found.row)
    if found is None or info is None:
        return None
    names = _joints_at(made.program.mechanism, info.component)
    return (
        f"{trouble.names(names)} {'does' if len(names) == 1 else 'do'} not fit: with all other "
        f"conditions met near the start values, `{info.text}` is off by {found.off:.3g}",
        info,
    )


def _joints_at(mechanism: Mechanism | None, component: str) -> list[str]:
    """The joints of the link that a component belongs to; itself where it is a joint."""
    if mechanism is None or any(joint.name == component for joint in mechanism.joints):
        return [component]
    links = {
        i
        for i, link in enumerate(mechanism.links)
        if any(frame.rpartition(".")[0] == component for frame in link.frames)
    }
    found = [joint.name for joint in mechanism.joints if not links.isdisjoint(joint.links)]
    return found or [component]


def _does_not_fit(problem: PlanarcError, made: _Made) -> PlanarcError:
    """Conditions are left out by structure, but do not hold at the start."""
    misfit = _misfit(made)
    if misfit is None:
        return problem
    first, (message, info) = problem.diagnostics[0], misfit
    found = Diagnostic(
        "R417",
        message,
        info.span,
        hint="give the parts lengths with which they fit, or leave one out",
        related=(Related(first.message, first.span),),
    )
    return PlanarcError(point_home(made.program, found, info.component))


def _nothing(made: _Made) -> Diagnostic:
    """No joint is redundant. One that was meant to be so may not fit, where nothing moves."""
    message = "no joint is redundant: each holds something that no other one holds"
    misfit = None if made.program.state_count else _misfit(made)
    if misfit is None:
        return Diagnostic("R419", message, severity=Severity.NOTE)
    found = Diagnostic(
        "R419",
        f"{message}, and nothing can move; {misfit[0]}",
        misfit[1].span,
        Severity.WARNING,
        hint="a bar that shall repeat others must have the length with which it fits",
    )
    return point_home(made.program, found, misfit[1].component)
