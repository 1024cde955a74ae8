"""Ends of components that are connected to nothing, where these cannot do without.

In:   Dae, Mechanism (None where there are no frames); the unknowns that nothing determines, and
      the parts whose signals determine nothing
Out:  a message S303, or None; warnings S323 where the equations fit all the same

Example: of `connect(motor.flange, hinge.axis)` forgotten, `motor.flange` is connected to nothing.
Of a hinge whose two neighbours are both connected to its `frame_b`, one belongs to `frame_a`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from math import hypot

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import be, both, shortened
from planarc.evaluate.declared import DeclaredValues
from planarc.insight.attachment import is_open, open_apart, place
from planarc.insight.connectors import find_connectors, find_frames, find_pins, grouped, owner
from planarc.insight.idle import find_elements
from planarc.insight.sensors import hidden_connectors, zeros
from planarc.ir.dae import Dae
from planarc.ir.flat import Connect, Part
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import is_own, own_part

_SHOWN = 4
#: The radius of gyration of a body is so small a part of the rod on whose end it was to hang: that
#: of a disc with a pointer is larger.
_SMALL = 0.3
_SECOND = "the second of them is connected here"


def left_open(
    dae: Dae, mechanism: Mechanism | None, undetermined: Sequence[str], givers: Sequence[Part]
) -> Diagnostic | None:
    """The ends, connected to nothing, of components whose own unknowns nothing determines."""
    parts = _own(dae, map(owner, undetermined)) | {part.name for part in givers}
    connected = {name for names in dae.connections if len(names) > 1 for name in names}
    names = find_connectors(v.name for v in dae.variables)
    inside = {owner(name) for name in names}  # a part with a flange and variables as those of one
    ends = [n for n in names if owner(n) in parts and n not in connected and n not in inside]
    hidden, zero = hidden_connectors(dae), zeros(dae)
    ends = [n for n in ends if not all(f"{n}.{position}" in zero for _, position in names[n])]
    ends = [n for n in ends if n not in hidden] or ends
    if not ends:
        return None
    shown = shortened([f"`{name}`" for name in ends], _SHOWN)
    first = owner(ends[0])
    flows = {f"{c}.{flow}" for c, pairs in names.items() for flow, _ in pairs}
    moved = [n for n in undetermined if n not in flows] or undetermined
    effect = f"so that nothing determines {shortened([f'`{n}`' for n in moved], _SHOWN)}"
    if not undetermined:
        effect = f"so that `{givers[-1].name}` moves nothing"
    joined = f"what `{first}` belongs to"
    own = undetermined and all(n.startswith(f"{first}.") for n in undetermined)
    if not own and ends[0] in find_frames(v.name for v in dae.variables):
        joined = "a body with mass"
    if mechanism is not None and first in (j.name for j in mechanism.joints):
        free = open_apart(dae, mechanism)
        joined = f"`{free}`, which is open too" if free else _carrier(dae, ends[0])
    hint = f"connect `{ends[0]}` to {joined}, or leave `{first}` out"
    related: tuple[Related, ...] = ()
    if len(ends) == 1 and "open too" not in joined:
        hint, related = _instead(dae, mechanism, ends[0], hint)
    if f"{first}.fixAngle" in {p.name for p in dae.parameters} and all(
        n.endswith(".phi") for n in undetermined
    ):
        hint = f"a point has no angle of its own: set `fixAngle=true` in `{first}`"
    return Diagnostic(
        "S303",
        f"{shown} {be(len(ends))} connected to nothing, {effect}",
        place(dae, first),
        hint=hint,
        related=related,
    )


def bare_joints(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    """The warnings about joints with a flange that carry nothing: what drives them moves nothing of
    the mechanism, though the equations fit."""
    connected = {name for names in dae.connections if len(names) > 1 for name in names}
    flanges = {n for n in connected if n.endswith(".axis")}
    ground = set(mechanism.links[GROUND].frames)
    for joint in mechanism.joints:
        ends = [f for f in joint.frames if f.count(".") == 1 and f not in connected]
        if len(ends) != 1 or f"{joint.name}.axis" not in flanges or ends[0] in ground:
            continue
        hint = f"connect `{ends[0]}` to a body with mass"
        hint, related = _instead(dae, mechanism, ends[0], hint)
        yield Diagnostic(
            "S323",
            f"`{ends[0]}` is connected to nothing, so that `{joint.name}` moves nothing",
            place(dae, joint.name),
            Severity.WARNING,
            hint=hint,
            related=related,
        )


def bare_contacts(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    """The warnings about contacts of which one frame is open: what is there has no mass, and its
    motion is open where the contact does not hold it."""
    contacts = {p.name for p in dae.parts if ".Contacts." in p.class_name}
    frames = find_frames(v.name for v in dae.variables) if contacts else ()
    connected = {f for names in dae.connections for f in names if not is_open(f, names)}
    for name, ends in grouped((f for f in frames if owner(f) in contacts), owner).items():
        free = [f for f in ends if f not in connected]
        if len(ends) == 2 and len(free) == 1:
            yield Diagnostic(
                "S323",
                f"`{free[0]}` is connected to nothing, so that `{name}` has nothing to touch",
                place(dae, name),
                Severity.WARNING,
                hint=f"connect `{free[0]}` to what `{name}` is to touch, such as the ground",
            )


def bare_rods(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    """The warnings about rods of which one end has no connection: what was to hang on it hangs on
    the other one, which has two and no mass, or on the end of an equal rod beside it."""
    connected = {f for names in dae.connections for f in names if not is_open(f, names)}
    heavy = {owner(p.name) for p in dae.parameters if p.name.endswith(".m")}
    joints = {joint.name for joint in mechanism.joints}
    for link in mechanism.links[1:]:
        for end in (f for f in link.frames if f.count(".") == 1 and f not in connected):
            part = owner(end)
            inside = [f for f in link.frames if owner(f) == part]
            if part in joints or len(inside) != 2:
                continue
            hint, related = ("", ()) if part in heavy else _instead(dae, None, end, "")
            if not hint and part not in heavy:
                hint, related = _on_its_hinge(dae, end, inside, find_pins(dae, mechanism))
            if not hint:
                hint, related = _on_its_twin(dae, end, inside, heavy)
            if not hint:
                continue
            told = f"nothing is connected to `{end}`"
            if part not in heavy:
                told = f"`{part}` changes nothing: it has no mass, and `{end}` is connected to "
                told += "nothing"
            yield Diagnostic(
                "S323", told, place(dae, part), Severity.WARNING, hint=hint, related=related
            )


def _carrier(dae: Dae, end: str) -> str:
    """What an end of a joint may be meant to be connected to."""
    worlds = [p.name for p in dae.parts if p.inner and p.class_name.endswith(".World")]
    ground = f", such as `{worlds[0]}.frame_b`" if worlds and end.endswith("_a") else ""
    return f"a part that it moves or stands on{ground}"


def _instead(
    dae: Dae, mechanism: Mechanism | None, end: str, hint: str
) -> tuple[str, tuple[Related, ...]]:
    """What to do about an open end where two parts are connected to the other one, else `hint`;
    and where the second of these is connected."""
    both_there, part = _at_the_other_end(dae, end), owner(end)
    if len(both_there) < 2:
        return hint, ()
    others = [c.right if owner(c.left) == part else c.left for c in both_there]
    if mechanism is not None and not _may_be_parted(dae, mechanism, part, others):
        return hint, ()
    there = next(n for c in both_there for n in (c.left, c.right) if owner(n) == part)
    hint = f"{both(others)} are both connected to `{there}`: connect one of them to `{end}` instead"
    return hint, (Related(_SECOND, both_there[-1].span),)


def _may_be_parted(dae: Dae, mechanism: Mechanism, joint: str, others: Sequence[str]) -> bool:
    """Whether two rigid parts at one end may belong to both ends. What another joint or a spring
    carries at the end of a joint moves on the other part as it is; and where no way leads from
    them to the ground, it is the ground that is missing."""
    if joint not in {j.name for j in mechanism.joints}:
        return True
    elements = {*find_elements(dae)}
    if not (elements | {j.name for j in mechanism.joints}).isdisjoint(map(owner, others)):
        return False
    frames = find_frames(v.name for v in dae.variables)
    sets = DisjointSets(("", *frames))
    for component, inside in grouped(frames, owner).items():
        for frame in inside if component not in (joint, *elements) else ():
            sets.join(inside[0], frame)
    for connect in dae.connects:
        ends = (connect.left, connect.right)
        if all(f in sets for f in ends) and joint not in map(owner, ends):
            sets.join(*ends)
    for frame in mechanism.standing:
        sets.join("", frame)
    return any(sets.find(frame) == sets.find("") for frame in others)


def _on_its_hinge(
    dae: Dae, end: str, inside: Sequence[str], pins: Collection[str]
) -> tuple[str, tuple[Related, ...]]:
    """What to do where a rod without mass begins at a hinge on whose axis the centre of a small
    body is, which was to hang on the rod's open end; and where that is connected."""
    values = DeclaredValues(dae)
    (near,) = (f for f in inside if f != end)
    length = values.named(f"{owner(end)}.r[1]", f"{owner(end)}.r[2]")
    beside = (n for names in dae.connections if near in names for n in names)
    hinge = next((n for n in beside if owner(n) in pins), "")
    own = [c for c in dae.connects if hinge in (c.left, c.right) and is_own(dae, c.span)]
    for connect in own:
        body = owner(connect.right if connect.left == hinge else connect.left)
        numbers = values.named(*(f"{body}.{n}" for n in ("m", "I", "r_CM[1]", "r_CM[2]")))
        if length is None or numbers is None or numbers[0] <= 0 or any(numbers[2:]):
            continue
        if numbers[1] / numbers[0] < (_SMALL * hypot(*length)) ** 2:
            frame = next(n for n in (connect.left, connect.right) if owner(n) == body)
            hint = f"write `connect({end}, {frame});`: `{body}` is on the axis of `{owner(hinge)}`"
            return hint, (Related(f"`{body}` is connected here", connect.span),)
    return "", ()


