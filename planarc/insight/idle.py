"""Parts that change nothing of a mechanism, though a user put them there.

In:   Dae, Mechanism
Out:  warnings S323

    both ends together   a spring whose ends are connected to each other
    free beside a joint  a part that only gives coordinates, as `FreeMotion`, between links that
                         joints hold together; with start values of its own it is no idle one
    inside of one part   a spring, damper or drive between two points of one rigid body or shaft
    on the ground        a force or torque on what cannot move, or a force on an axis that cannot
    beside its hinge     a pulley or gear wheel on the standing side of the hinge on which it turns
    on one point         a sensor of distances, or a spring along a line, whose frames are always
                         at the same place, as those of a hinge, or never move against each other

A spring, damper or drive is a component with two ends that declares what energy it stores, loses or
supplies, but no kinetic energy; a force or torque of the world is one with a single end.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Related, Severity, Unconnected
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import both, shortened
from planarc.insight.connectors import FRAME, find_connectors, find_pins, grouped, owner
from planarc.insight.sensors import find_ends, find_sensors, hidden_connectors, zeros
from planarc.ir.dae import WHEEL, Dae
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.flat import Misplaced, Part, StateSelect
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import declared_part, own_part

_FLOWS = ("f[1]", "f[2]", "t")
_SHOWN = 3


def idle_parts(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    link_of = {f: i for i, link in enumerate(mechanism.links) for f in link.frames}
    together, spare = [*_ends_together(dae, link_of)], spare_ground(dae, mechanism)
    if len(together) == len(spare) == 1:  # where one of its ends was to be
        hint = f"connect one of them to `{spare[0].name}`, which carries nothing"
        together, spare = [replace(together[0], hint=hint)], []
    yield from together
    yield from _free_beside_joints(dae, mechanism, link_of)
    yield from _wheels_that_stand(dae, mechanism, link_of)
    inside = [*_inside_links(dae, mechanism, link_of)]
    if len(inside) == len(spare) == 1:  # one of its ends was to be there
        (idle,), (ground,) = inside, spare
        note = carries_nothing(ground)
        hint = f"{idle.hint}, such as `{ground.name}`"
        yield replace(idle, hint=hint, related=(Related(note.message, note.span),))
        yield from _on_one_point(dae, mechanism)
        return
    yield from inside
    yield from _on_one_point(dae, mechanism)
    yield from map(carries_nothing, spare)


def idle_between_flanges(dae: Dae) -> Iterator[Diagnostic]:
    """Springs, dampers and drives between two flanges of one rigid shaft or slide, and drives on a
    flange that stands still."""
    connectors = find_connectors(v.name for v in dae.variables)
    positions = {c: f"{c}.{pairs[0][1]}" for c, pairs in connectors.items() if pairs is not FRAME}
    ends = grouped(positions, owner)
    every = frozenset(find_elements(dae))
    told = {w.component for w in dae.warnings if isinstance(w, Misplaced)}
    unconnected = [w for w in dae.warnings if isinstance(w, Unconnected)]
    elements = [c for c in ends if c in every and len(ends[c]) <= 2 and c not in told]
    rigid = _tied(dae, every) if elements else DisjointSets[str]()
    for component in elements:
        part = declared_part(dae, component)
        if len(ends[component]) == 1:
            (end,) = ends[component]
            if part is not None and _are_tied(rigid, positions[end], ""):
                what = f"`{component}` does nothing: what `{end}` is connected to stands still"
                idle = _idle(what, part, "connect it to what it is to move")
                free = [w for w in unconnected if connectors.get(w.connector) == connectors[end]]
                yield _meant(idle, end, free[0]) if len(free) == 1 else idle
            continue
        first, second = ends[component]
        if part is not None and _are_tied(rigid, positions[first], positions[second]):
            yield _beside_rigid(dae, part, (first, second), every)


def _beside_rigid(
    dae: Dae, part: Part, ends: tuple[str, str], elements: Collection[str]
) -> Diagnostic:
    """The warning of an element whose ends rigid parts hold together: a single one lies beside it,
    as a sensor that was to be put in series."""
    at = [{owner(n) for names in dae.connections if end in names for n in names} for end in ends]
    beside = [declared_part(dae, c) for c in sorted(set.intersection(*at)) if c not in elements]
    what = f"`{part.name}` does nothing: "
    rigid = beside[0] if len(beside) == 1 else None
    if rigid is None:
        return _idle(f"{what}{both(ends)} are held together by rigid parts", part)
    if rigid.name in {d.component for d in dae.declared if d.kind == "energy"}:
        return _idle(f"{what}both its ends are on `{rigid.name}`, which is rigid", part)
    idle = _idle(
        f"{what}`{rigid.name}`, which is rigid, joins the same two parts beside it",
        part,
        f"put `{rigid.name}` in series with it: connect one end of `{part.name}` to "
        f"`{rigid.name}` alone",
    )
    return replace(idle, related=(Related(f"`{rigid.name}` is declared here", rigid.span),))


def _meant(idle: Diagnostic, end: str, free: Unconnected) -> Diagnostic:
    """The warning with the only end that is open, and of its kind."""
    hint = f"write `connect({end}, {free.connector});`"
    return replace(idle, hint=hint, related=(Related(free.message, free.span),))


def _inside_links(
    dae: Dae, mechanism: Mechanism, link_of: Mapping[str, int]
) -> Iterator[Diagnostic]:
    ends_of = find_ends(dae, link_of)
    connectors = find_connectors(v.name for v in dae.variables)
    other = {joint.name for joint in mechanism.joints}
    other |= {owner(c) for c, pairs in connectors.items() if pairs is not FRAME}  # it holds shafts
    for component in (c for c in find_elements(dae) if c not in other):
        ends = ends_of.get(component, [])
        links, part = {link_of[end] for end in ends}, declared_part(dae, component)
        if part is None or len(links) != 1 or _together(dae, component):
            continue
        (link,) = links
        if len(ends) > 1:
            on = "on the ground" if link == GROUND else f"on {_rigid_part(ends, mechanism, link)}"
            yield _idle(f"`{component}` does nothing: both its ends are {on}", part)
        elif link == GROUND:
            yield Diagnostic(
                "S323",
                f"`{component}` does nothing: `{ends[0]}` is on the ground, which cannot move",
                part.span,
                Severity.WARNING,
                hint=f"connect `{ends[0]}` to a part that moves",
            )
        elif f"{ends[0]}.t" in zeros(dae) and (axis := _axis_at(dae, mechanism, ends[0])):
            yield _idle(
                f"`{component}` moves nothing: `{ends[0]}` is on the axis of `{axis}`, which stays "
                "where it is",
                part,
                f"connect `{ends[0]}` to a point beside that axis, such as the other end of a bar",
            )


def _axis_at(dae: Dae, mechanism: Mechanism, frame: str) -> str:
    """The hinge on the ground at which a frame is."""
    there = {*next((names for names in dae.connections if frame in names), ())}
    near = [
        j.name for j in mechanism.joints if GROUND in j.links and not there.isdisjoint(j.frames)
    ]
    pins = find_pins(dae, mechanism) if near else set()
    return next((name for name in near if name in pins), "")


def _rigid_part(ends: Sequence[str], mechanism: Mechanism, link: int) -> str:
    """The part that two ends are on, or the parts of one piece."""
    owners = Counter(f.partition(".")[0] for f in mechanism.links[link].frames)
    name = mechanism.links[link].name.partition(".")[0]
    bars = {o for o, count in owners.items() if count > 1} - {e.partition(".")[0] for e in ends}
    if len(bars) > 1:
        return f"one rigid part, that of `{name}`"
    return f"`{name}`, which is rigid"


def _wheels_that_stand(
    dae: Dae, mechanism: Mechanism, link_of: Mapping[str, int]
) -> Iterator[Diagnostic]:
    """Wheels on the ground at a hinge beside which they were to turn, and the other one of which
    turns on the ground, too: on a carrier it rolls about the one that stands."""
    wheels = [d for d in dae.declared if d.kind == "size" and d.name.startswith(WHEEL)]
    ends = [(d.component, f"{d.component}.{d.name.removeprefix(WHEEL)}") for d in wheels]
    pins = find_pins(dae, mechanism) if ends else set()
    meshing = {component for component, _ in ends}
    grounded = [j for j in mechanism.joints if GROUND in j.links and j.name not in meshing]
    for component, end in ends:
        part = declared_part(dae, component)
        others = {f for f, _ in link_of.items() if owner(f) == component and f != end}
        carried = {link_of[f] for f in others} - {GROUND}
        if part is None or link_of.get(end) != GROUND or not carried:
            continue
        if not all(any(link in j.links for j in grounded) for link in carried):
            continue
        beside = {n for names in dae.connections if end in names for n in names}
        for hinge in (j for j in grounded if j.name in pins and beside.intersection(j.frames)):
            turns = next((f for f in hinge.frames if link_of[f] not in (GROUND, *carried)), None)
            if turns is not None:
                what = f"`{end}` is on the side of `{hinge.name}` that stands still"
                yield _idle(what, part, f"write `connect({turns}, {end});`, so that it turns")
                break


def _on_one_point(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    """Sensors and springs that read places, but no angles, of two frames with the same place."""
    frames = [f for link in mechanism.links for f in link.frames]
    sensors = find_sensors(dae, frames)
    pairs = [(c, ends) for c, ends in sensors.items() if len(ends) == 2]
    pairs += _line_forces(dae, mechanism)
    tied = _tied(dae) if pairs else None
    link_of = {frame: i for i, link in enumerate(mechanism.links) for frame in link.frames}
    inside = {c for c, ends in pairs if len({link_of[end] for end in ends}) == 1}
    for component, ends in pairs:
        part, is_sensor = declared_part(dae, component), component in sensors
        if tied is None or part is None or _together(dae, component):
            continue
        if component in inside and is_sensor:
            yield Diagnostic(
                "S323",
                f"what `{component}` shows never changes: {both(ends)} are on one rigid part",
                part.span,
                Severity.WARNING,
                hint="connect one of them to another part",
            )
        places = [[f"{e}.r[{i}]" for e in ends] for i in (1, 2)]
        if component in inside or not all(_are_tied(tied, *pair) for pair in places):
            continue
        if {f"{e}.phi" for e in ends} & _read_by(dae, component):
            continue
        together = _tied(dae, offsets=False)
        if all(_are_tied(together, *pair) for pair in places):
            what, why = "always shows 0" if is_sensor else "does nothing", "are one point"
        else:
            still = all(_are_tied(tied, pair[0], "") for pair in places)
            what = "shows what never changes" if is_sensor else "does nothing"
            why = "stand still" if still else "never move against each other"
        hint = "connect one of them to another point"
        if not is_sensor:
            hint += "; what turns a hinge is a rotational spring or drive, at its flange"
        yield _idle(f"`{component}` {what}: {both(ends)} {why}", part, hint)


def _line_forces(dae: Dae, mechanism: Mechanism) -> Iterator[tuple[str, list[str]]]:
    """Springs, dampers and drives between two frames that turn neither."""
    joints, zero = {joint.name for joint in mechanism.joints}, zeros(dae)
    elements = [c for c in find_elements(dae) if c not in joints]
    ends_of = find_ends(dae, (f for link in mechanism.links for f in link.frames))
    for component in elements:
        ends = ends_of.get(component, [])
        if len(ends) == 2 and all(f"{end}.t" in zero for end in ends):
            yield component, ends


def spare_ground(dae: Dae, mechanism: Mechanism) -> list[Part]:
    """Ground that carries nothing, beside other ground and joints."""
    joined = {owner(name) for names in dae.connections if len(names) > 1 for name in names}
    parts = (declared_part(dae, c) for c in mechanism.spare if mechanism.joints and c not in joined)
    return [part for part in parts if part is not None and not part.inner]


def carries_nothing(part: Part) -> Diagnostic:
    message = f"`{part.name}` carries nothing: nothing is connected to it"
    return _idle(message, part, "connect it, or leave it out")


def _idle(
    message: str, part: Part, hint: str = "connect one of them to another part"
) -> Diagnostic:
    return Diagnostic("S323", message, part.span, Severity.WARNING, hint=hint)


def _together(dae: Dae, component: str) -> bool:
    """Whether two ends of a component are connected to each other."""
    return any(sum(owner(n) == component for n in names) > 1 for names in dae.connections)


def find_elements(dae: Dae) -> Iterator[str]:
    """Springs, dampers and drives: components that declare energy, but no kinetic energy."""
    declared = (d for d in dae.declared if d.kind == "energy")
    for component, told in grouped(((f"{d.component}.{d.name}") for d in declared), owner).items():
        if not any(name.startswith(f"{component}.kinetic") for name in told):
            yield component


def _tied(dae: Dae, apart: Collection[str] = (), offsets: bool = True) -> DisjointSets[str]:
    """Positions that are equal, or differ by what never changes, by equations of all components
    but some; "" is one that stands still. Without offsets only those that are equal."""
    unknown, fixed = {v.name for v in dae.variables}, {p.name for p in dae.parameters}
    sets = DisjointSets([""])
    for equation in dae.equations:
        if equation.component in apart:
            continue
        both_sides = (equation.left, equation.right)
        if not (offsets or all(e.op is Op.SYMBOL for e in both_sides)):
            continue
        sides = [_place(side, unknown, fixed) for side in both_sides]
        if None not in sides and sides[0] != sides[1]:
            sets.join(*(s for s in sides if s is not None))
    return sets


def _place(e: Expr, unknown: set[str], fixed: set[str]) -> str | None:
    """The one unknown of a sum of it and of parameters; "" where there is none."""
    terms = e.args if e.op is Op.ADD else (e,)
    places = [t.name for t in terms if t.op is Op.SYMBOL and not t.order and t.name in unknown]
    others = [t for t in terms if not (t.op is Op.SYMBOL and t.name in unknown)]
    if len(places) > 1 or len(places) + len(others) < len(terms):
        return None
    leaves = (t for t in postorder(others) if not t.args)
    still = all(t.op is Op.CONST or (t.op is Op.SYMBOL and t.name in fixed) for t in leaves)
    return (places or [""])[0] if still else None


def _are_tied(sets: DisjointSets[str], first: str, second: str) -> bool:
    return first in sets and second in sets and sets.find(first) == sets.find(second)


def _read_by(dae: Dae, component: str) -> set[str]:
    """The names in a component's own equations."""
    sides = [s for e in dae.equations if e.component == component for s in (e.left, e.right)]
    return {e.data[0] for e in postorder(sides) if e.op is Op.SYMBOL}


