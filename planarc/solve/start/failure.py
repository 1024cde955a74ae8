"""Why a mechanism cannot start, in words: the loop, the worst equations, what to change.

The file is long because a start fails in several ways, and each message asks the same system again.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from operator import add
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related
from planarc.core.prose import listed
from planarc.core.unit import LOADS
from planarc.ir.dae import MISFIT
from planarc.ir.kernel import changed
from planarc.ir.places import declaration, is_own, own_names, own_part, owner, point_home
from planarc.ir.program import CandidateSlot, EquationInfo, FixedSlot
from planarc.solve.messages import trouble
from planarc.solve.messages.loops import (
    bearings_of_loop,
    given_in_loop,
    is_closed,
    lengths_in_loop,
    loop_names,
    too_far_apart,
)
from planarc.solve.messages.sides import other_side
from planarc.solve.messages.slides import beside_wheel, entries, one_way, square_on
from planarc.solve.start import newton
from planarc.solve.start.apart import squares_apart, unit_of, units_in
from planarc.solve.start.contradiction import (
    Contradiction,
    contradicting,
    contradiction,
    fixed_starts,
    initial_against_fixed,
)
from planarc.solve.start.held import Choice, places, weakness
from planarc.solve.start.lengths import longer_crank, much_shorter
from planarc.solve.start.redundancy import refuse_redundancy
from planarc.solve.start.refused import NotAssembled
from planarc.solve.start.singular import dead_centre
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.surplus import spare_ground, too_many_conditions
from planarc.solve.start.system import System, are_velocities
from planarc.solve.start.unevaluated import not_evaluated

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

_WORST = 3

#: Length (m) or angle (rad) below which Newton's method means zero.
_SMALL = 1e-6
#: Share of a free motion in the held values below which a position is called a dead centre.
DEAD_CENTRE = 2e-2


def explain(system: System, u0: Vector, choice: Choice) -> PlanarcError:
    """Find out which of the conditions cannot be met, and with which others."""
    import numpy as np

    if all(system(p) is None for p in places(u0)):
        return _of_loops(system, u0, choice) or not_evaluated(system, system.evaluate_flag(u0))
    nothing = np.zeros(len(u0), dtype=bool)
    for rows, columns in system.stages:
        free = _best(system, u0, rows, columns, nothing)
        root = _best(system, u0, rows, columns, np.array(choice.held)) if free.converged else free
        if not root.converged:
            over = contradiction(system, u0, rows, columns)
            if over is not None and (told := initial_against_fixed(system, u0, rows, columns)):
                return NotAssembled(told)
            still = over and dead_centre(system, u0, over, (rows, columns))
            if still:
                return NotAssembled(still)
            if not free.converged:
                return _not_assembled(system, free, rows, columns, u0, choice, over)
            moving = are_velocities(system.program, columns)
            if over is not None and (over.others or choice.redundant or moving):
                worst = _worst(system, rows, root.residuals)
                return NotAssembled(contradicting(system, over, columns, [i for _, i in worst]))
            return _not_reachable(system, u0, free, root, rows, columns, choice)
        u0 = root.point
    return _not_assembled(system, free, rows, columns, u0, choice, None)


def _of_loops(system: System, u0: Vector, choice: Choice) -> PlanarcError | None:
    """What is wrong with the loops, where forces and accelerations have no value at the guess."""
    if system.program.mechanism is None or system.program.initial_residuals:
        return None
    loops = system.of_loops()
    rows, columns = next(iter(loops.stages), ([], []))
    root = solve_stage(loops, u0, rows, columns) if rows else None
    if root is None or loops(root.point) is None:
        return None
    if not root.converged:
        return _not_assembled(loops, root, rows, columns, u0, choice, None)
    try:
        refuse_redundancy(loops, root.point)
    except PlanarcError as problem:
        return problem
    return None


def _best(
    system: System, u: Vector, rows: Sequence[int], columns: Sequence[int], held: Vector
) -> newton.Root:
    return solve_stage(system, u, rows, [c for c in columns if not held[c]])


def row_info(system: System, row: int) -> EquationInfo | None:
    program = system.program
    for i, block in system.blocks:
        if row in system.block_rows[i]:
            return program.equations[block.equations[row - system.block_rows[i].start]]
    if row in system.initial_rows:
        k = row - system.initial_rows.start
        return program.initial_equations[k] if k < len(program.initial_equations) else None
    fixed = system.conditions[row - system.fixed_rows.start]
    for condition in program.sharing.conditions if program.sharing else ():
        if condition.held is not None and condition.held.slot == fixed.slot:
            return condition.info
    note = ", fixed = true" if fixed.fixed else ""
    return EquationInfo(f"{fixed.display} = start{note}", fixed.span, owner(fixed.display))


def _worst(system: System, rows: Sequence[int], r: Vector) -> list[tuple[float, EquationInfo]]:
    """The equations that are farthest from being met, and by how much in SI units."""
    order = sorted(range(len(r)), key=lambda k: -abs(r[k]))[:_WORST] if len(r) == len(rows) else []
    far = [k for k in order if abs(r[k]) > 1e-3 * abs(r[order[0]])]
    found = [(float(r[k] * system.parts[rows[k]]), row_info(system, rows[k])) for k in far]
    return [(v, i) for v, i in found if i is not None]


def _off(system: System, residual: float) -> str:
    """A residual to two digits: the next ones depend on the machine."""
    small = _SMALL * min(system.length, 1.0)
    return f"less than {small:g}" if abs(residual) < small else f"{float(f'{residual:.2g}'):g}"


def _start(system: System, value: float) -> str:
    """A start value to try; what Newton's method leaves of a zero is zero."""
    return "0" if abs(value) < _SMALL * min(system.length, 1.0) else f"{value:.3g}"