def _on_its_twin(
    dae: Dae, end: str, inside: Sequence[str], heavy: set[str]
) -> tuple[str, tuple[Related, ...]]:
    """What to do where a rod of the same class begins at the same place, and its far end carries
    two bodies; and where the second of these is connected."""
    (near,) = (f for f in inside if f != end)
    classes = {p.name: p.class_name for p in dae.parts}
    elements = {*find_elements(dae)}
    beside = next((names for names in dae.connections if near in names), ())
    for there in beside:
        twin = owner(there)
        if twin == owner(end) or classes.get(twin) != classes.get(owner(end)):
            continue
        far = f"{twin}.{end.rpartition('.')[2]}"
        own = [c for c in dae.connects if far in (c.left, c.right) and is_own(dae, c.span)]
        bodies = [owner(c.right if c.left == far else c.left) for c in own]
        classes_there = {classes.get(b) for b in bodies}
        alike = len(classes_there) == 1 and elements.issuperset(bodies)
        if len(bodies) == 2 and (heavy.issuperset(bodies) or alike):
            hint = f"{both(bodies)} are both connected to `{far}`: connect one of them to `{end}`"
            return f"{hint} instead", (Related(_SECOND, own[-1].span),)
    return "", ()


def _at_the_other_end(dae: Dae, end: str) -> list[Connect]:
    """The user's connections of other parts with the other end of a part of two, where there are
    two: one of them was meant for the open end."""
    frames = find_frames(v.name for v in dae.variables)
    part = owner(end)
    others = [f for f in frames if owner(f) == part and f != end]
    if len(others) != 1 or end not in frames:
        return []
    here = [c for c in dae.connects if others[0] in (c.left, c.right) and is_own(dae, c.span)]
    return here if len(here) == 2 else []


def _own(dae: Dae, components: Iterable[str]) -> set[str]:
    """The user's parts around components."""
    return {part.name for c in components if (part := own_part(dae, c)) is not None}
