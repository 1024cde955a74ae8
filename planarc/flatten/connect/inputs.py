"""Inputs: which variables get their values from outside of their component.

Reference: Modelica Language Specification 3.6, section 4.4.2.2.
"""

from __future__ import annotations

from itertools import takewhile

from planarc.flatten.tree.nodes import Instance, Leaf
from planarc.ir import syntax


def is_public_input(leaf: Leaf) -> bool:
    """An input that the component around must give; a protected one is the class's own."""
    if leaf.causality is not syntax.Causality.INPUT or leaf.element.protected:
        return False
    around = takewhile(_is_part, leaf.parent.outwards())
    return not any(i.element and i.element.protected for i in around)


def _is_part(instance: Instance) -> bool:
    """A connector or a record of a component, or of the model."""
    return instance.parent is not None and (instance.is_connector or instance.is_record)


def owner_of(leaf: Leaf) -> Instance:
    """The component whose balance a variable belongs to: connectors and records of a
    model count for the model."""
    return next(i for i in leaf.parent.outwards() if not _is_part(i))


def is_given(leaf: Leaf) -> bool:
    """A public input of the model itself has its value from outside."""
    return is_public_input(leaf) and owner_of(leaf).depth == 0


def connectors_around(part: Leaf | Instance) -> tuple[list[Instance], Instance | None]:
    """The connectors that a part lies in, the innermost first, and the component around them."""
    found: list[Instance] = []
    around = part.parent
    while around is not None and around.is_connector:
        found.append(around)
        around = around.parent
    return found, around