def _loop(system: System, rows: Sequence[int], columns: Sequence[int], r: Vector) -> str:
    """The loop of the blocks that hold the worst equations, in words."""
    return loop_names(system.program, _parts(system, rows, columns, r))


def _parts(system: System, rows: Sequence[int], columns: Sequence[int], r: Vector) -> Sequence[str]:
    """The components of the blocks that hold the worst equations."""
    program = system.program
    worst = {rows[k] for k in range(len(r)) if abs(r[k]) >= 0.5 * max(abs(r))} if len(r) else set()
    names: dict[str, None] = {}
    for i, block in system.blocks:
        if block.first in columns and worst & set(system.block_rows[i]):
            for c in program.candidates[block.first : block.first + len(block.tears)]:
                names[owner(c.display)] = None
            names |= dict.fromkeys(program.equations[e].component for e in block.equations)
    names.pop("", None)
    return list(names)


def _not_assembled(
    system: System,
    root: newton.Root,
    rows: Sequence[int],
    columns: Sequence[int],
    u0: Vector,
    choice: Choice,
    contradicted: Contradiction | None,
) -> PlanarcError:
    worst = _worst(system, rows, root.residuals)
    loop = _loop(system, rows, columns, root.residuals)
    texts = [i.text for row in system.initial_rows if (i := row_info(system, row)) is not None]
    over = None if loop else too_many_conditions(system, texts)
    held = _held_against(system, root, rows, columns)
    if held is not None and not loop and over is None:
        return held
    if over is None and contradicted is not None and contradicted.others:
        return NotAssembled(contradicting(system, contradicted, columns))
    parts = _parts(system, rows, columns, root.residuals)
    is_loop = is_closed(system.program, parts)
    starts = fixed_starts(system, rows) if is_loop else {}
    if starts:
        bare = [row for row in rows if row not in starts.values()]
        free = solve_stage(system, u0, bare, columns)
        if free.converged:
            return _not_reachable(system, u0, free, root, rows, columns, choice)
    given = given_in_loop(system.program, system.kernel, parts) if is_loop else ""
    turned = f" with {given}" if given else ""
    twice = system.program.mechanism is not None and not is_loop
    far, longest = _too_far(system, root, rows, parts, worst) if is_loop and not given else ("", "")
    there = system.program, system.kernel, parts
    one = (one_way(*there) or beside_wheel(*there)) if is_loop else ""
    turn = _turned(system, u0, rows, columns, parts) if is_loop and not (far or one) else ""
    what = (
        f"the equations of {loop} cannot be met" if loop else "the start conditions cannot be met"
    )
    if over is not None:
        return _at_home(system, root, over, worst)
    if loop and worst and not units_in(system.program, worst[0][1]).isdisjoint(LOADS):
        info = worst[0][1]
        found = Diagnostic(
            "R412",
            f"the loads on {loop} do not balance, and nothing that has a mass takes them up",
            info.span,
            hint="hold what they push away, as by a support that does not roll, or give one of "
            "these parts a mass",
            related=_related(system, worst),
        )
        return NotAssembled(point_home(system.program, found, info.component))
    return _at_home(
        system,
        root,
        Diagnostic(
            "R412",
            f"the loop of {loop} cannot be assembled{turned}" if is_loop else what,
            part.span if (part := own_part(system.program, longest)) else None,
            hint=(
                f"change a length: {far}"
                if far
                else one
                or f"check {'what is given, and ' if given else ''}lengths"
                f"{'' if given else _and_places(system, parts)}"
                f"{turn or ': the parts do not reach each other'}"
                if is_loop
                else "leave out what holds the same motion twice, such as a second gear"
                if twice
                else "change a parameter, or start nearer to a solution"
            )
            + (spare_ground(system.program) if is_loop else ""),
        ),
        worst,
    )


