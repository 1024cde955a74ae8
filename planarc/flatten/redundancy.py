"""Overconstrained connectors of the model itself, whose root stands outside.

In:   the instances and variables of a model, its Rooting
Out:  the number of unknowns that a root outside of the model would fix

A frame of a 3-D library holds 9 numbers of a rotation with 3 degrees of freedom. In a
component that is looked at by itself the 6 constraints between them come from the root
of the model that it will be used in (4.7 and 9.4 of the specification, 3.6).
"""

from __future__ import annotations

from planarc.flatten.equations import scalar_count
from planarc.flatten.functions import function_of
from planarc.flatten.lookup import member, static_instance
from planarc.flatten.redeclare import class_of
from planarc.flatten.rooting import EQUALITY, Rooting
from planarc.flatten.tree import Instance, Leaf, Session
from planarc.ir import flat


def redundant_unknowns(
    instances: list[Instance], leaves: list[Leaf], rooting: Rooting, session: Session
) -> int:
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
            total += _size(part, leaves) - _degrees(part, session)
    return total


def _is_shown(part: Instance | Leaf) -> bool:
    """Part of a connector of the model itself."""
    current: Instance | None = part.parent
    while current is not None and current.is_connector:
        current = current.parent
    return current is not None and current.depth == 0 and part.parent is not current


def _size(part: Instance | Leaf, leaves: list[Leaf]) -> int:
    if isinstance(part, Leaf):
        return scalar_count(part.type)
    inside = (leaf for leaf in leaves if leaf.name.startswith(part.name + "."))
    return sum(
        scalar_count(leaf.type) for leaf in inside if leaf.variability > flat.Variability.PARAMETER
    )


def _degrees(part: Instance | Leaf, session: Session) -> int:
    """The size of what `equalityConstraint` gives."""
    cls = part.cls if isinstance(part, Instance) else part.layout.parts[0].cls
    element = member(static_instance(cls), EQUALITY)
    assert element is not None
    info = function_of(class_of(element, cls.span), session, cls.span)
    return scalar_count(info.signature.outputs[0].type)
