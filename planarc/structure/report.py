"""Messages about a system that has no solution by its structure.

In:   the live equations, the kept variables and their matching
Out:  diagnostics S301 (an equation without unknowns), S302 (too many equations in a
      part), S303 (too few), each with names, texts, components and lines

Example: a frame's angle that nothing determines

    error S303: nothing determines `mass.frame_a.phi`: 1 unknown too many in this part

The file is long because equations fail to fit in many ways, and each has words of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from planarc.core.diagnostic import Diagnostic, PlanarcError, Related, Unconnected
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import both, counted, listed, shortened
from planarc.core.source import NOWHERE, Span
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Op, brief, postorder
from planarc.ir.flat import Part
from planarc.ir.places import is_own, own_names, own_part, owner, point_home
from planarc.structure.alias import Elimination, Live
from planarc.structure.blame import explain_misfit
from planarc.structure.fixed import fixed_by_its_end, fixed_together
from planarc.structure.graph import Rows
from planarc.structure.grounding import find_ungrounded
from planarc.structure.matching import Parts, find_singular_parts, match_equations
from planarc.structure.places import owner_span
from planarc.structure.unmatched import find_misfit, twins

_SHOWN = 8  # names listed in one message
_LONG = 150  # letters of a note, beyond which equations tell nobody anything
_LISTED = 3  # equations that no user wrote: they come last, and few say enough


class Repeated(Diagnostic):
    """A constraint repeats others, which leaves the forces of some components open."""

    holders: tuple[str, ...] = ()


class Held(Diagnostic):
    """What components hold is held already."""


class Overdone(Diagnostic):
    """More equations than unknowns decide these."""

    holders: tuple[str, ...] = ()  # the components whose equations they are


class StructurallySingular(PlanarcError):
    """Equations and unknowns cannot be matched (S301 to S303)."""

    undetermined: tuple[str, ...] = ()  # names of the unknowns that are left without an equation
    givers: tuple[Part, ...] = ()  # parts whose signals determine nothing, and what takes these


def explain_unfit(dae: Dae, elimination: Elimination, rows: Rows) -> StructurallySingular:
    """The error about equations and unknowns that cannot be matched."""
    if (problem := _explain_empty(dae, elimination, rows)) is not None:
        return problem
    matching = match_equations(rows, len(elimination.kept))
    parts = find_singular_parts(rows, len(elimination.kept), matching)
    problem = StructurallySingular(_explain(dae, elimination, parts))
    problem.undetermined = tuple(elimination.kept[v] for v in parts.under_variables)
    return problem


def _explain(dae: Dae, elimination: Elimination, parts: Parts) -> tuple[Diagnostic, ...]:
    over, under = explain_misfit(dae, find_misfit(dae))
    if parts.over_equations and not over:
        over = (_over(dae, elimination, parts.over_equations, parts.over_variables),)
        chosen = _equations(dae, elimination, parts.over_equations)
        # Of libraries' parts one too many leaves its forces open: that is one mistake.
        if not under and all(e.component for e in chosen):
            return over
    if parts.under_variables and not under:
        under = (_under(dae, elimination, parts.under_equations, parts.under_variables),)
    return (*over, *under)


def _explain_empty(dae: Dae, elimination: Elimination, rows: Rows) -> StructurallySingular | None:
    """The error about equations without unknowns."""
    wrong: list[Diagnostic] = []
    held: dict[str, tuple[Part, Related]] = {}  # of a part of a library one equation tells all
    givers: list[Part] = []
    for entry, row in zip(elimination.live, rows, strict=True):
        if row:
            continue
        equation = dae.equations[entry.index]
        own = equation.generated or is_own(dae, equation.span)
        part = None if own else own_part(dae, equation.component)
        left_over = f"`{brief(entry.left)} = {brief(entry.right)}`"
        nothing = f"{equation.shown} determines nothing: with the other equations it comes to "
        if part is None:
            found = _determines_nothing(equation, f"{nothing}{left_over}{_inside(equation)}")
            found = _between_parts(dae, entry, equation) or found
            at_open_end = _of_open_end(dae, equation, left_over)
            found = at_open_end or found
            givers += [] if at_open_end else _driven_from(dae, entry)
            wrong.append(point_home(dae, found, equation.component))
            continue
        reached = _driven_by(dae, part)
        givers += reached
        note = nothing + left_over
        if len(note) > _LONG:
            note = "this equation determines nothing: the others say it already, or contradict it"
        held.setdefault(reached[-1].name, (reached[-1], Related(note, _span(equation))))
    if not (wrong or held):
        return None
    problem = StructurallySingular([*wrong, *_held_already(dae, held)])
    problem.givers = tuple(givers)
    return problem


def _driven_from(dae: Dae, entry: Live) -> list[Part]:
    """The parts that drive by what an equation gives them: the user's own, or a part's by way of
    its signals."""
    giving = dae.drives
    symbols = [e for e in postorder((entry.left, entry.right)) if e.op is Op.SYMBOL]
    equation = dae.equations[entry.index]
    if equation.generated:
        parts = (own_part(dae, owner(e.name)) for e in symbols)
        reached = (_driven_by(dae, part)[-1] for part in parts if part is not None)
        return [part for part in reached if part.name in giving]
    written = (e for e in postorder((equation.left, equation.right)) if e.op is Op.SYMBOL)
    owners = dict.fromkeys(owner(e.name) for e in (*symbols, *written))
    return [p for o in owners if o in giving and (p := own_part(dae, o)) is not None]


def _of_open_end(dae: Dae, equation: Equation, left_over: str) -> Diagnostic | None:
    """The message about a connector that is connected to nothing, though its part needs it: what
    flows there would be zero."""
    end = owner(equation.left.name) if equation.generated and equation.left.is_symbol else ""
    part = own_part(dae, owner(end))
    if part is None or part.name != owner(end) or is_own(dae, equation.span):
        return None
    return Diagnostic(
        "S301",
        f"nothing is connected to `{end}`, which `{part.name}` needs: without it its equations "
        f"come to {left_over}",
        part.span,
        hint=f"connect `{end}`, or switch it off in `{part.name}`",
    )


def _between_parts(dae: Dae, entry: Live, equation: Equation) -> Diagnostic | None:
    """What parameters of two parts say at once, in words of these: two batteries side by side."""
    parameters = {p.name: p for p in dae.parameters}
    names = [e.name for e in postorder((entry.left, entry.right)) if e.op is Op.SYMBOL]
    if not names or any(n not in parameters for n in names):
        return None
    parts = own_names(dae, (owner(n) for n in names if owner(n)))
    if len(parts) < 2 or not equation.component:
        return None
    values = (parameters[n] for n in dict.fromkeys(names))
    shown = listed(f"`{p.name}` = {brief(p.value)}" for p in values if p.value.op is Op.CONST)
    last = own_part(dae, equation.component)
    said = f"{equation.shown} determines nothing (in `{equation.component}`)"
    return Diagnostic(
        "S301",
        f"{both(parts)} decide the same: together they ask that "
        f"`{brief(entry.left)} = {brief(entry.right)}`{f', with {shown}' if shown else ''}",
        last.span if last else _span(equation),
        hint="leave one of them out, or put between them what gives way, such as a resistance",
        related=(Related(said, _span(equation)),),
    )


def _held_already(dae: Dae, held: Mapping[str, tuple[Part, Related]]) -> Iterator[Diagnostic]:
    """The parts that hold too much; those that are connected to each other in one message."""
    groups = DisjointSets(held)
    for ends in dae.connections:
        joined = [n for n in own_names(dae, map(owner, ends)) if n in held]
        for name in joined[1:]:
            groups.join(joined[0], name)
    for names in groups.sets():
        parts = [held[name][0] for name in names]
        several = len(parts) > 1
        shown = listed(f"`{part.name}`" for part in parts)
        between = "them" if several else "it and what it is connected to"
        if not several and (swapped := _open_beside(dae, parts[0])) is not None:
            end, other, free = swapped
            yield Held(
                "S301",
                f"what {shown} holds is held already: `{end}` is connected to `{other}`, and "
                f"nothing to `{free}` beside it",
                parts[0].span,
                hint=f"connect `{end}` to `{free}`",
                related=tuple(held[name][1] for name in names),
            )
            continue
        fixed = [fixed_together(dae, part, parts) for part in parts]
        if not several and not any(fixed):
            fixed = [fixed_by_its_end(dae, parts[0])]
        if all(fixed):
            for found in filter(None, fixed):
                told = (found.code, found.message, found.span)
                yield Held(*told, hint=found.hint, related=found.related)
            continue
        hint = f"remove {'one of them' if several else shown}, or put a joint between {between}"
        if not several and (meant := _open_elsewhere(dae, parts[0])) is not None:
            hint = f"connect `{meant[0]}` to `{meant[1]}`, to which nothing is connected"
        yield Held(
            "S301",
            f"what {shown} {'hold' if several else 'holds'} is held already",
            parts[-1].span,
            hint=hint,
            related=tuple(held[name][1] for name in names),
        )


def _open_beside(dae: Dae, part: Part) -> tuple[str, str, str] | None:
    """An end of a part, what that is connected to, and an end beside the latter that is open: of
    a joint whose `support` was taken for its `axis`."""
    connected = [ends for ends in dae.connections if len(ends) > 1]
    for ends in connected:
        for end in (e for e in ends if owner(e) == part.name):
            for other in (o for o in ends if owner(o) and owner(o) != part.name):
                ends_there = _ends(dae, owner(other))
                beside = (e for e in ends_there if e != other and other in ends_there)
                inside = f"{owner(other)}."
                outer = [ends for ends in connected if any(not e.startswith(inside) for e in ends)]
                free = [e for e in beside if not any(e in ends for ends in outer)]
                if free:
                    return end, other, free[0]
    return None


def _open_elsewhere(dae: Dae, part: Part) -> tuple[str, str] | None:
    """The one flange of a part, and the only one in the model that asks for a connection and has
    none, where they are of one kind."""
    own = _ends(dae, part.name)
    free = [w.connector for w in dae.warnings if isinstance(w, Unconnected)]
    if len(own) != 1 or len(free) != 1 or free[0] not in _ends(dae, owner(free[0])):
        return None
    names = {v.name for v in dae.variables}
    alike = all((f"{own[0]}.{n}" in names) == (f"{free[0]}.{n}" in names) for n in ("tau", "f"))
    return (own[0], free[0]) if alike else None


def _ends(dae: Dae, component: str) -> list[str]:
    """The flanges of a component, by their flows."""
    names = {v.name for v in dae.variables if not v.protected}
    ends = dict.fromkeys(owner(n) for n in names if n.startswith(f"{component}."))
    pairs = (("tau", "phi"), ("f", "s"))
    return sorted(
        e
        for e in ends
        if owner(e) == component and any({f"{e}.{a}", f"{e}.{b}"} <= names for a, b in pairs)
    )


def _driven_by(dae: Dae, part: Part) -> list[Part]:
    """A part, and by way of its signals those up to one that moves something; else itself last."""
    connected = {owner(end) for ends in dae.connections for end in ends}
    physical = {p.name for c in connected if (p := own_part(dae, c)) is not None}
    signals = [(e.left.name, e.right.name) for e in dae.equations if _is_signal(e)]
    queue = [part]
    for found in queue:
        if found.name in physical:
            return [*(p for p in queue if p is not found), found]
        both_ways = (*signals, *(s[::-1] for s in signals))
        ends = dict.fromkeys(b for a, b in both_ways if a.startswith(f"{found.name}."))
        queue += [p for e in ends if (p := own_part(dae, owner(e))) and p not in queue]
    return queue[::-1]


def _driver(dae: Dae, component: str) -> str:
    """The part that moves something by what a component gives, for a signal; else the component."""
    part = own_part(dae, component)
    return component if part is None else _driven_by(dae, part)[-1].name


def _is_signal(equation: Equation) -> bool:
    """Whether a connection makes two variables equal."""
    return equation.generated and equation.left.is_symbol and equation.right.is_symbol


def _determines_nothing(equation: Equation, message: str) -> Diagnostic:
    hint = "remove it, or free a variable that the other equations hold"
    if equation.generated:
        hint = "put a joint between the parts that it connects: they are held already"
    return Diagnostic("S301", message, _span(equation), hint=hint)


def _equations(dae: Dae, elimination: Elimination, numbers: Sequence[int]) -> list[Equation]:
    return [dae.equations[elimination.live[e].index] for e in numbers]


def _over(
    dae: Dae, elimination: Elimination, equations: Sequence[int], variables: Sequence[int]
) -> Diagnostic:
    chosen = _equations(dae, elimination, equations)
    surplus = len(equations) - len(variables)
    owners = own_names(dae, (_driver(dae, e.component) for e in chosen if e.component))
    units = {v.name: v.unit for v in dae.variables}
    kept = [elimination.kept[v] for v in variables]
    unknowns = _names([n for n in kept if units.get(n)] or kept)  # what has a unit, before signals
    what = "these equations or connections"
    message = f"{counted(len(equations), 'equation')} for {counted(len(variables), 'unknown')} "
    message += f"({unknowns}): {surplus} too many"
    drives = [n for n in owners if n in dae.drives]
    if len(drives) > 1:  # what else there is carries their motion on
        passing = listed(f"`{n}`" for n in owners if n not in drives)
        owners = drives
        unknowns += f", by way of {passing}" if passing else ""
    if 2 <= len(owners) <= 4:
        parts, what = listed(f"`{n}`" for n in owners), "them"
        message = f"{parts} {'both' if len(owners) == 2 else 'all'} decide {unknowns}"
    return Overdone(
        "S302",
        message,
        owner_span(dae, f"{_driver(dae, chosen[-1].component)}.x") or _span(chosen[-1]),
        hint=f"remove {'one' if surplus == 1 else surplus} of {what}",
        related=_listed(chosen),
        holders=tuple(dict.fromkeys(e.component for e in chosen if e.component)),
    )


def _under(
    dae: Dae, elimination: Elimination, equations: Sequence[int], variables: Sequence[int]
) -> Diagnostic:
    names = [elimination.kept[v] for v in variables]
    chosen = _equations(dae, elimination, equations)
    missing = len(variables) - len(equations)
    redundant = [dae.equations[i] for i in elimination.vanished]
    head = (
        f"nothing determines {_names(names)}"
        if not equations
        else (
            f"{counted(len(equations), 'equation')} for {counted(len(names), 'unknown')} "
            f"({_names(names)}): {missing} missing"
        )
    )
    points = _points(dae, names)
    idle = () if points else redundant[:_LISTED]  # sums of torques, of which a point takes none
    related = _listed(chosen) + tuple(
        Related(f"{e.shown} says nothing new: it follows from other equations", _span(e))
        for e in idle
    )
    if (twice := _said_twice(dae, redundant, names)) is not None:
        return twice
    ungrounded = find_ungrounded(dae, names) if redundant and not points else None
    if ungrounded is not None:
        return ungrounded
    forces = any(n.endswith((".t", ".f", ".f[1]", ".f[2]")) for n in names)
    if redundant and forces:
        return _repeated(names, redundant)
    return Diagnostic(
        "S303", head, owner_span(dae, names[0]), hint=_hint(dae, names), related=related
    )


def _said_twice(dae: Dae, redundant: Sequence[Equation], names: Sequence[str]) -> Diagnostic | None:
    """The message about two equations of the user's that are the same."""
    own = [e for e in dae.equations if not e.generated and is_own(dae, e.span)]
    for again in (e for e in redundant if e in own):
        first = twins(again, own)[0]
        if first is not again:
            return Diagnostic(
                "S303",
                f"{first.shown} and {again.shown} say the same, and nothing determines "
                f"{_names(names)}",
                _span(again),
                hint="write another equation in the place of one of them",
                related=(Related(f"{first.shown} stands here", _span(first)),),
            )
    return None


