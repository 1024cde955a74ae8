"""Overconstrained connectors: where their loops are cut, and which node is the root.

In:   Joined   branches, roots, and connections of connectors with an overconstrained part
Out:  Rooting  the roots, the connections that are broken, the distance to the root

A record or type with a function `equalityConstraint` holds more variables than degrees
of freedom (a 3 x 3 rotation has 3). Around a loop of connections its equations would be
redundant; so the connections that close a loop are broken: there the function's residual
replaces the equations of equality.

Example: three bodies in a ring, branch(a1, a2), branch(b1, b2), connect a2-b1 and b2-a1:
with root(a1), the connection b2-a1 is broken.

A connector of the model itself may have its root outside: a frame of a 3-D library holds 9
numbers of a rotation with 3 degrees of freedom, and in a component that is looked at by itself
the 6 constraints between them come from the model that it will be used in (4.7).

Reference: Modelica Language Specification 3.6, section 9.4.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeGuard

from msgspec import field

from planarc.core.data import Data
from planarc.core.diagnostic import error
from planarc.core.disjoint import DisjointSets
from planarc.flatten.connect.connect import Connection, member_nodes
from planarc.flatten.connect.inputs import connectors_around
from planarc.flatten.connect.joining import Joined, Root
from planarc.flatten.terms.conform import scalar_count
from planarc.flatten.tree.demand import class_of, function_of, static_instance
from planarc.flatten.tree.lookup import declared
from planarc.flatten.tree.nodes import Family, Forest, FunctionInfo, Instance, Leaf, Node
from planarc.ir import flat

EQUALITY = "equalityConstraint"


class Pair(Data):
    """Two overconstrained parts that a connection joins."""

    left: Instance | Leaf
    right: Instance | Leaf
    connection: Connection


class Rooting(Forest):
    """The spanning forest of the overconstrained parts, and what was cut to get it."""

    broken: list[Pair] = field(default_factory=list)
    groups: DisjointSets[str] = field(default_factory=DisjointSets)

    def is_rooted(self, name: str) -> bool:
        """True when an overconstrained part reaches a root."""
        return name in self.distance

    def is_broken(self, connection: Connection, leaf: Leaf) -> bool:
        """True when a variable lies in a part whose connection is broken."""
        return any(
            pair.connection is connection
            and (leaf.name == name or leaf.name.startswith(name + "."))
            for pair in self.broken
            for name in (pair.left.name, pair.right.name)
        )


def find_roots(joined: Joined) -> Rooting:
    """Choose the roots and cut the loops."""
    pairs = [p for c in joined.connections for p in overconstrained_pairs(c)]
    rooting = Rooting()
    if not (pairs or joined.branches or joined.roots):
        return rooting
    sets = rooting.groups
    for name in _nodes(joined, pairs):
        sets.add(name)
    for branch in joined.branches:
        if not sets.join(branch.left, branch.right):
            message = "this `Connections.branch` closes a loop of branches"
            raise error("F318", message, branch.span)
        rooting.partner[branch.left] = branch.right
        rooting.partner[branch.right] = branch.left
    _join_roots(joined.roots, sets, rooting)
    kept: list[tuple[str, str]] = [(b.left, b.right) for b in joined.branches]
    for pair in pairs:
        if sets.find(pair.left.name) == sets.find(pair.right.name):
            rooting.broken.append(pair)
        else:
            sets.join(pair.left.name, pair.right.name)
            kept.append((pair.left.name, pair.right.name))
    _choose_potential(joined.roots, sets, rooting)
    _measure(kept, rooting)
    return rooting


def _nodes(joined: Joined, pairs: list[Pair]) -> Iterator[str]:
    for root in joined.roots:
        yield root.name
    for branch in joined.branches:
        yield from (branch.left, branch.right)
    for pair in pairs:
        yield from (pair.left.name, pair.right.name)


_ORIGIN = "<root>"  # all definite roots hang on it


def _join_roots(roots: list[Root], sets: DisjointSets[str], rooting: Rooting) -> None:
    for root in roots:
        if root.priority is not None:
            continue
        sets.add(_ORIGIN)
        if sets.find(root.name) == sets.find(_ORIGIN):
            raise error("F318", f"`{root.name}` is a second root of its branches", root.span)
        sets.join(_ORIGIN, root.name)
        rooting.roots.add(root.name)


def _choose_potential(roots: list[Root], sets: DisjointSets[str], rooting: Rooting) -> None:
    """A part of the graph without a root takes its potential root of lowest number."""
    rooted = {sets.find(name) for name in rooting.roots}
    ordered = sorted((r for r in roots if r.priority is not None), key=lambda r: r.priority or 0)
    for root in ordered:
        group = sets.find(root.name)
        if group not in rooted:
            rooted.add(group)
            rooting.roots.add(root.name)


def _measure(kept: list[tuple[str, str]], rooting: Rooting) -> None:
    """Distances to the root over the edges that are kept."""
    neighbours: dict[str, list[str]] = {}
    for a, b in kept:
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    front = sorted(rooting.roots)
    rooting.distance = dict.fromkeys(front, 0)
    while front:
        following = []
        for name in front:
            for other in neighbours.get(name, ()):
                if other not in rooting.distance:
                    rooting.distance[other] = rooting.distance[name] + 1
                    following.append(other)
        front = following


# Overconstrained parts -------------------------------------------------------------------------


def _is_overconstrained(node: Node) -> TypeGuard[Instance | Leaf]:
    return isinstance(node, Instance | Leaf) and EQUALITY in node.layout.members


def overconstrained_pairs(connection: Connection) -> list[Pair]:
    """The overconstrained parts that a connection joins."""
    found = []
    stack: list[tuple[Node, Node]] = [(connection.left.node, connection.right.node)]
    while stack:
        a, b = stack.pop()
        if _is_overconstrained(a) and _is_overconstrained(b):
            found.append(Pair(a, b, connection))
            continue
        if isinstance(a, Instance) and isinstance(b, Instance):
            others = dict(member_nodes(b))
            pairs = [(n, others[name]) for name, n in member_nodes(a) if name in others]
            stack += reversed(pairs)
        elif isinstance(a, Family) and isinstance(b, Family):
            stack += reversed(list(zip(a.items, b.items, strict=False)))
    return found


# A root outside of the model ----------------------------------------------------------


def redundant_unknowns(instances: list[Instance], leaves: list[Leaf], rooting: Rooting) -> int:
    """Redundant unknowns, for each group of parts without a root that the model shows."""
    parts: list[Instance | Leaf] = [i for i in instances if EQUALITY in i.layout.members]
    parts += [leaf for leaf in leaves if EQUALITY in leaf.layout.members]
    counted: set[str] = set()
    total = 0
    for part in parts:
        if rooting.is_rooted(part.name) or not _is_shown(part):
            continue
        rooting.groups.add(part.name)
        group = rooting.groups.find(part.name)
        if group not in counted:
            counted.add(group)
            constraint = equality_of(part).signature.outputs[0]
            total += _size(part, leaves) - scalar_count(constraint.type)
    return total


def _is_shown(part: Instance | Leaf) -> bool:
    """Part of a connector of the model itself."""
    around, owner = connectors_around(part)
    return bool(around) and owner is not None and owner.depth == 0


def _size(part: Instance | Leaf, leaves: list[Leaf]) -> int:
    if isinstance(part, Leaf):
        return scalar_count(part.type)
    inside = (leaf for leaf in leaves if leaf.name.startswith(part.name + "."))
    return sum(
        scalar_count(leaf.type) for leaf in inside if leaf.variability > flat.Variability.PARAMETER
    )


def equality_of(part: Instance | Leaf) -> FunctionInfo:
    """The function `equalityConstraint` of a part's class. Raises F317."""
    cls = part.cls if isinstance(part, Instance) else part.layout.parts[0].cls
    element = declared(static_instance(cls), EQUALITY)
    info = function_of(class_of(element, cls.span), cls.span)
    inputs, outputs = info.signature.inputs, info.signature.outputs
    if len(inputs) != 2 or len(outputs) != 1 or len(outputs[0].type.dims) != 1:
        raise error(
            "F317",
            f"`{info.name}` must have two inputs and a vector as its only output"
            " (Modelica specification, section 9.4)",
            element.definition.span,
        )
    return info
