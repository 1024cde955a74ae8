"""Parts that are held though they seem to be free, and bars of which one end holds all joints.

In:   SortedDae, Mechanism
Out:  warning S322, or S323 for a bar

A block of constraints that leaves no coordinate free, and in which neither time nor a state nor
what changes at events appears, has one solution for ever: what it determines is held. Its
derivatives are in the model, so that somebody wanted to know how it moves.

Example: two gears of different ratios between the same two shafts. Their equations
`a.phi = 2*b.phi` and `a.phi = 3*b.phi` hold both shafts at angle 0.

A bar in a loop gives it its length by having one pin of it at each end. With both pins at one end,
and nothing at the other, the loop has another shape than was meant: it may not close, or its other
parts may stand still.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from itertools import combinations

from msgspec.structs import replace

from planarc.core.diagnostic import Bound, Locked, Related, Severity
from planarc.core.prose import both, counted, listed
from planarc.core.unit import LOADS
from planarc.insight.attachment import ROLLING
from planarc.insight.connectors import find_pins, grouped, top
from planarc.insight.sensors import zeros
from planarc.insight.topology import find_moving
from planarc.ir.dae import Dae
from planarc.ir.expr import Op, below, symbol_text
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import is_own, own_names, own_part, owner
from planarc.ir.sorted import Assignment, Block, Residual, SortedDae, Step, computed


def find_held(model: SortedDae) -> Locked | None:
    """The warning about the first parts that are held; None where all that has mass may move."""
    height = max((level.height for level in model.levels), default=0)
    if height < 2:
        return None
    still = {(p.name, 0) for p in model.dae.parameters}  # names and orders
    resting = _resting(model)
    blocks: list[Block] = []
    loose: set[tuple[str, int]] = set()
    for step in (s for level in model.levels if level.height == height for s in level.steps):
        own = {symbol.data for symbol in computed(step)}
        if step.free > len(own & resting) or _used(step).difference(own, still):
            loose |= own
            continue
        still |= own
        if isinstance(step, Block) and step.tears:
            blocks.append(step)
    names = {symbol_text(*symbol) for symbol in loose} if blocks else set[str]()
    return next(filter(None, (_told(model, block, names) for block in blocks)), None)


def _resting(model: SortedDae) -> set[object]:
    """Unknowns that the start decides and nothing moves, as how the teeth of two wheels stand:
    their derivatives are 0."""
    steps = (s for level in model.levels for s in level.steps if isinstance(s, Assignment))
    zero = model.dae.table.zero
    moved = (s.target.data for s in steps if s.value is zero and s.target.op is Op.SYMBOL)
    return {(name, order - 1) for name, order in moved if order}


def find_doubled(dae: Dae, mechanism: Mechanism) -> Locked | None:
    """The warning about a bar with two joints of a loop at one end, and nothing at the other."""
    joints = {joint.name for joint in mechanism.joints}
    joined: dict[str, list[tuple[str, list[str]]]] = {}  # part -> its frame, what is joined to it
    pins, own = find_pins(dae, mechanism), [c for c in dae.connects if is_own(dae, c.span)]
    for names in dae.connections:
        for name in names:
            others = [owner(n) for n in names if top(n) != top(name)]
            if others and name.count(".") == 1:
                joined.setdefault(top(name), []).append((name, others))
    for link in mechanism.links[1:]:
        owners = Counter(owner(f) for f in link.frames)
        for part, frames in grouped((f for f in link.frames if f.count(".") == 1), top).items():
            ends = joined.get(part, [])
            if part in joints or len(frames) != 2 or len(ends) != 1:
                continue
            ((end, others),) = ends
            at_end = [n for n in dict.fromkeys(others) if n in pins]
            found = next((p for p in combinations(at_end, 2) if _in_one_loop(mechanism, p)), None)
            free = next(f for f in frames if f != end)
            if found is not None:
                return _doubled(dae, part, end, free, found)
            if len(at_end) != 2 or any(
                {owner(c.left), owner(c.right)} == {*at_end} for c in dae.connects
            ):
                continue
            onward = next((j for j in at_end if f"{j}.frame_a" in _there(dae, end)), at_end[1])
            rods = [o for o in others if o not in joints and owners[o] > 1]
            meant = not rods or any({c.left, c.right} == {end, f"{onward}.frame_a"} for c in own)
            if meant and not _turns_wheel(dae, mechanism, onward):
                return _at_near_end(dae, part, end, free, (at_end[0], at_end[1]), onward)
    return None


def _there(dae: Dae, frame: str) -> tuple[str, ...]:
    """The frames that are one with it."""
    return next(names for names in dae.connections if frame in names)


def _turns_wheel(dae: Dae, mechanism: Mechanism, joint: str) -> bool:
    """Whether a drive turns nothing but bodies on the axis by a joint, as a flywheel."""
    flange = f"{joint}.axis"
    if not any(flange in names and len(names) > 1 for names in dae.connections):
        return False
    links = next(j.links for j in mechanism.joints if j.name == joint)
    owners = Counter(owner(f) for f in mechanism.links[max(links)].frames)
    return max(owners.values(), default=0) < 2  # no bar


def find_held_angle(dae: Dae, mechanism: Mechanism) -> Locked | None:
    """The warning about a hinge on the ground that turns a part whose own equation says its angle:
    a point mass with `fixAngle = true`."""
    pins, said = find_pins(dae, mechanism), zeros(dae)
    for joint in mechanism.joints:
        if joint.name not in pins or GROUND not in joint.links or len(joint.links) != 2:
            continue
        frames = mechanism.links[joint.links[1]].frames
        holder = next((owner(f) for f in frames if f"{f}.phi" in said), None)
        part = None if holder is None else own_part(dae, holder)
        if part is None or own_part(dae, joint.name) is None:
            continue
        flag = f"{part.name}.fixAngle" in {p.name for p in dae.parameters}
        loose = f"leave {'`fixAngle=true`' if flag else 'that'} out of `{part.name}`"
        return Locked(
            "S322",
            f"`{joint.name}` cannot turn: an equation of `{part.name}` says that its angle is 0",
            part.span,
            Severity.WARNING,
            hint=f"{loose}, and give it an inertia as a `Parts.Body` where it is to turn",
        )
    return None


def find_rigid_loop(dae: Dae, mechanism: Mechanism) -> Locked | None:
    """The warning about a slide in a loop of moving parts whose joints leave no motion among them:
    mostly both its ends are on one part. Loops through the ground may be supports, and those of
    pins alone may be trusses."""
    pins = find_pins(dae, mechanism)
    for joint in mechanism.joints:
        if joint.conditions != _PAIR or joint.name in pins:
            continue
        loop = mechanism.shortest_loop(joint, paired=True)
        part = own_part(dae, joint.name)
        if not loop or part is None:
            continue
        links = {i for other in loop for i in other.links}
        free = sum(mechanism.links[i].free for i in links) - _PLANE
        if GROUND in links or not any(other.name in pins for other in loop):
            continue
        if sum(other.conditions for other in loop) < free:
            continue
        closed = [f"`{name}`" for name in own_names(dae, (other.name for other in loop))]
        return Locked(
            "S322",
            f"`{part.name}` cannot move: {listed(closed)} close a loop of "
            f"{counted(len(loop), 'joint')}, which is rigid",
            part.span,
            Severity.WARNING,
            hint="connect one end of it to another part, or put a joint more into the loop",
        )
    return None


_PAIR = 2  # conditions of a pin or a slide
_PLANE = 3  # motions of a body in the plane


def _in_one_loop(mechanism: Mechanism, names: tuple[str, str]) -> bool:
    first, second = (next(j for j in mechanism.joints if j.name == n) for n in names)
    return second in mechanism.shortest_loop(first, paired=True)


def _doubled(dae: Dae, part: str, end: str, free: str, joints: tuple[str, str]) -> Locked:
    message = (
        f"{both(joints)} are both connected to `{end}`, and nothing to `{free}`: "
        f"`{part}` gives its loop no length"
    )
    return _told_at(dae, part, message, f"connect one of them to `{free}`")


def _at_near_end(
    dae: Dae, part: str, end: str, free: str, joints: tuple[str, str], onward: str
) -> Locked:
    message = (
        f"nothing is connected to `{free}`, and {both(joints)} turn about the same point: `{end}`"
    )
    hint = f"connect `{onward}` to `{free}`, where `{part}` is to carry it; if both are to turn "
    hint += f"about one pin, connect them to each other, and `{part}` to one of them"
    here = [c for c in dae.connects if end in (c.left, c.right) and is_own(dae, c.span)]
    others = {c.right if c.left == end else c.left: c for c in here}
    hung = {f: c for f, c in others.items() if owner(f) not in joints}
    if len(hung) == 1:  # on whose frame the joint hangs
        ((frame, connect),) = hung.items()
        hint = f"write `connect({free}, {frame});`, so that `{part}` carries what is there"
        there = Related(f"`{owner(frame)}` is connected here", connect.span)
        return replace(_told_at(dae, part, message, hint), related=(there,))
    return _told_at(dae, part, message, hint)


def _told_at(dae: Dae, part: str, message: str, hint: str) -> Locked:
    own = own_part(dae, part)
    place = own.span if own else dae.span
    return Locked("S323", message, place, Severity.WARNING, hint=hint)


def _used(step: Step) -> set[object]:
    """What the formulas of a step hold: names and orders of symbols, and what is no symbol."""
    values = (*(a.value for a in step.inner), *(r.value for r in step.residuals))
    return {e.data for e in below(values) if not e.args and e.op is not Op.CONST}


def _told(model: SortedDae, block: Block, loose: Collection[str]) -> Locked | None:
    """None where what the block holds may move otherwise: a body that cannot turn, but slide."""
    dae, known = model.dae, {repr(symbol) for symbol in computed(block)}
    steps: tuple[Assignment | Residual, ...] = (*block.inner, *block.residuals)
    if any(v.unit in LOADS and v.name in known for v in dae.variables):
        return None  # loads decide where it is, and no length
    holders = own_names(dae, (model.equations[s.equation].equation.component for s in steps))
    aliases = (a.name for a in model.aliases if repr(a.target) in known)
    moving = find_moving(dae)
    owners = dict.fromkeys(owner(name) for name in (*known, *aliases))
    free = {owner(n) for n in loose} | {
        owner(a.name) for a in model.aliases if repr(a.target) in loose
    }
    found = moving & owners.keys() - free
    held = [n for n in own_names(dae, sorted(found)) if n not in holders]
    if not holders:  # no part of the user's
        return None
    if not held:
        return _hold_each_other(dae, own_names(dae, sorted(found)))
    part = own_part(dae, holders[-1])
    several, by = len(holders) > 1, listed(f"`{n}`" for n in holders)
    what = listed(f"`{n}`" for n in held)
    hint = f"leave {'one of them' if several else 'it'} out, or put something elastic between"
    return Bound(
        "S322",
        f"{what} cannot move: {by} {'hold' if several else 'holds'} all coordinates",
        part.span if part else dae.span,
        Severity.WARNING,
        hint=f"{hint}, unless a structure is meant",
    )


def _hold_each_other(dae: Dae, names: Sequence[str]) -> Locked | None:
    """The warning about parts that are held by what they say themselves, as two wheels that roll
    and are fixed to one chassis."""
    rolling = {p.name for p in dae.parts if p.class_name.endswith(ROLLING)}
    wheels = [n for n in names if n in rolling]
    part = own_part(dae, wheels[0]) if wheels else None
    if part is None:
        return None
    return Bound(
        "S322",
        f"{listed(f'`{n}`' for n in names)} cannot move: they hold each other",
        part.span,
        Severity.WARNING,
        hint=_hinge_between(dae, wheels),
    )


def _hinge_between(dae: Dae, wheels: Sequence[str]) -> str:
    """Where a hinge is missing, beside wheels that have one."""
    pins = {p.name for p in dae.parts if p.class_name.endswith(".Revolute")}
    fixed: dict[str, list[str]] = {}
    for c in dae.connects:
        for wheel, other in ((owner(c.left), owner(c.right)), (owner(c.right), owner(c.left))):
            if wheel in wheels:
                fixed.setdefault(wheel, []).append(other)
    bare = [w for w, others in fixed.items() if pins.isdisjoint(others)]
    if len(bare) == 1:
        return f"put a hinge between `{bare[0]}` and `{fixed[bare[0]][0]}`"
    return "put a hinge between each wheel and what it carries"
