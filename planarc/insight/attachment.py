"""Parts that nothing joins to the ground, and mechanisms that cannot move.

In:   Dae, Mechanism
Out:  warnings S320 and S321; S321 as the one error where the equations do not fit for that reason;
      S322, to be said where nothing moves

Frames that a component has, and frames that are connected, hang together; a group in which no
frame stands still floats. A spring joins its ends as well as a joint does, so a body that hangs by
springs does not float; one that hangs on a sensor does. Who writes start values for a body that
floats means it to fly freely, and so does who holds it by `FreeMotion`.

Example: in a four-bar whose bearing was not connected, `bearing.frame_b` is at rest, but
`revA.frame_a` is connected to nothing: crank, coupler and rocker float.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Locked, Loose, Related, RigidLoop, Severity
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import be, both, listed, shortened
from planarc.core.source import NOWHERE, Span
from planarc.insight.connectors import find_frames, find_pins, grouped, owner, top, triangles
from planarc.insight.idle import carries_nothing, find_elements, idle_parts, spare_ground
from planarc.insight.sensors import find_sensors
from planarc.insight.topology import find_moving
from planarc.ir.dae import Dae
from planarc.ir.expr import Op, postorder
from planarc.ir.flat import Part, StateSelect
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import is_own

_SHOWN = 6
#: What rolls on the ground without a joint of its own.
ROLLING = ("RollingWheel", "RollingJoint")
_STANDING = "the world or to a part that stands on it"
#: What lets an equation change while nothing moves freely.
_CHANGING = (Op.TIME, Op.PRE, Op.EVENT, Op.PAST)


class Group(Data):
    """Components that hang together and not on the ground. `open` are frames of theirs to which
    nothing is connected; `sensors` are connected to them. `instead`: a frame of theirs, that on
    the other side of a sensor, and the sensor, which stands where these should be connected."""

    components: tuple[str, ...]
    open: tuple[str, ...]
    sensors: tuple[str, ...] = ()
    instead: tuple[str, ...] = ()


def attachment_warnings(dae: Dae, mechanism: Mechanism) -> tuple[Diagnostic, ...]:
    """Warnings of what a user may not have meant, though the equations fit."""
    groups = find_floating(dae, mechanism)
    unmeant = [group for group in groups if not _is_flown(dae, mechanism, group)]
    floating = [_floats(dae, mechanism, group) for group in unmeant]
    spare = spare_ground(dae, mechanism)
    if len(floating) == len(spare) == 1 and _STANDING in str(floating[0].hint):
        floating = [_on(floating[0], spare[0])]
    return (*floating, *idle_parts(dae, mechanism))


def _on(loose: Diagnostic, ground: Part) -> Diagnostic:
    """The warning about loose parts, where one part on the ground carries nothing."""
    note = carries_nothing(ground)
    hint = str(loose.hint).replace(_STANDING, f"`{ground.name}`")
    return replace(loose, hint=hint, related=(Related(note.message, note.span),))


def attachment_error(dae: Dae, mechanism: Mechanism) -> Diagnostic | None:
    """The reason in the mechanism why equations do not fit, if parts float that have joints."""
    joints = {joint.name for joint in mechanism.joints}
    for group in find_floating(dae, mechanism):
        if joints.intersection(group.components):
            return _unheld(dae, mechanism, group, joints, Severity.ERROR)
    return None


def find_floating(dae: Dae, mechanism: Mechanism) -> tuple[Group, ...]:
    """The groups that no connection joins to the ground, in the order of the model."""
    frames = find_frames(v.name for v in dae.variables)
    sets = DisjointSets(("", *frames))
    known = frozenset(frames)
    connections = [tuple(c for c in names if c in known) for names in dae.connections]
    held = ("", *mechanism.links[0].frames, *_on_ground(mechanism))
    # Frames inside of one component of the model belong together, connected or not.
    sensors = find_sensors(dae, frames)
    carrying = [f for f in frames if owner(f) not in sensors]
    inside = (*grouped(carrying, owner).values(), *grouped(carrying, top).values())
    for together in (*inside, *connections, held):
        for other in together[1:]:
            sets.join(together[0], other)
    loose = (frame for frame in frames if sets.find(frame) != sets.find(""))
    groups = grouped(loose, sets.find)
    if not groups:
        return ()
    connected = {f for names in connections for f in names if not is_open(f, names)}
    moving = find_moving(dae)
    found = []
    for group in groups.values():
        components = tuple(dict.fromkeys(owner(f) for f in group if owner(f) not in sensors))
        if moving.intersection(components):
            ends = tuple(f for f in group if f not in connected and owner(f) not in sensors)
            beside = tuple(dict.fromkeys(owner(f) for f in group if owner(f) in sensors))
            instead = _instead(dae, frozenset(group), {s: sensors[s] for s in beside})
            found.append(Group(components, ends, beside, instead))
    return tuple(found)


def _instead(
    dae: Dae, group: frozenset[str], sensors: Mapping[str, Sequence[str]]
) -> tuple[str, ...]:
    """The frames that one of the sensors keeps apart, of which one is in the group."""
    for sensor, ends in sensors.items():
        at: dict[bool, list[str]] = {}  # by whether it is in the group
        for names in dae.connections:
            if not {*ends}.isdisjoint(names):
                near = (n for n in names if owner(n) not in sensors and n.count(".") == 1)
                at.setdefault(not group.isdisjoint(names), []).extend(near)
        if at.get(True) and at.get(False):
            return at[True][0], at[False][0], sensor
    return ()


def is_open(frame: str, connected: Iterable[str]) -> bool:
    """Whether a frame is connected to nothing outside of its component."""
    inside = f"{owner(frame)}."
    return all(name.startswith(inside) for name in connected)


def open_apart(dae: Dae, mechanism: Mechanism) -> str | None:
    """The first frame of the model's parts without ground to which nothing is connected."""
    groups = (group for group in find_floating(dae, mechanism) if not group.instead)
    return next((f for group in groups for f in group.open if f.count(".") == 1), None)


