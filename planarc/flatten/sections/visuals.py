"""What is drawn: instances of visual classes, with the values of their components.

Example: `Visualizers.Bar bar(length=L)` becomes a flat.Visual `bar` with the attribute `length`.
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
    return flat.Visual(instance.prefix, kind, tuple(attributes), instance.span)


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
