"""Inputs: which variables get their values from outside of their component.

Reference: Modelica Language Specification 3.6, section 4.4.2.2.
"""

from __future__ import annotations

from planarc.flatten.tree.nodes import Instance, Leaf
from planarc.ir import syntax


def is_public_input(leaf: Leaf) -> bool:
    """An input that the component around must give; a protected one is the class's own."""
    if leaf.causality is not syntax.Causality.INPUT or leaf.element.protected:
        return False
    instance = leaf.parent
    while instance.element is not None and (instance.is_connector or instance.is_record):
        if instance.element.protected:
            return False
        if instance.parent is None:
            break
        instance = instance.parent
    return True


def owner_of(leaf: Leaf) -> Instance:
    """The component whose balance a variable belongs to: connectors and records of a
    model count for the model."""
    instance = leaf.parent
    while instance.parent is not None and (instance.is_connector or instance.is_record):
        instance = instance.parent
    return instance


def is_given(leaf: Leaf) -> bool:
    """A public input of the model itself has its value from outside."""
    return is_public_input(leaf) and owner_of(leaf).depth == 0


def connectors_around(part: Leaf | Instance) -> tuple[list[Instance], Instance | None]:
    """The connectors that a part lies in, the innermost first, and the component around them."""
    found: list[Instance] = []
    current = part.parent
    while current is not None and current.is_connector:
        found.append(current)
        current = current.parent
    return found, current