def _on_ground(mechanism: Mechanism) -> Iterator[str]:
    """The frames of joints with one frame, which join it to the ground, as a wheel that rolls."""
    for joint in mechanism.joints:
        if GROUND in joint.links and len(joint.frames) == 1:
            yield from joint.frames


def _is_flown(dae: Dae, mechanism: Mechanism, group: Group) -> bool:
    """True where start values are written for what flies or held, or its coordinates are to be
    states; those of a joint say how it begins, and not where."""
    meant = (
        v
        for v in dae.variables
        if v.start_written or v.fixed_written or v.state_select is StateSelect.ALWAYS
    )
    joints = {joint.name for joint in mechanism.joints if joint.conditions}
    return not ({v.component for v in meant} - joints).isdisjoint(group.components)


def _floats(dae: Dae, mechanism: Mechanism, group: Group) -> Diagnostic:
    if len({top(c) for c in group.components}) > 1:
        return _unheld(dae, mechanism, group, set(group.components), Severity.WARNING)
    name = top(group.components[0])
    if not name:
        return _flies_alone(dae)
    held = f"nothing is connected to `{name}`"
    if group.sensors:
        held = hang([name], group)
    return Diagnostic(
        "S320",
        f"{held}: it falls freely beside the mechanism",
        place(dae, top(group.sensors[0]) if group.instead else name),
        Severity.WARNING,
        hint=f"{replacing(group) or 'connect it'}; if it is meant to fly freely, write "
        "start values for it",
    )


def _flies_alone(dae: Dae) -> Diagnostic:
    """The warning about a part that is run by itself, and not as one of a model."""
    return Diagnostic(
        "S320",
        f"nothing holds `{dae.name}`: it falls freely",
        None,
        Severity.WARNING,
        hint="run a model in which it is a part that is connected; if it is meant to fly freely, "
        "write start values for it",
    )


def hang(names: Sequence[str], group: Group) -> str:
    """The sentence about parts that hang on sensors alone."""
    sensors = list(dict.fromkeys(map(top, group.sensors)))
    hold = "are sensors and hold" if len(sensors) > 1 else "is a sensor and holds"
    return (
        f"{shortened([f'`{n}`' for n in names], _SHOWN)} {'hang' if len(names) > 1 else 'hangs'} "
        f"on {listed(f'`{n}`' for n in sensors)} alone, which {hold} nothing"
    )


def replacing(group: Group) -> str:
    """What to connect in the place of a sensor; nothing where no sensor stands in series."""
    if not group.instead:
        return ""
    near, far, sensor = group.instead
    return f"connect `{near}` to `{far}`, and `{top(sensor)}` beside them"


