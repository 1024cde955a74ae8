"""Mechanisms of one model that do not act on each other, though they are unlike.

In:   Dae, Mechanism
Out:  a note S327, at the first of the user's parts of the second one

Two groups of moving links that only the ground joins, and no equation, signal or force between
them. Alike ones stand side by side to be compared; unlike ones were mostly to be one machine.

Example: the hinge of a pendulum connected to the world, where the cart was meant.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.disjoint import DisjointSets
from planarc.core.prose import listed
from planarc.insight.connectors import owner, top
from planarc.insight.topology import find_moving
from planarc.ir.dae import Dae
from planarc.ir.expr import symbols
from planarc.ir.flat import Part
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.places import declared_part

#: The part of the smaller group's classes that both have, from which they are alike.
_ALIKE = 0.6
_SHOWN = 3


def independent_mechanisms(dae: Dae, mechanism: Mechanism) -> Iterator[Diagnostic]:
    groups = [*_by_joints(mechanism)]
    if len(groups) < 2 or any(not when.component for when in dae.whens):
        return
    heavy = {top(c) for c in find_moving(dae)}
    groups = [tops for tops in groups if not heavy.isdisjoint(tops)]
    if len(groups) < 2:
        return
    joined = _by_equations(dae, mechanism)
    machines: dict[str, dict[str, None]] = {}
    for tops in groups:
        for one, other in pairwise(tops):
            joined.join(one, other)
    for tops in groups:
        machines.setdefault(joined.find(tops[0]), {}).update(dict.fromkeys(tops))
    parts = [[p for n in names if (p := declared_part(dae, n))] for names in machines.values()]
    if len(parts) != 2 or not all(parts) or _are_alike(*parts):
        return
    first, second = ([f"`{p.name}`" for p in of[:_SHOWN]] for of in parts)
    yield Diagnostic(
        "S327",
        f"the mechanism of {listed(second)} and that of {listed(first)} do not act on each other",
        parts[1][0].span,
        Severity.NOTE,
        hint=f"connect {second[0]} to a part of the other one, and not to the ground, if they are "
        "one machine",
    )


def _by_joints(mechanism: Mechanism) -> Iterator[list[str]]:
    """The parts of the model in each group of moving links that joints hold together, and some
    joint to the ground."""
    links = DisjointSets(range(len(mechanism.links)))
    held: set[int] = set()
    for joint in mechanism.joints:
        moving = [i for i in joint.links if i != GROUND]
        held.update(moving if len(moving) < len(joint.links) else ())
        for other in moving[1:]:
            links.join(moving[0], other)
    groups: dict[int, list[int]] = {}
    for i in range(1, len(mechanism.links)):
        groups.setdefault(links.find(i), []).append(i)
    for group in groups.values():
        if not held.isdisjoint(group):
            frames = (f for i in group for f in mechanism.links[i].frames)
            yield list(dict.fromkeys(map(top, frames)))


def _by_equations(dae: Dae, mechanism: Mechanism) -> DisjointSets[str]:
    """The parts of the model, joined where an equation has unknowns of both; but for those of the
    frames on the ground, which all share."""
    ground = {*mechanism.links[GROUND].frames}
    around = {p.name for p in dae.parts if p.inner}
    unknowns = {v.name for v in (*dae.variables, *dae.discretes, *dae.inputs)}
    joined: DisjointSets[str] = DisjointSets()
    for q in (*dae.equations, *dae.discrete_equations):
        names = {e.name for e in symbols(q.left, q.right)} & unknowns
        if any(owner(n) in ground for n in names):
            continue
        tops = [t for t in dict.fromkeys(map(top, names)) if t not in around]
        for other in tops:
            joined.join(tops[0], other)
    return joined


def _are_alike(first: Sequence[Part], second: Sequence[Part]) -> bool:
    """Whether most classes of the smaller group are in the other one."""
    one, other = (Counter(p.class_name for p in of) for of in (first, second))
    return (one & other).total() >= _ALIKE * min(one.total(), other.total())
