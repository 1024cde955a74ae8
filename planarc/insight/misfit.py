"""Why the equations of a mechanism do not fit, in words of its parts and not of equations.

In:   Dae, Mechanism (None where there are no frames); the unknowns that nothing determines, and
      the parts whose signals determine nothing
Out:  the one message that takes the place of those about equations; None where they say it best

    a joint that is bridged   its frames are one rigid part, by other connections
    a body hung on a sensor   which holds nothing (`massless`)
    an end left open          a frame or flange is connected to nothing, and its component cannot do
                              without
    a link without mass       which joints or forces are to move (`massless`)

A group of parts without ground comes before both (`attachment`). The file is long because parts
are connected wrongly in many ways, and each has words of its own.

Example: of `connect(motor.flange, hinge.axis)` forgotten, the equations say that eleven of them,
from `pid` to `arm`, decide ten unknowns; the mechanism says that `motor.flange` is connected to
nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.options import ACCEPTING
from planarc.core.prose import be, both, listed, shortened
from planarc.core.source import Span
from planarc.insight.attachment import place
from planarc.insight.connectors import (
    find_connectors,
    find_frames,
    find_pins,
    grouped,
    owner,
    top,
)
from planarc.insight.massless import find_hung, find_massless, find_pushed, find_unloaded
from planarc.insight.open_ends import left_open
from planarc.insight.sensors import are_passed, find_ends, hidden_connectors
from planarc.ir.dae import Dae
from planarc.ir.flat import Connect, Part
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import is_own, own_names, own_part

_SHOWN = 4


def explain_misfit(
    dae: Dae, mechanism: Mechanism | None, undetermined: Sequence[str], givers: Sequence[Part] = ()
) -> Diagnostic | None:
    """What was connected wrongly, if that is why equations and unknowns do not fit."""
    if mechanism is not None and mechanism.bridged and not _has_no_place(dae, undetermined):
        return _bridged(dae, mechanism, mechanism.bridged[0])
    if mechanism is not None and (ends := _together(dae)):
        part = owner(ends[0])
        if hidden := hidden_connectors(dae).intersection(ends):
            frame = next((end for end in ends if end not in hidden), ends[0])
            return Diagnostic(
                "S303",
                f"`{part}` needs a frame at `{frame}`, and nothing is connected to it",
                place(dae, part.partition(".")[0]),
                hint=f"connect `{frame}` to a frame",
            )
        past = _past(dae, part, ends)
        return Diagnostic(
            "S303",
            f"both ends of `{part}` are connected to each other: {both(ends)}",
            place(dae, part.partition(".")[0]),
            hint="connect one of them to another part"
            if past is None
            else f"remove `{past.span.text}`, which goes past `{part}`",
            related=() if past is None else (Related("this goes past it", past.span),),
        )
    if (doubled := _past_a_shaft(dae, undetermined)) is not None:
        return doubled
    hung = None if mechanism is None else find_hung(dae, mechanism, undetermined)
    told = hung or left_open(dae, mechanism, undetermined, givers)
    if told is not None or mechanism is None:
        return told
    told = find_massless(dae, mechanism, undetermined)
    told = told or find_unloaded(dae, mechanism, givers)
    return told or find_pushed(dae, mechanism, givers)


def part_of_others(dae: Dae) -> Diagnostic | None:
    """The message about a model with ends of its own, which other models are to connect: whether
    its equations fit is seen there."""
    inside = {v.name for v in dae.variables if v.protected}
    ends = [n for n in find_connectors(v.name for v in dae.variables) if "." not in n]
    ends = [n for n in ends if not any(owner(v) == n for v in inside)]
    if not ends:
        return None
    shown, name = shortened([f"`{end}`" for end in ends], _SHOWN), dae.name.rpartition(".")[2]
    return Diagnostic(
        "S303",
        f"`{dae.name}` is a part for other models: its own {shown} {be(len(ends))} connected to "
        "nothing, and its equations do not fit without",
        next((p.span for p in dae.parts if p.name == ends[0] and is_own(dae, p.span)), dae.span),
        hint=f"declare `{name} part;` in a model that connects `part.{ends[0]}`, and check that "
        "model; `planarc check --all` checks parts by themselves",
    )


def overheld(dae: Dae, mechanism: Mechanism) -> tuple[str, Span | None, str] | None:
    """A sentence about the smallest loop whose joints hold more than its parts can move, or about
    all loops together, the place of the last joint, and what to do about two pins of one part,
    else nothing; None where these are not to blame."""
    loops = [
        found
        for joint in mechanism.joints
        if (found := mechanism.shortest_loop(joint, paired=True))
    ]
    every = {joint for loop in loops for joint in loop}
    together = tuple(joint for joint in mechanism.joints if joint in every)
    for joints in (*sorted(loops, key=len), *([together] if together else [])):
        around = {i for joint in joints for i in joint.links}
        links = sorted(around - {GROUND})
        held = sum(joint.conditions for joint in joints)
        free = sum(mechanism.links[i].free for i in links) - (0 if GROUND in around else _PLANE)
        if held > free:
            names = dict.fromkeys(joint.name.partition(".")[0] for joint in joints)
            parts = dict.fromkeys(mechanism.links[i].name.partition(".")[0] for i in links)
            last = [j.name for j in mechanism.joints if j in joints][-1]
            two = len(names) == 2 and find_pins(dae, mechanism).issuperset(j.name for j in joints)
            slide = "both hold the distance between them: put a slide (`Joints.Prismatic`) in line "
            slide += "with one of them, or leave one out;"
            hint = slide if two else ""
            if all(len(j.frames) == 1 for j in joints) and len(links) == 1:  # as wheels that roll
                hint = f"put a hinge (`Joints.Revolute`) between {both(parts)} and each of "
                hint += f"{both(names)}, which cannot turn by itself now;"
            return (
                f"{listed(f'`{n}`' for n in names)} hold {listed(f'`{n}`' for n in parts)} too "
                f"often: they take {held} motions away, and there are only {free}",
                place(dae, last.partition(".")[0]),
                hint,
            )
    return None


_BORNE = 2  # conditions of a hinge
_PLANE = 3  # motions in the plane, which the parts of a loop share
_SHORTEST = 2  # joints of a loop of one body


def overdriven(
    dae: Dae, mechanism: Mechanism, holders: Collection[str]
) -> tuple[str, Span | None, str] | None:
    """A sentence about several drives of one loop among components that hold too much, the place of
    the last one, and what to do."""
    giving = dae.drives
    drives = [name for name in own_names(dae, holders) if name in giving]
    moved = [mechanism.shortest_loop(j, paired=True) for j in mechanism.joints if j.name in holders]
    joints = own_names(dae, (j.name for loop in moved for j in loop))
    if len(drives) == 1:
        return _against_ground(dae, mechanism, holders, drives[0])
    if len(drives) < 2 or not joints:
        return None
    loop = listed(f"`{name}`" for name in joints)
    message = f"{both(drives)} drive one loop, that of {loop}: what one of them gives decides the "
    message += "motion of all"
    return message, place(dae, drives[-1].partition(".")[0]), "remove one of the drives"


def _against_ground(
    dae: Dae, mechanism: Mechanism, holders: Collection[str], drive: str
) -> tuple[str, Span | None, str] | None:
    """The same about a contact of what the drive turns with the ground, beside its one bearing."""
    for contact in mechanism.joints:
        if contact.conditions != 1 or contact.name not in holders or GROUND not in contact.links:
            continue
        loop = mechanism.shortest_loop(contact, paired=True)
        frame = next((f for f in contact.frames if f in mechanism.links[GROUND].frames), None)
        if len(loop) != _SHORTEST or frame is None:
            continue
        own = (c for c in dae.connects if is_own(dae, c.span) and frame in (c.left, c.right))
        span = next((c.span for c in own), place(dae, contact.name.partition(".")[0]))
        return (
            f"`{contact.name}` presses what `{loop[1].name}` carries against the ground, so that "
            f"`{drive}` cannot move it",
            span,
            f"connect `{frame}` to the part that is to follow, not to the ground",
        )
    return None


def rigid_ring(dae: Dae, mechanism: Mechanism) -> tuple[str, Span | None, str] | None:
    """A sentence about rigid parts that are connected to a ring, the place of the last of them, and
    what to do; None where there is no ring."""
    frames = {f for link in mechanism.links for f in link.frames}
    point = {f: f for f in frames}
    for names in dae.connections:
        point |= dict.fromkeys((n for n in names if n in frames), names[0])
    holding = {j.name for j in mechanism.joints} | {*mechanism.inside}
    ways: dict[str, list[tuple[str, str]]] = {}  # from a point: rigid parts, and where they lead
    for link in mechanism.links:
        for part, ends in grouped(link.frames, owner).items():
            if part in holding or len(ends) != 2:
                continue
            a, b = (point[end] for end in ends)
            way = _way(ways, a, b)
            ring = own_names(dae, (*(way or ()), part))
            if way is not None and len(ring) == 1:  # a part inside of another one
                continue
            if way is not None:
                shown = listed(f"`{name}`" for name in ring)
                message = f"{shown} are connected to a ring, though all of them are rigid"
                hint = "leave one of these connections out, or put a joint there"
                last = own_part(dae, part)
                return message, last.span if last else None, hint
            ways.setdefault(a, []).append((part, b))
            ways.setdefault(b, []).append((part, a))
    return None


def _way(ways: Mapping[str, list[tuple[str, str]]], start: str, goal: str) -> list[str] | None:
    """The parts that lead from one point to another."""
    found: dict[str, list[str]] = {start: []}
    queue = [start]
    for here in queue:
        for part, other in ways.get(here, ()):
            if other not in found:
                found[other] = [*found[here], part]
                queue.append(other)
    return found.get(goal)


def held_twice(
    dae: Dae, mechanism: Mechanism, holders: Collection[str]
) -> tuple[str, Span | None, str] | None:
    """A sentence about the joints among components with open forces, the place of the last, and
    what to do; None where it is not several that hold the same."""
    joints = [joint.name for joint in mechanism.joints]
    names = [name for name in holders if name in joints]
    if len(names) < 2:
        return None
    part = own_part(dae, names[-1])
    return (
        f"{listed(f'`{name}`' for name in names)} hold the same motion twice",
        place(dae, names[-1].partition(".")[0]) if part is None else part.span,
        "replace one of them by a freer joint, or leave it out",
    )


def borne_twice(dae: Dae, mechanism: Mechanism) -> tuple[str, Span | None, str] | None:
    """A sentence about hinges of one part that bear what a gear bears on its carrier, as those of
    a sun and of its carrier on the ground; the place of the last, and what to do."""
    hinges = [j for j in mechanism.joints if len(j.links) == 2 and j.conditions == _BORNE]
    for gear in (j for j in mechanism.joints if len(j.links) > 2):
        on: dict[int, dict[int, str]] = {}  # of a part beside the gear: hinges to links of it
        for hinge in hinges:
            inside = [i for i in hinge.links if i in gear.links]
            outside = [i for i in hinge.links if i not in gear.links]
            if len(inside) == len(outside) == 1:
                on.setdefault(outside[0], {}).setdefault(inside[0], hinge.name)
        several = next((own for own in on.values() if len(own) > 1), None)
        if several is not None:
            names = own_names(dae, several.values())
            return (
                f"`{gear.name}` bears its wheels on their carrier itself, so that one of "
                f"{both(names)} is too many",
                place(dae, names[-1].partition(".")[0]),
                f"leave one of them out; joints that fit are accepted with {ACCEPTING}",
            )
    return None


def held_beside(
    dae: Dae, mechanism: Mechanism, place: Span | None
) -> tuple[str, Span | None, str] | None:
    """A sentence about a joint of several links, declared in a place, and others between two of
    these, as hinges of wheels that a gear carries already; the place of the last of them, and what
    to do."""
    parts = {p.name: p for p in dae.parts}
    own = next(
        (j for j in mechanism.joints if j.name in parts and parts[j.name].span == place), None
    )
    if own is None or len(own.links) < 3:
        return None
    others = [
        j for j in mechanism.joints if j is not own and len({*j.links}.intersection(own.links)) > 1
    ]
    names = own_names(dae, (j.name for j in others))
    if not names or any(len(j.links) > 2 for j in others):
        return None
    shown, last = listed(f"`{name}`" for name in names), parts.get(names[-1])
    message = f"{shown} {'holds' if len(names) == 1 else 'hold'} what `{own.name}` holds already"
    return message, last.span if last else place, f"leave {shown} out"


def _together(dae: Dae) -> tuple[str, ...]:
    """Two frames of one component that are connected to each other."""
    for names in dae.connections:
        frames = find_frames(v.name for v in dae.variables if owner(v.name) in names)
        for first in frames:
            others = [f for f in frames if f != first and owner(f) == owner(first)]
            if others:
                return first, others[0]
    return ()


def _past_a_shaft(dae: Dae, undetermined: Collection[str]) -> Diagnostic | None:
    """The error about a part whose two flanges are one shaft inside of it and one connection
    outside: what goes through it, and what goes past, is open."""
    flows = {owner(name) for name in undetermined if name.endswith((".tau", ".f"))}
    for names in dae.connections:
        ends = [name for name in names if name in flows]
        for first, second in pairwise(sorted(ends)):
            part = own_part(dae, owner(first))
            if owner(first) == owner(second) and part is not None and part.name == owner(first):
                return Diagnostic(
                    "S303",
                    f"both ends of `{part.name}` are connected to each other: "
                    f"{both((first, second))}",
                    part.span,
                    hint="leave one of them open, or connect it to another part",
                )
    return None


def _past(dae: Dae, part: str, ends: Sequence[str]) -> Connect | None:
    """The one connection of other parts that brings the ends of a part together."""
    connects = [c for c in dae.connects if is_own(dae, c.span)]
    own = [c for c in connects if part in (owner(c.left), owner(c.right))]
    others = [c for c in connects if c not in own]
    sides = {c.left if owner(c.right) == part else c.right for c in own}
    found = [c for c in others if {c.left, c.right} == sides]
    return found[0] if len(found) == 1 and len(sides) == 2 else None


def _bridged(dae: Dae, mechanism: Mechanism, joint: str) -> Diagnostic:
    ends = [name for name in find_frames(v.name for v in dae.variables) if owner(name) == joint]
    together = next((c for c in dae.connections if len({*ends}.intersection(c)) > 1), ())
    frames, connects = _bridge(dae, mechanism, joint)
    parts = [part for part in own_names(dae, map(owner, frames)) if part != joint]
    by = listed([f"`{part}`" for part in parts[:_SHOWN]]) or "rigid parts"
    how = f"by {by} around it"
    if together:
        outside = [name for name in together if name.count(".") < 2] or together
        how = f"since {listed(f'`{name}`' for name in outside)} are all connected"
    # What the joint itself is connected to was meant; else the last connection closed the ring.
    beside = [c for c in connects if joint not in (owner(c.left), owner(c.right))] or connects
    last = max(beside, key=lambda c: (c.span.start, c.right), default=None)
    hint = f"remove the connection around `{joint}`, or `{joint}` itself"
    span = place(dae, joint.partition(".")[0])
    where: tuple[Related, ...] = ()
    if last is not None:
        hint = f"remove `connect({last.left}, {last.right})` or `{joint}`"
        ends_of = find_ends(dae, frames)
        passed = next((p for p in parts if are_passed(dae, p, ends_of.get(p, ()))), None)
        if passed is not None and not together:
            hint = f"`{passed}` is a rigid connection: put it between two parts in place of the "
            hint += f"connection of these, not beside `{joint}`"
        elif len(parts) == 1 and not together:
            hint += f", or put `{parts[0]}` in line with it, between `{joint}` and another part"
        elif not together:
            hint += ", or put a joint there"
        where, span = (Related(f"`{joint}` is declared here", span),), last.span
    return Diagnostic(
        "S303",
        f"`{joint}` cannot move: {listed(f'`{end}`' for end in ends)} are held together, {how}",
        span,
        hint=hint,
        related=where,
    )


def _bridge(
    dae: Dae, mechanism: Mechanism, joint: str
) -> tuple[tuple[str, ...], tuple[Connect, ...]]:
    """The shortest way from one frame of a joint to the other, without it: through connections,
    rigid parts and the ground; its frames and connections."""
    link = next(i.frames for i in mechanism.links if joint in map(owner, i.frames))
    start, *goals = (f for f in link if owner(f) == joint)
    connects = {frozenset((c.left, c.right)): c for c in dae.connects if is_own(dae, c.span)}
    # Within its component a frame that only gives axes holds nothing.
    axes = hidden_connectors(dae).intersection(mechanism.standing)
    inner = (
        ends
        for names in dae.connections
        for part, ends in grouped(names, top).items()
        if part != joint
    )
    loose = {joint, *mechanism.bridged, *mechanism.inside}
    rigid = grouped((f for f in link if owner(f) not in loose and f not in axes), owner)
    sides = [*connects, mechanism.standing, *inner, *rigid.values()]
    ways: dict[str, tuple[str, ...]] = {start: (start,)}
    queue = [start]
    for frame in queue:
        for other in (o for side in sides if frame in side for o in side):
            if other in link and other not in ways:
                ways[other] = (*ways[frame], other)
                queue.append(other)
    way = ways.get(goals[0], ()) if goals else ()
    steps = (connects.get(frozenset(pair)) for pair in pairwise(way))
    return way, tuple(c for c in steps if c is not None)


def _has_no_place(dae: Dae, undetermined: Sequence[str]) -> bool:
    """Whether nothing says where a frame lies that is connected to nothing: its component, as a
    sensor of relative positions, only seems to hold a joint beside it."""
    connected = {name for names in dae.connections if len(names) > 1 for name in names}
    frames = find_frames(v.name for v in dae.variables)
    return any(owner(n) in frames and owner(n) not in connected for n in undetermined)
