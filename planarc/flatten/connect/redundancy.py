"""Overconstrained connectors of the model itself, whose root stands outside.

In:   the instances and variables of a model, its Rooting
Out:  the number of unknowns that a root outside of the model would fix

A frame of a 3-D library holds 9 numbers of a rotation with 3 degrees of freedom. In a
component that is looked at by itself the 6 constraints between them come from the root
of the model that it will be used in (4.7 and 9.4 of the specification, 3.6).
"""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.flatten.connect.inputs import connectors_around
from planarc.flatten.connect.rooting import EQUALITY, Rooting
from planarc.flatten.terms.conform import scalar_count
from planarc.flatten.tree.demand import class_of, function_of, static_instance
from planarc.flatten.tree.lookup import member
from planarc.flatten.tree.nodes import FunctionInfo, Instance, Leaf
from planarc.ir import flat


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
    element = member(static_instance(cls), EQUALITY)
    assert element is not None
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