def _unheld(
    dae: Dae, mechanism: Mechanism, group: Group, joints: Iterable[str], severity: Severity
) -> Diagnostic:
    known = set(joints)
    open_ones = [f for f in group.open if f.count(".") == 1] or list(group.open)
    ends = [f for f in open_ones if owner(f) in known] or open_ones
    components = [c for c in group.components if c]  # connectors of the model are in none
    names = tuple(dict.fromkeys(map(top, components)))
    parts = shortened([f"`{n}`" for n in names], _SHOWN)
    message = f"nothing joins {parts} to the ground"
    hinged = {j.name for j in mechanism.joints}.intersection(map(owner, ends))
    beside = () if hinged else _open_beside(dae, mechanism, group)
    if beside:
        to = f"`{ends[0]}`" if ends else "one of them" if len(names) > 1 else parts
        hint = f"connect `{beside[0]}` to {to}"
        message += f", and `{beside[0]}` is connected to nothing"
        return Loose("S321", message, place(dae, top(beside[0])), severity, hint=hint)
    if ends:
        shown = shortened([f"`{f}`" for f in ends], _SHOWN)
        message += f": {shown} {be(len(ends))} connected to nothing"
    first = (ends or components)[0]
    hint = f"connect `{first}` to {_STANDING}"
    if severity is Severity.WARNING and not hinged:
        hint += "; if all are meant to fly freely, write start values for one of the bodies"
    if group.instead:
        first, message, hint = group.sensors[0], hang(names, group), replacing(group)
    span = place(dae, top(first))
    return Loose("S321", message, span, severity, hint=hint, open=group.open)


def _open_beside(dae: Dae, mechanism: Mechanism, group: Group) -> tuple[str, ...]:
    """The frames of the model's other joints to which nothing is connected."""
    connected = {f for names in dae.connections for f in names if not is_open(f, names)}
    others = (j for j in mechanism.joints if j.name not in group.components)
    frames = (f for joint in others for f in joint.frames if f.count(".") == 1)
    return tuple(f for f in frames if f not in connected)


def locked(dae: Dae, mechanism: Mechanism) -> Locked | None:
    """The warning for where nothing moves, which by count is so: perhaps a joint is missing
    where parts are connected without one. Redundant joints may hold what moves all the same.
    A note where the model asks for no motion, as that of a truss."""
    if mechanism.mobility != 0 or not mechanism.joints:
        return None
    from planarc.insight.facts import count_text

    welds = _welds(dae, mechanism)
    hint = "a structure is meant, or a joint is missing"
    couplings = [top(j.name) for j in mechanism.joints if j.conditions == 1]
    if 1 < len(couplings) <= _SHOWN and not any(link.free == 2 for link in mechanism.links):
        hint = f"leave out one of {listed(f'`{name}`' for name in couplings)}, each of which takes "
        hint += "one motion away, unless a structure is meant"
    rigid = _rigid_loop(dae, mechanism)
    if rigid:
        hint = f"{listed(f'`{name}`' for name in rigid)} close a loop of three joints, which is "
        hint += "rigid: put a fourth joint between two of its parts, unless a structure is meant"
    if welds:
        wheels = [a for pair in welds for a in pair if top(a) in _rolling(dae)]
        pairs = "them" if len(welds) == 1 else "each pair" if len(wheels) > 1 else "one pair"
        hint = f"put a joint between {pairs}, "
        if rigid:
            hint += f"or a fourth one into the loop of {listed(f'`{name}`' for name in rigid)}, "
        hint += "unless a structure is meant"
    pair = _pair(mechanism)
    fastened = () if pair or welds else tuple(_fastened(dae, mechanism, rigid))
    if len(fastened) == 1:
        ((fixed, _),) = fastened
        hint = f"{listed(f'`{name}`' for name in rigid)} close a loop of three joints, which is "
        hint += f"rigid: put a fourth one between {fixed}, unless a structure is meant"
    pins = find_pins(dae, mechanism)
    # A slide between two moving parts is there to move them.
    actuated = any(GROUND not in j.links and j.name not in pins for j in mechanism.joints)
    asked = actuated or any(v.fixed for v in dae.variables) or changes(dae)
    standing = not (pair or welds or asked)
    if standing:
        hint = "if it is no structure, a joint is missing"
    if pair:
        hint = f"{both(pair)} join the same two parts, which holds these together: leave one of "
        hint += "the two out, or put a joint between parts that are connected without one"
    return (RigidLoop if rigid and not (standing or pair or welds) else Locked)(
        "S322",
        f"nothing can move: {count_text(mechanism)}",
        place(dae, top((*pair[1:], *(w[0] for w in welds), mechanism.joints[-1].name)[0])),
        Severity.NOTE if standing else Severity.WARNING,
        hint=hint,
        related=(
            *(
                Related(f"`{a}` and `{b}` are connected without a joint", _connected_at(dae, a, b))
                for a, b in (() if pair else welds[:3])
            ),
            *(Related(f"{two} are fastened to each other here", span) for two, span in fastened),
        ),
    )