def _repeated(names: Sequence[str], redundant: Sequence[Equation]) -> Diagnostic:
    """Components whose forces are open, since what they hold is held already."""
    last = redundant[-1]
    note = Related(f"{last.shown} says nothing new: it follows from other equations", _span(last))
    return Repeated(
        "S303",
        f"nothing determines {_names(names)}",
        _span(last),
        hint="a constraint repeats others: replace one of the joints in the loop by a freer one",
        related=(note,),
        holders=tuple(dict.fromkeys(n.rsplit(".", 2)[0] for n in names)),
    )


def _at_angles(dae: Dae, names: Sequence[str]) -> list[str]:
    """The frames whose angles are open, and the components at them."""
    frames = {n.removesuffix(".phi") for n in names if n.endswith(".phi")}
    joined = (ends for ends in dae.connections if not frames.isdisjoint(ends))
    owners = [*sorted(frames), *(n.rpartition(".")[0] for ends in joined for n in ends)]
    return [*owners, *(n.rpartition(".")[0] for n in sorted(frames))]


def _points(dae: Dae, names: Sequence[str]) -> list[str]:
    """The point masses at frames whose angles are open."""
    parameters = {p.name for p in dae.parameters}
    return [o for o in _at_angles(dae, names) if f"{o}.fixAngle" in parameters]


