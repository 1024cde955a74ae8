"""Joints that have flanges, but no drive: springs, dampers, stops and brakes hang there alone.

In:   Dae      connection sets, what components declare of their energy; names of joints
Out:  names    of the joints with flanges that nothing drives

What hangs on a joint is all that its flanges reach through flanges, but through no other joint;
the flange `support` is that of the housing. It drives where a part of it declares
`suppliedPower`. Where no part declares anything, nobody knows, and the joint is not named.

Example: connect(closer.flange_b, hinge.axis) with a Spring, which declares a potential: `hinge`
"""

from __future__ import annotations

from collections.abc import Collection

from planarc.core.disjoint import DisjointSets
from planarc.insight.connectors import FRAME, find_connectors, grouped, owner
from planarc.ir.dae import Dae

_HOUSING = ".support"


def find_passive(dae: Dae, joints: Collection[str]) -> tuple[str, ...]:
    """The joints with flanges that only store or take energy, in their order."""
    connectors = find_connectors(v.name for v in dae.variables)
    flanges = [
        name
        for name, pairs in connectors.items()
        if pairs is not FRAME and not name.endswith(_HOUSING)
    ]
    own, known = grouped(flanges, owner), frozenset(joints)
    if own.keys().isdisjoint(known):
        return ()
    sets = DisjointSets(flanges)
    for connected in dae.connections:
        _join(sets, [name for name in connected if name in sets])
    for component, ends in own.items():
        if not _is_inside(component, known):
            _join(sets, ends)
    reached = grouped(flanges, sets.find)
    told = {d.component for d in dae.declared if d.kind == "energy"}
    giving = dae.drives
    passive = []
    for joint in joints:
        hanging = {owner(n) for end in own.get(joint, ()) for n in reached[sets.find(end)]}
        if not hanging.isdisjoint(told) and hanging.isdisjoint(giving):
            passive.append(joint)
    return tuple(passive)


def _is_inside(component: str, joints: Collection[str]) -> bool:
    """True for a joint and for its parts."""
    while component and component not in joints:
        component = owner(component)
    return bool(component)


def _join(sets: DisjointSets[str], names: list[str]) -> None:
    for other in names[1:]:
        sets.join(names[0], other)