def _ends_together(dae: Dae, frames: Mapping[str, int]) -> Iterator[Diagnostic]:
    for names in dae.connections:
        for component, ends in grouped((n for n in names if n in frames), owner).items():
            part = declared_part(dae, component) if len(ends) > 1 else None
            if part is not None and hidden_connectors(dae).isdisjoint(ends):
                yield Diagnostic(
                    "S323",
                    f"both ends of `{component}` are connected to each other: {both(ends)}",
                    part.span,
                    Severity.WARNING,
                    hint="connect one of them to another part",
                )


def _free_beside_joints(
    dae: Dae, mechanism: Mechanism, link_of: Mapping[str, int]
) -> Iterator[Diagnostic]:
    wanted = {v.component for v in dae.variables if v.state_select >= StateSelect.PREFER}
    wanted -= {v.component for v in dae.variables if v.start_written}
    wanted -= {joint.name for joint in mechanism.joints}
    ends_of = grouped((f for f in link_of if owner(f) in wanted), owner)
    if not ends_of:
        return
    zero = zeros(dae)
    joined = DisjointSets(range(len(mechanism.links)))
    for joint in mechanism.joints:
        for other in joint.links[1:]:
            joined.join(joint.links[0], other)
    for component, ends in ends_of.items():
        part = own_part(dae, component)
        if (
            part is None
            or len(ends) != 2
            or any(f"{e}.{f}" not in zero for e in ends for f in _FLOWS)
        ):
            continue
        first, second = (link_of[end] for end in ends)
        if joined.join(first, second):
            continue
        moving = {first, second} - {GROUND}
        joints = [j.name for j in mechanism.joints if moving.intersection(j.links)]
        holders = shortened([f"`{name}`" for name in joints], _SHOWN) or "another part"
        yield Diagnostic(
            "S323",
            f"`{part.name}` frees nothing: {holders} says already how its ends may move",
            part.span,
            Severity.WARNING,
            hint=f"leave `{part.name}` out; or leave out the joint, if that body is to fly freely",
        )
