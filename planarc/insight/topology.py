"""Links and joints of a model, from its equations: no class is known by name.

In:   Dae         equations with the component that each stands in, connection sets
Out:  Mechanism

A frame is a connector with r[2], phi and the flows f[2], t. Frames that are connected are one.
What a component says of its frames is counted: its equations between positions, without forces
and derivatives, less those that give the unknowns of its own in them. Three conditions between
two frames make them one rigid link, three on one frame make it ground; fewer are a joint.

Example: Revolute   frame_b.r = frame_a.r, frame_b.phi = frame_a.phi + phi, tau = 0
                    four equations, the unknowns phi and tau of its own: 2 conditions
         JointRR    d = frame_b.r - frame_a.r, L*L = d*d
                    three equations, two unknowns d: 1 condition
         Spring     d, s, e, f follow from the frames: none, it is no joint

Needs:     equations on position level; a joint that is written with velocities is not seen.
Promises:  links and joints in the order of the model.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import combinations

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.disjoint import DisjointSets
from planarc.insight.connectors import FRAME, find_frames
from planarc.insight.driving import find_passive
from planarc.ir.dae import Dae
from planarc.ir.expr import Op, below
from planarc.ir.mechanism import Joint, Link, Mechanism

_FLOWS, _POTENTIALS = zip(*FRAME, strict=True)
_SYMBOL = Op.SYMBOL  # as in `ir.expr`


class _Relation(Data):
    """An equation between positions: the frames and the other unknowns in it."""

    frames: frozenset[str]
    own: frozenset[str]
    angles: frozenset[str]  # frames whose angle is in it
    only_angle: bool  # it says what an angle is, and nothing else


def find_mechanism(dae: Dae) -> Mechanism | None:
    """The links and joints of a model; None where it has no frames."""
    frames = find_frames(v.name for v in dae.variables)
    if not frames:
        return None
    groups = _relations(dae, frames)
    links = _Links(frames, dae.connections)
    alone = links.alone()
    standing = {f for r in groups.values() for f in _standing(r)}
    for relations in groups.values():
        for pair in combinations(sorted({f for r in relations for f in r.frames}), 2):
            if _conditions(relations, pair) - _BODY * sum(f in standing for f in pair) >= _BODY:
                links.join(pair)
    for frame in (f for f in frames if f in standing):
        links.join((_GROUND, frame))
    found = _mechanism(frames, groups, links, standing, _massive(dae, links.alone()))
    passive = find_passive(dae, [joint.name for joint in found.joints])
    # A force in the axes of the world has a hidden frame there, and one that is connected.
    lonely = frozenset(alone)
    joined = {f.rpartition(".")[0] for f in frames if f not in lonely}
    standing_alone = (f for f in alone if links.root(f) == links.root(_GROUND))
    spare = (o for f in standing_alone if (o := f.rpartition(".")[0]) not in joined)
    held = tuple(f for f in frames if f in standing)
    return replace(found, passive=passive, standing=held, spare=tuple(spare))


def find_moving(dae: Dae) -> frozenset[str]:
    """Components with derivatives in their equations: what has mass, or measures speed."""
    moving: set[str] = set()
    for equation in dae.equations:
        if not (equation.generated or equation.component in moving):  # the former name connectors
            inside = below((equation.left, equation.right))
            if any(e.op is _SYMBOL and e.data[1] for e in inside):
                moving.add(equation.component)
    return frozenset(moving)


def find_derived(dae: Dae) -> frozenset[str]:
    """Variables with derivatives in equations."""
    symbols = (e for q in dae.equations for e in below((q.left, q.right)) if e.op is _SYMBOL)
    return frozenset(e.data[0] for e in symbols if e.data[1])


#: The frame of whatever does not move.
_GROUND = ""
_BODY = 3  # motions of a body in the plane, and the conditions that hold it


class _Links:
    """Frames joined to links (disjoint sets); the ground is one of them."""

    def __init__(self, frames: Sequence[str], connections: Iterable[Sequence[str]]) -> None:
        self._frames = frames
        self._sets = DisjointSets((_GROUND, *frames))
        self.root = self._sets.find
        for connected in connections:
            self.join([c for c in connected if c in self._sets])

    def alone(self) -> list[str]:
        """The frames that are joined to no other."""
        sizes, ground = Counter(map(self.root, self._frames)), self.root(_GROUND)
        return [f for f in self._frames if sizes[self.root(f)] == 1 and self.root(f) != ground]

    def join(self, frames: Sequence[str]) -> None:
        for other in frames[1:]:
            if self.root(other) == self.root(_GROUND):
                self._sets.join(other, frames[0])
            else:
                self._sets.join(frames[0], other)


def _massive(dae: Dae, alone: Sequence[str]) -> frozenset[str]:
    """Frames of bodies among those that nothing is connected to: each is the only one of a
    component that moves by itself, and whose force is more than nothing."""
    moving = find_moving(dae) if alone else ()
    owners = [frame.rpartition(".")[0] for frame in alone]
    single = [f for f, o in zip(alone, owners, strict=True) if o in moving and owners.count(o) == 1]
    flows = {f"{frame}.{flow}": frame for frame in single for flow in _FLOWS}
    found = set()
    for equation in dae.equations if single else ():
        if equation.component in moving and not equation.generated:
            symbols = below((equation.left, equation.right))
            names = {e.data[0] for e in symbols if e.op is _SYMBOL}
            if not names <= flows.keys():
                found |= {flows[n] for n in names if n in flows}
    return frozenset(found)


def _relations(dae: Dae, frames: Sequence[str]) -> Mapping[str, list[_Relation]]:
    """The equations between positions, by component; only of components with frames."""
    owner = {f"{frame}.{v}": frame for frame in frames for v in _POTENTIALS}
    angles = {f"{frame}.phi" for frame in frames}
    flows = {f"{frame}.{v}" for frame in frames for v in _FLOWS}
    unknown = {v.name for v in dae.variables} - _constant(dae)
    groups: dict[str, list[_Relation]] = {}
    for equation in dae.equations:
        if equation.generated:
            continue
        names: set[str] = set()
        for e in below((equation.left, equation.right)):
            if e.op is _SYMBOL:
                name, order = e.data
                if order or name in flows:
                    break
                if name in unknown:
                    names.add(name)
        else:
            relation = _Relation(
                frozenset(owner[n] for n in names if n in owner),
                frozenset(n for n in names if n not in owner),
                frozenset(owner[n] for n in names if n in angles),
                len(names) == 1 and names <= angles,
            )
            groups.setdefault(equation.component, []).append(relation)
    return {c: r for c, r in groups.items() if any(e.frames for e in r)}


def _constant(dae: Dae) -> set[str]:
    """What the start decides for the whole run, `der(p) = 0`: the teeth of a gear, say."""
    zero = (q for q in dae.equations if q.right.op is Op.CONST and not q.right.data)
    left = (q.left for q in zero if q.left.op is _SYMBOL)
    return {name for name, order in (e.data for e in left) if order == 1}


def _conditions(relations: Sequence[_Relation], frames: Iterable[str]) -> int:
    """The number of conditions that tie these frames to each other.

    Those of the equations that are left when each own unknown has taken one, as far as it can:
    the size of a maximum matching (augmenting paths).
    """
    inside = [r for r in relations if r.frames <= set(frames)]
    taken: dict[str, int] = {}
    return sum(not _take(inside, i, taken, set()) for i in range(len(inside)))


def _take(relations: Sequence[_Relation], i: int, taken: dict[str, int], seen: set[str]) -> bool:
    """Whether a relation can take one of its own unknowns; others may take another one for that."""
    for unknown in sorted(relations[i].own - seen):
        seen.add(unknown)
        if unknown not in taken or _take(relations, taken[unknown], taken, seen):
            taken[unknown] = i
            return True
    return False


def _standing(relations: Sequence[_Relation]) -> set[str]:
    """The frames of a component that it holds by itself, whatever its others do."""
    frames = {f for r in relations for f in r.frames}
    return {f for f in frames if _conditions(relations, (f,)) >= _BODY}


def _mechanism(
    frames: Sequence[str],
    groups: Mapping[str, list[_Relation]],
    links: _Links,
    standing: Collection[str],
    massive: Collection[str],
) -> Mechanism:
    order = {frame: i for i, frame in enumerate(frames)}
    ground = links.root(_GROUND)
    members: dict[str, list[str]] = {ground: []}
    for frame in frames:
        members.setdefault(links.root(frame), []).append(frame)
    every = [_held(c, r, order, links, standing, members) for c, r in groups.items()]
    held = [h for h in every if h.conditions > 0 and len(h.roots) > 1]
    # Of two frames of one link, a rigid part gives all three conditions, and a spring none.
    within = [h for h in every if len(h.frames) == 2]
    bridged = (h.component for h in within if -3 < h.conditions < 0)
    inside = (h.component for h in within if h.conditions == -3)
    turned = {
        links.root(f) for r in groups.values() if not _is_angle(r) for e in r for f in e.angles
    }
    jointed = {root for h in held for root in h.roots}
    owners = {f: c for c, relations in groups.items() for r in relations for f in r.frames}
    roots = [
        root
        for root, own in members.items()
        if root == ground
        or root in jointed
        or len({owners.get(f, f) for f in own}) > 1
        or own[0] in massive
        or _is_angle(groups.get(owners.get(own[0], ""), ()))
    ]
    number = {root: i for i, root in enumerate(roots)}
    names = {h.component for h in held}

    def link(root: str) -> Link:
        own = tuple(members[root])
        if root == ground:
            return Link("ground", own, 0)
        return Link(_name(own, names), own, 3 if root in turned else 2)

    def joint(h: _Held) -> Joint:
        ends = tuple(sorted(number[r] for r in h.roots))
        return Joint(h.component, h.conditions, h.count, ends, h.frames)

    return Mechanism(
        tuple(map(link, roots)),
        tuple(map(joint, held)),
        bridged=tuple(bridged),
        inside=tuple(inside),
    )


class _Held(Data):
    """A component that holds links together."""

    component: str
    conditions: int
    count: int  # elementary joints
    roots: tuple[str, ...]
    frames: tuple[str, ...]


def _held(
    component: str,
    relations: Sequence[_Relation],
    order: Mapping[str, int],
    links: _Links,
    standing: Collection[str],
    members: Mapping[str, Sequence[str]],
) -> _Held:
    frames = sorted({f for r in relations for f in r.frames}, key=order.__getitem__)
    conditions = _conditions(relations, frames)
    if len(frames) == 1:
        loose = _is_angle(relations)
        ends = dict.fromkeys((links.root(_GROUND), links.root(frames[0])))
        return _Held(component, 0 if loose else conditions, 1, tuple(ends), tuple(frames))
    stands = {f for f in frames if f in standing}
    if stands:  # that of another component is one end, the ground the other
        frames = [f for f in frames if f not in stands]
        conditions -= _BODY * len(stands)
    if len(frames) > 2:
        # A frame to which nothing is connected follows from the others: it is no link.
        loose_ends = [f for f in frames if len(members[links.root(f)]) == 1]
        for end in loose_ends[: conditions // _BODY]:
            frames.remove(end)
            conditions -= _BODY
    roots = tuple(dict.fromkeys(links.root(f) for f in frames))
    conditions -= _BODY * (len(frames) - len(roots))
    if stands:
        roots = tuple(dict.fromkeys((links.root(_GROUND), *roots)))
    pairs = [_conditions(relations, pair) for pair in combinations(frames, 2)]
    single = [c for c in pairs if 0 < c < 3]
    count = len(single) + (sum(single) < conditions) if len(frames) > 2 else 1
    return _Held(component, conditions, count, roots, tuple(frames))


def _is_angle(relations: Sequence[_Relation]) -> bool:
    """True where a component only says the angle of a point, which has none of its own."""
    said = [r for r in relations if r.frames and not r.own]
    return (
        len(said) == 1 and said[0].only_angle and len({f for r in relations for f in r.frames}) == 1
    )


def _name(frames: Sequence[str], joints: set[str]) -> str:
    """The name of a link: its component with two frames, else any that is no joint."""
    owners = [frame.rpartition(".")[0] for frame in frames]
    count = {o: owners.count(o) for o in owners}
    rigid = [o for o in count if count[o] > 1]
    single = [o for o in count if o not in joints]
    return min(rigid or single or list(count), key=lambda o: (o.count("."), owners.index(o)))