def _and_places(system: System, parts: Sequence[str]) -> str:
    """The parts on the ground whose places a loop depends on, as a text to add."""
    names = bearings_of_loop(system.program, system.kernel, parts)
    if not names:
        return ""
    return f", and the {'places' if len(names) > 1 else 'place'} of {trouble.names(names)}"


def _turned(
    system: System,
    u0: Vector,
    rows: Sequence[int],
    columns: Sequence[int],
    parts: Sequence[str],
) -> str:
    """The direction of a slide with which the loop closes, as a text to add."""
    program, kernel = system.program, system.kernel
    if program.mechanism is not None and program.mechanism.locked is not None:
        return ""
    for slide, direction in square_on(program, kernel, parts):
        with changed(kernel, direction):
            closes = solve_stage(system, u0, rows, columns).converged
        if closes:
            n = entries(*direction.values())
            return f", and the direction of `{slide}`: with `n={n}` the loop closes"
    return ""


def _too_far(
    system: System,
    root: newton.Root,
    rows: Sequence[int],
    parts: Sequence[str],
    worst: Sequence[tuple[float, EquationInfo]],
) -> tuple[str, str]:
    """The lengths of a loop that is too short or too long by what it stays open, and its longest
    part."""
    if not worst or system(root.point) is None:
        return "", ""
    open_at = own_names(system.program, [worst[0][1].component])[0]
    gap = root.residuals * system.parts[list(rows)]
    return too_far_apart(system.program, system.kernel, parts, open_at, gap.tolist())


def _held_against(
    system: System, root: newton.Root, rows: Sequence[int], columns: Sequence[int]
) -> NotAssembled | None:
    """The message where the worst of all is a fixed start value of what others decide."""
    r, first = root.residuals, system.fixed_rows.start
    k = max(range(len(r)), key=lambda k: abs(r[k])) if len(r) == len(rows) else -1
    if k < 0 or rows[k] < first:
        return None
    fixed = system.conditions[rows[k] - first]
    if not fixed.fixed or fixed.display.startswith(MISFIT):
        return None
    program, name, whole = system.program, fixed.start_name, [rows[k]]
    vector = _vector(name)
    elements = [
        row
        for row, f in zip(system.fixed_rows, system.conditions, strict=True)
        if _vector(f.start_name) == vector and f.fixed and row in rows
    ]
    if vector and len(elements) > 1:  # they are one mistake
        name, whole = vector, elements
    own = own_names(program, [owner(name)])
    giver = trouble.determining(program, system.kernel, fixed.slot)
    names = [] if giver is None else own_names(program, [giver.component])
    by = f"`{names[0]}`, which decides it" if names and names[0] else "what decides it"
    if names in ([], own) or fixed.holder:  # its own law, from others
        others: list[CandidateSlot | FixedSlot] = [
            c for i, c in enumerate(program.candidates) if i in columns and c.fixed
        ]
        others += [c for row, c in enumerate(system.conditions, first) if row not in whole]
        told = [o.start_name for o in others if o.fixed and not o.display.startswith(MISFIT)]
        by = f"what follows from the fixed start of {trouble.names(told)}" if told else by
    starts = [float(system.kernel.w[system.conditions[row - first].start]) for row in whole]
    misses = _misses(system, root, rows, columns, whole)
    follows = [start + miss for start, miss in zip(starts, misses, strict=True)]
    found = Diagnostic(
        "R411",
        f"the fixed start value {_values(starts)} of `{name}` contradicts {by}",
        declaration(program, fixed.start_name, fixed.span),
        hint=f"remove `fixed = true` from `{name}`, which follows as {_values(follows)} from the "
        "others",
    )
    return NotAssembled(found)


def _misses(
    system: System,
    root: newton.Root,
    rows: Sequence[int],
    columns: Sequence[int],
    left_out: Sequence[int],
) -> list[float]:
    """How far conditions are, in SI units, from being met where all others of a stage are."""
    import numpy as np

    held = np.array([c.fixed for c in system.program.candidates])
    start = np.array([system.kernel.w[c.start] for c in system.program.candidates]) / system.units
    others = [row for row in rows if row not in left_out]
    met = _best(system, np.where(held, start, root.point), others, columns, held)
    values = system(met.point) if met.converged else None
    if values is None:
        return [float(root.residuals[rows.index(row)] * system.parts[row]) for row in left_out]
    return [float(values[row] * system.parts[row]) for row in left_out]


