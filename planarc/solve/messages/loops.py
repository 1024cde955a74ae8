"""The parts of a closed loop, as the user knows them: bars first, then the joints between them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import combinations

from planarc.core.prose import both, listed
from planarc.ir.kernel import Kernel
from planarc.ir.mechanism import GROUND, POSITIONS, Joint, Link
from planarc.ir.once import once
from planarc.ir.places import own_names, owner
from planarc.ir.program import Program
from planarc.solve.messages import trouble

#: The part of the longest by which bars may differ from what reaches.
_IN_LINE = 1e-5
#: Places nearer than this, in m, are one.
_SAME = 1e-9


def loop_names(program: Program, components: Sequence[str]) -> str:
    """The loops through these components, in words; only these where they are in none."""
    mechanism, joints = program.mechanism, loop_joints(program, components)
    if mechanism is None or not joints:
        return trouble.names(own_names(program, components))
    names = own_names(program, (j.name for j in joints))
    links = {i for j in joints for i in j.links} - {GROUND}
    ends = {f for j in joints for f in j.frames}
    within = (_between(program, mechanism.links[i], ends) for i in sorted(links))
    bars = list(dict.fromkeys(b for of_link in within for b in of_link))
    bars = [b for b in bars if b not in names]
    if not bars:
        return trouble.names(names)
    kind = "joint" if len(names) == 1 else "joints"
    return f"{trouble.names(bars)} ({kind} {trouble.names(names)})"


def _between(program: Program, link: Link, ends: Collection[str]) -> list[str]:
    """The user's bars of a link that lead from end to end, and none that only sticks out; all of
    them where that is not known."""
    points, ways = _points(program), dict[str, set[int]]()
    at = {f: points[x] for f in link.frames if (x := f"{f}.r[1]") in points}
    for bar in _bars(link):
        for name in own_names(program, [bar]):
            ways.setdefault(name, set()).update(at[f] for f in at if owner(f) == bar)
    fixed, kept = {at[f] for f in ends if f in at}, dict(ways)
    while True:
        there = Counter(point for way in kept.values() for point in way)
        out = [b for b, way in kept.items() if sum(there[p] > 1 or p in fixed for p in way) < 2]
        if not out:
            return list(kept or ways)
        for bar in out:
            del kept[bar]


@once
def _points(program: Program) -> dict[str, int]:
    """The slots of the places of frames: connected ones have one."""
    return {c.name: c.slot for c in program.columns if c.name.endswith(".r[1]")}


def loop_joints(program: Program, components: Collection[str]) -> list[Joint]:
    """The joints of the loops through these components, some of them twice."""
    mechanism = program.mechanism
    if mechanism is None:
        return []
    own = (joint for joint in mechanism.joints if joint.name in components)
    return [other for joint in own for other in mechanism.shortest_loop(joint)]


def joints_of(program: Program, components: Collection[str]) -> list[str]:
    """The joints of the links that have frames in some components."""
    return program.mechanism.joints_at(components) if program.mechanism else []


def given_in_loop(
    program: Program,
    kernel: Kernel,
    components: Collection[str],
    coordinates: Collection[str] = POSITIONS,
) -> str:
    """The coordinates of a loop's joints that others than it decide, with their values; e.g.
    "`crank.phi` = 3.1, which `ramp` gives"."""
    joints = [joint.name for joint in loop_joints(program, components)]
    return given_of(program, kernel, joints, coordinates)


def given_of(
    program: Program, kernel: Kernel, joints: Collection[str], coordinates: Collection[str]
) -> str:
    """The coordinates of some joints that others than these decide, in the same words."""
    solved = {c.slot for c in program.candidates}
    told = []
    for column in program.columns:
        name = column.name
        joint, _, coordinate = name.rpartition(".")
        if joint not in joints or coordinate not in coordinates:
            continue
        giver = None if column.slot in solved else trouble.determining(program, kernel, column.slot)
        own = [] if giver is None else own_names(program, [giver.component])
        if own and own[0] and own[0] not in own_names(program, joints):
            value = column.sign * float(kernel.w[column.slot])
            told.append(f"`{name}` = {value:.4g}, which `{own[0]}` gives")
    return listed(told)


def lengths_in_loop(
    program: Program, kernel: Kernel, components: Collection[str]
) -> dict[str, float]:
    """How far a loop's bars, and joints that are bars, reach at the workspace's point, in metres:
    from joint to joint."""
    mechanism, joints = program.mechanism, loop_joints(program, components)
    at = {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}
    frames = {frame for joint in joints for frame in joint.frames}
    names = own_names(program, (joint.name for joint in joints))
    reaching: dict[str, Iterable[str]] = {j.name: j.frames for j in joints if j.count > 1}
    for link in mechanism.links[1:] if mechanism else ():
        bars = [b for b in own_names(program, _bars(link)) if b not in names]
        reaching |= {b: frames.intersection(link.frames) for b in bars[:1]}
    found: dict[str, float] = {}
    for name, ends in reaching.items():
        known = (f for f in ends if f"{f}.r[2]" in at)
        points = [(at[f"{f}.r[1]"], at[f"{f}.r[2]"]) for f in known]
        length = max((math.dist(*pair) for pair in combinations(points, 2)), default=0.0)
        if length > 0:
            found[name] = length
    return found


def too_far_apart(
    program: Program,
    kernel: Kernel,
    components: Collection[str],
    open_at: str,
    gap: Sequence[float],
) -> tuple[str, str]:
    """A sentence about the longest bar of a loop of pins, or its bearings on the ground, where all
    other bars together do not reach from one end to the other, and the name of that bar, or of
    another one that is shorter than its inertia suits; empty where they do, or where a link is
    more than one bar.

    The workspace is where the loop is nearly as closed as can be; the bar that is `open_at` is seen
    longer or shorter by the `gap`, in m along both axes.
    """
    mechanism = program.mechanism
    joints = list({j.name: j for j in loop_joints(program, components)}.values())
    at = {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}
    if mechanism is None or not all(_is_pin(j, at) for j in joints):
        return "", ""
    lengths: dict[str, float] = {}
    for number in {i for j in joints for i in j.links}:
        link = mechanism.links[number]
        ends = {f for j in joints for f in j.frames if f in link.frames}
        bars = own_names(program, _bars(link))
        if number != GROUND and len(bars) > 1:  # a rod that carries others
            bars = [b for b in bars if _reaches(b, link, ends, at)]
        frames = [f for f in link.frames if bars and f.rpartition(".")[0] == bars[0]]
        if number == GROUND:
            frames = _bearings(link, ends, at, {j.name for j in mechanism.joints})
            bars = own_names(program, (f.rpartition(".")[0] for f in frames))
        known = [(at[f"{f}.r[1]"], at[f"{f}.r[2]"]) for f in frames if f"{f}.r[2]" in at]
        if len(known) != 2 or len(ends) != 2 or (number != GROUND and len(bars) != 1):
            return "", ""
        (x, y), (u, v) = known
        dx, dy = gap[:2] if bars == [open_at] and len(gap) > 1 else (0.0, 0.0)
        lengths[both(bars)] = min(math.hypot(u - x - s * dx, v - y - s * dy) for s in (1, -1))
    longest = max(lengths, key=lambda name: lengths[name], default="")
    others = [name for name in lengths if name != longest]
    length, reach = lengths.get(longest, 0.0), sum(lengths[name] for name in others)
    if not others or length <= reach * (1 + _IN_LINE):
        return "", ""
    verb, what = ("are", "apart") if " and " in longest else ("is", "long")
    along = [f"the way from {o.replace(' and ', ' to ')}" if " and " in o else o for o in others]
    along = [f"{a} ({lengths[o]:.4g} m)" for a, o in zip(along, others, strict=True)]
    told = f"{longest} {verb} {length:.4g} m {what}, and {listed(along)} together {reach:.4g} m"
    for bar in (o.strip("`") for o in others):
        if _radius_of_gyration(program, kernel, bar) > lengths[f"`{bar}`"]:
            return f"{told}; the inertia of `{bar}` suits a longer one", bar
    return told, longest.strip("`")


def _radius_of_gyration(program: Program, kernel: Kernel, body: str) -> float:
    """That of a body with mass and inertia, in m; 0 where there is none."""
    slots = {p.name: p.slot for p in program.parameter_slots}
    if not slots.keys() >= {f"{body}.m", f"{body}.I"}:
        return 0.0
    m, inertia = (float(kernel.w[slots[f"{body}.{n}"]]) for n in ("m", "I"))
    return math.sqrt(max(inertia, 0.0) / m) if m > 0 else 0.0


def _reaches(bar: str, link: Link, ends: Collection[str], at: Mapping[str, float]) -> bool:
    """Whether the two frames of a part are where the ends of joints on its link are."""

    def places(frames: Iterable[str]) -> list[tuple[float, float]]:
        known = (f for f in frames if f"{f}.r[2]" in at)
        return sorted((at[f"{f}.r[1]"], at[f"{f}.r[2]"]) for f in known)

    own = places(f for f in link.frames if f.rpartition(".")[0] == bar)
    there = places(ends)
    pairs = zip(own, there, strict=False)
    return len(own) == len(there) == 2 and all(math.dist(*pair) < _SAME for pair in pairs)


def _is_pin(joint: Joint, columns: Collection[str]) -> bool:
    """Whether a joint holds two points together and lets them turn."""
    plain = joint.conditions == 2 and joint.count == 1 and len(joint.frames) == 2
    return plain and f"{joint.name}.phi" in columns and f"{joint.name}.s" not in columns


def _bearings(
    ground: Link, ends: Collection[str], at: Mapping[str, float], joints: Collection[str]
) -> list[str]:
    """The frames of parts on the ground that stand where the ends of joints do."""
    fixed = [f for f in ground.frames if f.rpartition(".")[0] not in joints and f"{f}.r[2]" in at]
    parts = sorted(fixed, key=lambda f: f == "world.frame_b")  # what the user put there comes first
    found = []
    for end in sorted(ends):
        here = at.get(f"{end}.r[1]", math.nan), at.get(f"{end}.r[2]", math.nan)
        near = (f for f in parts if math.dist(here, (at[f"{f}.r[1]"], at[f"{f}.r[2]"])) < 1e-9)
        found.extend([f for f in near if f not in found][:1])
    return found


def bearings_of_loop(program: Program, kernel: Kernel, components: Collection[str]) -> list[str]:
    """The user's parts on the ground on which a loop stands, but for the world."""
    mechanism = program.mechanism
    if mechanism is None:
        return []
    ground = mechanism.links[GROUND]
    at = {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}
    joints = loop_joints(program, components)
    ends = {f for j in joints for f in j.frames if f in ground.frames}
    found = _bearings(ground, ends, at, {j.name for j in mechanism.joints})
    names = own_names(program, (f.rpartition(".")[0] for f in found))
    inner = {p.name for p in program.parts if p.inner}
    return [name for name in names if name not in inner]


def is_closed(program: Program, components: Collection[str]) -> bool:
    """Whether one of these components is a joint in a closed loop of the mechanism."""
    return bool(loop_joints(program, components))


def _bars(link: Link) -> Iterable[str]:
    """Components with two frames or more of a link: they give it its lengths."""
    owners = Counter(frame.rpartition(".")[0] for frame in link.frames)
    return (owner for owner, frames in owners.items() if frames > 1)