def _connected_at(dae: Dae, one: str, two: str) -> Span | None:
    """Where the user connects two frames, else where the second one's part is declared."""
    here = (c.span for c in dae.connects if {c.left, c.right} == {one, two})
    return next((s for s in here if is_own(dae, s)), place(dae, top(two)))


def _rolling(dae: Dae) -> set[str]:
    """The wheels that roll on the ground without a joint of their own."""
    return {p.name for p in dae.parts if p.class_name.endswith(ROLLING)}


def _fastened(dae: Dae, mechanism: Mechanism, loop: Sequence[str]) -> Iterator[tuple[str, Span]]:
    """Two parts with mass that are one link of a loop of three joints, and where they are
    connected."""
    near = {i for j in mechanism.joints if top(j.name) in loop for i in j.links} - {GROUND}
    frames = {f for i in near for f in mechanism.links[i].frames}
    heavy = find_moving(dae) - {*find_elements(dae), *(j.name for j in mechanism.joints)}
    for connect in dae.connects:
        ends = connect.left, connect.right
        masses = [any(top(m) == owner(n) for m in heavy) for n in ends]
        if is_own(dae, connect.span) and all(masses) and frames.issuperset(ends):
            yield both(map(owner, ends)), connect.span


def changes(dae: Dae) -> bool:
    """Whether something in the equations changes though nothing moves freely."""
    return any(
        e.op in _CHANGING for e in postorder(s for q in dae.equations for s in (q.left, q.right))
    )


def _pair(mechanism: Mechanism) -> tuple[str, ...]:
    """Two joints between the same two moving parts, if there are such."""
    seen: dict[frozenset[int], str] = {}
    for joint in mechanism.joints:
        links = frozenset(joint.links)
        if joint.conditions == 2 and len(links) == 2 and GROUND not in links:
            if links in seen:
                return top(seen[links]), top(joint.name)
            seen[links] = joint.name
    return ()


def _rigid_loop(dae: Dae, mechanism: Mechanism) -> tuple[str, ...]:
    """Three joints that close a loop, if there are such. A wheel may roll along a slide."""
    rolling = _rolling(dae)
    plain = [j for j in mechanism.joints if j.conditions == 2 and len(j.links) == 2]
    plain = [j for j in plain if top(j.name) not in rolling]
    first = next(triangles(plain), ())
    return tuple(top(joint.name) for joint in first)


def _welds(dae: Dae, mechanism: Mechanism) -> list[tuple[str, str]]:
    """Frames of two rigid parts that are connected directly."""
    ends: dict[str, int] = {}
    link_of: dict[str, int] = {}
    for number, link in enumerate(mechanism.links[1:], 1):
        for frame in link.frames:
            link_of[frame] = number
            ends[owner(frame)] = ends.get(owner(frame), 0) + 1
    joints = {joint.name for joint in mechanism.joints}
    rolling = {top(name) for name in joints if "." in name}  # as a wheel, which has one frame
    found = []
    for names in dae.connections:
        if any(owner(n) in joints and n.count(".") == 1 for n in names):
            continue  # parts that meet in a joint are meant to
        rigid = [
            n
            for n in names
            if n in link_of and (ends[owner(n)] > 1 or n.partition(".")[0] in rolling)
        ]
        rigid.sort(key=lambda n: -n.count("."))  # as the user connected them, last
        tops = {top(n): n for n in rigid if owner(n) not in joints}
        if len(tops) > 1:
            first, second = list(tops.values())[:2]
            found.append((first, second))
    return found


def place(dae: Dae, name: str) -> Span | None:
    """The place where a component of the model is declared."""
    return next((p.span for p in dae.parts if p.name == name and p.span is not NOWHERE), None)