def _hint(dae: Dae, names: Sequence[str]) -> str:
    """The cause in a planar mechanism that leaves such an unknown open."""
    points = list(dict.fromkeys(p for n in names for p in _points(dae, [n])[:1]))
    if points:
        which, parts = ("it", "a part") if len(points) == 1 else ("them", "parts")
        turns = "turns" if len(points) == 1 else "turn"
        return (
            f"set `fixAngle=true` in {listed(f'`{p}`' for p in points)}, or connect {which} to "
            f"{parts} that {turns} with {which}"
        )
    if _at_angles(dae, names):
        return "give the loose part a mass with inertia, or a joint that holds its angle"
    return f"add an equation, a connection or a binding for `{names[0]}`"


def _listed(equations: Sequence[Equation]) -> tuple[Related, ...]:
    shown = [Related(f"{e.shown}{_inside(e)}", _span(e)) for e in equations[:_LISTED]]
    if len(equations) > _LISTED:
        shown.append(Related(f"and {len(equations) - _LISTED} more equations"))
    return tuple(shown)


def _inside(equation: Equation) -> str:
    return f" (in `{equation.component}`)" if equation.component else ""


def _span(equation: Equation) -> Span | None:
    return None if equation.span is NOWHERE else equation.span


def _names(names: Sequence[str]) -> str:
    return shortened([f"`{n}`" for n in names], _SHOWN)