def _vector(name: str) -> str:
    """The vector of which a name is an element; empty where it is of none."""
    return name.rpartition("[")[0]


def _values(values: Sequence[float]) -> str:
    shown = [f"{v:.6g}" for v in values]
    return shown[0] if len(shown) == 1 else f"{{{', '.join(shown)}}}"


def _at_home(
    system: System,
    root: newton.Root,
    found: Diagnostic,
    worst: Sequence[tuple[float, EquationInfo]],
) -> NotAssembled:
    """The message at the part whose equation is farthest from being met."""
    program = system.program
    span = worst[0][1].span if worst and found.span is None else found.span
    message = found.message
    if worst and not is_own(program, worst[0][1].span):
        closed = "cannot be assembled" in message
        off = _off(system, _distance(worst))
        if closed:
            system(root.point)  # the workspace is there now
            length = squares_apart(program, system.kernel, worst[0][1])
            unit = f" {unit_of(program, worst[0][1])}".rstrip()
            apart = f"{off}{unit}" if length is None else f"{_off(system, length)} m"
            message += f": its ends stay {apart} apart"
        else:
            message += f": at best it is off by {off}"
    related = (*found.related, *_related(system, worst))
    told = replace(found, message=message, span=span, related=related)
    return NotAssembled(point_home(program, told, worst[0][1].component if worst else ""))


def _related(system: System, worst: Sequence[tuple[float, EquationInfo]]) -> tuple[Related, ...]:
    return tuple(Related(f"`{i.text}` is off by {_off(system, v)}", i.span) for v, i in worst)


def _distance(worst: Sequence[tuple[float, EquationInfo]]) -> float:
    """How far the worst equation is off, with the others of its vector."""
    (value, info), *others = worst
    beside = (v for v, i in others if i.span == info.span and i.component == info.component)
    return hypot(value, *beside)


def _not_reachable(
    system: System,
    u0: Vector,
    free: newton.Root,
    root: newton.Root,
    rows: Sequence[int],
    columns: Sequence[int],
    choice: Choice,
) -> PlanarcError:
    """It assembles, but not with the start values that are to be held."""
    program = system.program
    held = [c for c in columns if choice.held[c]]
    worst = _worst(system, rows, root.residuals)
    starts = fixed_starts(system, rows)
    kept: list[CandidateSlot | FixedSlot] = [*(program.candidates[c] for c in held), *starts]
    loop = _loop(system, rows, columns, root.residuals)
    if not loop and kept:
        loop = loop_names(program, [owner(kept[0].display)])
    loop = loop or "the mechanism"
    wanted = [float(system.kernel.w[f.start]) for f in starts]
    away = system(free.point)
    own = [*starts.values()]
    misses = wanted if away is None else (away[own] * system.parts[own]).tolist()
    names = [start.start_name for start in kept]
    values = [*(u0 * system.units)[held].tolist(), *wanted]
    reached = [*(free.point * system.units)[held].tolist(), *map(add, wanted, misses)]
    given = listed(f"`{n}` = {v:.4g}" for n, v in zip(names, values, strict=True))
    starts_at = [_start(system, v) for v in reached]
    nearest = listed(f"`{n}(start = {s})`" for n, s in zip(names, starts_at, strict=True))
    moving = are_velocities(program, columns)
    near = None if moving else weakness(system, free.point, (rows, columns), held)
    length = "a length" if program.mechanism is not None else "a parameter"
    related: tuple[Related, ...] = ()
    exchanged = ""
    if not moving and len(kept) == 1:
        around = [owner(kept[0].display)]
        length += other_side(program, system.kernel, around, values[0], reached[0])
        parts = _parts(system, rows, columns, root.residuals)
        lengths = lengths_in_loop(program, system.kernel, parts)
        gap = _distance(worst) if worst else 0.0
        related = much_shorter(program, lengths, around[0], gap)
        exchanged = longer_crank(program, parts, lengths, around[0])
        length += _and_places(system, parts).replace(", and", ", or")
    return _at_home(
        system,
        root,
        Diagnostic(
            "R412",
            f"the loop of {loop} cannot {'move' if moving else 'be assembled'} with {given}"
            if kept
            else f"the loop of {loop} cannot be assembled from its start values",
            declaration(program, names[0], kept[0].span) if kept else None,
            hint=f"{exchanged}choose a start well inside its reach: {nearest} is a dead centre; or "
            f"give start values of another joint, or change {length}"
            if near is not None and near.share < DEAD_CENTRE
            else f"{exchanged}start with {nearest}, {'as' if moving else 'where'} it "
            f"{'can' if moving else 'assembles'}, or change {length}"
            if kept
            else "change the start values towards an assembled position",
            related=related,
        ),
        worst,
    )
