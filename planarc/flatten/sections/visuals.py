"""Visuals: instances that are drawn and not simulated.

In:   Instance of a class with `annotation(__planarc(visual="kind"))`
Out:  flat.Visual, its declared components with their values as attributes

Example: `Shape shape(length=L, color={255,0,0})` in the component `rod` becomes
    Visual("rod.shape", "shape", (("length", rod.L), ("color", {255, 0, 0}), ...))
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError
from planarc.flatten.tree.demand import attributes_of, leaf_binding, node_of
from planarc.flatten.tree.lookup import components
from planarc.flatten.tree.nodes import Family, Instance, Leaf, Node
from planarc.ir import flat


def visual_of(instance: Instance) -> flat.Visual:
    """The drawing of an instance of a visual class."""
    attributes: list[tuple[str, flat.Expression]] = []
    for name, element in components(instance):
        try:
            _collect(node_of(element), name, attributes)
        except PlanarcError as problem:
            instance.session.keep(problem)
    kind = instance.layout.visual
    assert kind is not None and instance.prefix is not None
    span = instance.element.definition.span if instance.element else instance.cls.span
    return flat.Visual(instance.prefix, kind, tuple(attributes), span)


def _collect(node: Node, name: str, attributes: list[tuple[str, flat.Expression]]) -> None:
    if isinstance(node, Leaf):
        attributes_of(node)
        binding = leaf_binding(node)
        if binding is not None:
            attributes.append((name, binding))
    elif isinstance(node, Family):
        for item in node.items:
            _collect(item, f"{name}{item.name[item.name.rindex('[') :]}", attributes)
    elif isinstance(node, Instance):
        for inner, element in components(node):
            _collect(node_of(element), f"{name}.{inner}", attributes)
