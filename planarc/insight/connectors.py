"""Connectors through which energy flows, known by what they hold and nothing else.

frame     r[2], phi and the flows f[2], t      of the plane
flange    phi and the flow tau                 of what turns
flange    s and the flow f                     of what slides
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache

from planarc.ir.dae import Dae
from planarc.ir.mechanism import Joint, Mechanism

#: Flow and position; their product, by the rate of the position, is the power that enters.
Pairs = tuple[tuple[str, str], ...]

FRAME: Pairs = (("f[1]", "r[1]"), ("f[2]", "r[2]"), ("t", "phi"))
_KINDS: tuple[Pairs, ...] = (FRAME, (("tau", "phi"),), (("f", "s"),))


def grouped(names: Iterable[str], key: Callable[[str], str]) -> dict[str, list[str]]:
    """Names by what `key` gives for them, all in their order."""
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(key(name), []).append(name)
    return groups


def owner(name: str) -> str:
    """The component that a name stands in."""
    return name.rpartition(".")[0]


def top(name: str) -> str:
    """The component of the model itself that a name stands in, or is."""
    return name.partition(".")[0]


def find_frames(names: Iterable[str]) -> tuple[str, ...]:
    """The connectors with position, angle, force and torque, in their order."""
    known = dict.fromkeys(names)
    return tuple(
        frame
        for frame in (n[:-5] for n in known if n.endswith(".r[1]"))
        if all(f"{frame}.{v}" in known for pair in FRAME for v in pair)
    )


def find_connectors(names: Iterable[str]) -> Mapping[str, Pairs]:
    """The frames and flanges of a model by their names, with their flows and positions."""
    return _found(tuple(names))


@lru_cache(maxsize=4)  # a live page asks for those of one model again and again
def _found(names: tuple[str, ...]) -> Mapping[str, Pairs]:
    held: dict[str, set[str]] = {}
    for name in names:
        if "(" not in name:
            held.setdefault(owner(name), set()).add(name.rpartition(".")[2])
    kinds = {frozenset(n for pair in pairs for n in pair): pairs for pairs in _KINDS}
    return {of: kinds[key] for of, own in held.items() if (key := frozenset(own)) in kinds}


def find_pins(dae: Dae, mechanism: Mechanism) -> set[str]:
    """The joints that hold two frames at one point: with a slide at its end a bar has a length."""
    points = {j.name: {f"{frame}.r[1]" for frame in j.frames} for j in mechanism.joints}
    return {
        e.component
        for e in dae.equations
        if e.component in points
        and e.left.is_symbol
        and e.right.is_symbol
        and {e.left.name, e.right.name} == points[e.component]
    }


def triangles(joints: Sequence[Joint]) -> Iterator[tuple[Joint, Joint, Joint]]:
    """Three joints that close a loop of three links, each three once, in the order of `joints`."""
    beside: dict[int, dict[int, Joint]] = {}
    order = {joint.name: i for i, joint in enumerate(joints)}
    for joint in joints:
        a, b = joint.links
        for c in sorted(beside.get(a, {}).keys() & beside.get(b, {}).keys()):
            first, second = sorted((beside[a][c], beside[b][c]), key=lambda j: order[j.name])
            yield first, second, joint
        beside.setdefault(a, {})[b] = beside.setdefault(b, {})[a] = joint
