"""Links without mass whose motion nothing determines.

In:   Dae, Mechanism, the unknowns that nothing determines
Out:  the error S303 about such a link; None where each has a mass, or none is loose

What stores or loses energy, but no kinetic energy, has no mass, nor have sensors and joints;
whatever else has derivatives in its equations has.

Example: the angle of the point between a spring and a damper in series, `spring.frame_b.phi`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Massless, Severity
from planarc.core.prose import be, both, listed, shortened
from planarc.insight.attachment import find_floating, hang, open_apart, place, replacing
from planarc.insight.connectors import FRAME, owner
from planarc.insight.idle import find_elements
from planarc.insight.sensors import find_sensors, zeros
from planarc.insight.topology import find_derived, find_moving
from planarc.ir.dae import Dae
from planarc.ir.flat import Part
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import own_names

_SHOWN = 4


def find_massless(
    dae: Dae, mechanism: Mechanism, undetermined: Collection[str]
) -> Diagnostic | None:
    """The error about the joints and forces around the first such link."""
    for loose in _loose_links(dae, mechanism, undetermined):
        link = loose.link
        what = shortened([f"`{n}`" for n in loose.open], _SHOWN)
        if loose.moved:
            what = f"how `{loose.moved[0]}` moves"
        if loose.moved and not link.rigid and len(link.around) == 1:
            return _unloaded(dae, mechanism, loose.moved[0], link.frames)
        return _told(dae, link.rigid, link.around, what)
    return None


def find_hung(dae: Dae, mechanism: Mechanism, undetermined: Collection[str]) -> Diagnostic | None:
    """The error about bodies that hang on nothing but a sensor, which such a link lacks."""
    links = _loose_links(dae, mechanism, undetermined)
    for group in find_floating(dae, mechanism) if links else ():
        found = (i for i in links if {*group.instead}.intersection(i.link.frames))
        if (loose := next(found, None)) is None:
            continue
        names = list(dict.fromkeys(c.partition(".")[0] for c in group.components))
        move = "moves" if len(loose.moved) == 1 else "move"
        joints = listed(f"`{name}`" for name in loose.moved)
        behind = f": nothing that {joints} {move} has a mass" if joints else ""
        return Diagnostic(
            "S303",
            f"{hang(names, group)}{behind}",
            place(dae, group.sensors[0].partition(".")[0]),
            hint=replacing(group),
        )
    return None


def find_unloaded(dae: Dae, mechanism: Mechanism, givers: Sequence[Part]) -> Diagnostic | None:
    """The error about a driven joint that moves nothing: its drive has no mass to accelerate, and
    what it gives contradicts the zero force of the open end."""
    joined = [own_names(dae, map(owner, ends)) for ends in dae.connections]
    driven = _driven(joined, {part.name for part in givers})
    for link in loaded_links(dae, mechanism):
        apart = {*link.around}.difference(own_names(dae, link.heavy))
        if len(link.joints) != 1 or link.joints[0] not in driven or len(apart) > 1:
            continue
        joint = link.joints[0]
        if not link.heavy:
            found = _unloaded(dae, mechanism, joint, link.frames, driven[joint])
            if not link.rigid:
                return found
            name = link.rigid[0]
            hint = f"give `{name}` a mass: `BodyShape` is a rod with one; or connect a body to it"
            return replace(found, hint=hint)
        if not link.rigid and link.heavy <= _points(dae, link.frames):
            mass = own_names(dae, sorted(link.heavy))[0]
            return Diagnostic(
                "S303",
                f"`{driven[joint]}` has nothing to turn: `{mass}` has no inertia, and is on the "
                f"axis of `{joint}` itself",
                place(dae, mass),
                hint=f"make `{mass}` a `Parts.Body` with an inertia `I`, or put a rod between "
                f"`{joint}` and it",
            )
    return None


def find_pushed(dae: Dae, mechanism: Mechanism, givers: Sequence[Part]) -> Diagnostic | None:
    """The error about a force or torque on what has no mass, and which a joint at most guides: it
    must vanish there. `givers` are parts whose equations determine nothing."""
    named, loads = {part.name for part in givers}, {*find_elements(dae)}
    zero = zeros(dae)
    for link in loaded_links(dae, mechanism):
        acting = [name for name in link.around if name in loads and name not in link.joints]
        # What only gives coordinates has derivatives, and carries nothing.
        flows = ((owner(f), f"{f}.{flow}") for f in link.frames for flow, _ in FRAME)
        carrying = {name for name, flow in flows if flow not in zero} & link.heavy
        if carrying or len(link.joints) > 1 or not acting:
            continue
        if named.isdisjoint((*acting, *link.rigid, *link.joints)):
            continue
        if not link.rigid:
            free = link.joints and _unloaded(dae, mechanism, link.joints[0], link.frames, acting[0])
            return free or None
        bar = link.rigid[0]
        return Diagnostic(
            "S303",
            f"nothing that {both(acting[:_SHOWN])} {'act' if len(acting) > 1 else 'acts'} on has a "
            f"mass: {both(link.rigid[:_SHOWN])} {be(len(link.rigid))} without",
            place(dae, acting[0].partition(".")[0]),
            hint=f"connect a body with mass to `{bar}`, or make it a `BodyShape`, a rod with one",
        )
    return None


#: What gives a force or a torque, by the end of its class's name; other sources give a motion.
_EFFORTS = ("Torque", "Force", "Torque2", "Force2")


def idle_drives(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    """The warning about a force or torque that drives a joint with nothing behind it: where a law
    of its own gives it, equations fit, and what has no mass follows it without inertia."""
    efforts = {p.name for p in dae.parts if p.class_name.endswith(_EFFORTS)}
    joined = [own_names(dae, map(owner, ends)) for ends in dae.connections]
    # Nor is there an inertia on the shaft.
    driven = _driven([names for names in joined if len(names) == 2], efforts)
    for link in loaded_links(dae, mechanism) if driven else ():
        joint = link.joints[0] if link.joints else ""
        if len(link.joints) == 1 and joint in driven and not link.heavy and len(link.around) <= 1:
            found = _unloaded(dae, mechanism, joint, link.frames, driven[joint])
            bar = f" or make `{link.rigid[0]}` a `BodyShape`" if link.rigid else ""
            yield replace(
                found,
                code="S323",
                severity=Severity.WARNING,
                hint=f"{found.hint},{bar}".rstrip(","),
            )


def stopped_alone(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    """The warning about a joint behind which nothing has a mass, beside stops or contacts of it:
    these fit the equations while they touch, and leave the motion open where they do not. A note
    where there are springs or dampers, by which it may be in balance."""
    contacts = {p.name for p in dae.parts if ".Contacts." in p.class_name}
    driven = {owner(v.name).removesuffix(".axis") for v in dae.variables if ".axis." in v.name}
    driven -= {*mechanism.passive}
    elements = {*find_elements(dae)}
    for link in loaded_links(dae, mechanism) if contacts or elements else ():
        joint, ends = link.joints[0] if link.joints else "", {*map(owner, link.frames)}
        beside = ends & (contacts | elements)
        others = ends - contacts - elements - {joint} - {*link.rigid}
        if len(link.joints) == 1 and beside and not (link.heavy or others or joint in driven):
            found = _unloaded(dae, mechanism, joint, link.frames)
            bar = f", or make `{link.rigid[0]}` a `BodyShape`" if link.rigid else ""
            sure = Severity.NOTE if beside - contacts else Severity.WARNING
            yield Massless("S323", found.message, found.span, sure, hint=f"{found.hint}{bar}")


def _driven(joined: Iterable[Sequence[str]], drives: Collection[str]) -> dict[str, str]:
    """The drive that each part is connected to."""
    return {n: d for names in joined for n in names for d in names if d in drives and d != n}


def _points(dae: Dae, frames: Sequence[str]) -> set[str]:
    """The components that take no torque at these frames."""
    zero = zeros(dae)
    return {owner(frame) for frame in frames if f"{frame}.t" in zero}


class LoadedLink(Data):
    """A link that moves, and what is on it."""

    frames: tuple[str, ...]
    joints: list[str]
    heavy: frozenset[str]  # components with mass
    rigid: list[str]  # components with two frames of it
    around: list[str]  # joints, and forces with one


def loaded_links(dae: Dae, mechanism: Mechanism) -> Iterator[LoadedLink]:
    """The links that move, in their order."""
    frames = [f for link in mechanism.links for f in link.frames]
    sensors = find_sensors(dae, frames).keys()
    weightless = {*sensors, *find_elements(dae), *(j.name for j in mechanism.joints)}
    heavy = find_moving(dae) - weightless
    joints_of: dict[int, list[str]] = {}
    for j in mechanism.joints:
        for number in dict.fromkeys(j.links):
            joints_of.setdefault(number, []).append(j.name)
    for number, link in enumerate(mechanism.links):
        if number == GROUND:
            continue
        ends = Counter(owner(f) for f in link.frames if owner(f) not in sensors)
        joints = joints_of.get(number, [])
        rigid = [c for c, count in ends.items() if c not in joints and count > 1]
        # A joint inside of a part stands for that part.
        inside = {o for o in ends if any(j.startswith(f"{o}.") for j in joints)}
        around = (c for c in ends if c not in rigid and c not in inside)
        there = heavy & ends.keys()
        yield LoadedLink(link.frames, joints, there, own_names(dae, rigid), own_names(dae, around))


class _Loose(Data):
    """A link without mass whose motion nothing determines."""

    link: LoadedLink
    moved: tuple[str, ...]  # joints on it whose motion is open
    open: tuple[str, ...]  # unknowns of its frames that are


def _loose_links(dae: Dae, mechanism: Mechanism, undetermined: Collection[str]) -> list[_Loose]:
    # Open forces say that something is held twice, and nothing of masses.
    places = {f"{f}.{v}" for link in mechanism.links for f in link.frames for _, v in FRAME}
    derived = find_derived(dae)
    moves = [n for n in undetermined if n in places or n in derived]
    loose = {owner(name) for name in moves}
    found = []
    for link in loaded_links(dae, mechanism):
        moved = tuple(j for j in link.joints if j in loose)
        if not link.heavy and (moved or not loose.isdisjoint(link.frames)):
            ours = tuple(n for n in moves if owner(n) in link.frames)
            found.append(_Loose(link, moved, ours))
    return found


def _unloaded(
    dae: Dae, mechanism: Mechanism, joint: str, frames: Sequence[str], drive: str = ""
) -> Diagnostic:
    """The message about a joint that moves nothing."""
    end = next(f for f in frames if owner(f) == joint)
    load = open_apart(dae, mechanism)
    effect = f"`{drive}` has nothing to accelerate" if drive else ""
    effect = effect or "nothing determines how it moves"
    return Diagnostic(
        "S303",
        f"nothing that `{joint}` moves has a mass, so that {effect}",
        place(dae, joint.partition(".")[0]),
        hint=f"connect `{end}` to {f'`{load}`' if load else 'a body with mass'}",
    )


def _told(dae: Dae, rigid: Sequence[str], around: Sequence[str], what: str) -> Diagnostic | None:
    """The message about the rigid parts of a link, and what is around it: joints and forces."""
    shown = listed([f"`{n}`" for n in rigid[:_SHOWN]])
    hint = "put a body with mass there, or leave one of them out"
    if rigid:
        hint = f"give `{rigid[0]}` a mass, or connect a body with mass to it"
    if len(around) > 1:
        between = f"between {both(around)}"
        message = f"{shown} {between} {be(len(rigid))} without mass" if rigid else ""
        message = message or f"nothing with mass is {between}"
    elif rigid and around:
        message = f"nothing that `{around[0]}` moves has a mass: {shown} {be(len(rigid))} without"
    else:
        return None
    last = (around or rigid)[-1].partition(".")[0]
    return Diagnostic(
        "S303", f"{message}, so that nothing determines {what}", place(dae, last), hint=hint
    )
