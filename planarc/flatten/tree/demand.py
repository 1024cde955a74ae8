"""Slots of nodes, each filled when first asked for, by the pass that makes it.

Example: `node_of(element)` gives the Leaf of a declaration. Its sizes are evaluated then,
which asks for the values of parameters, `leaf_binding(leaf)`, and so for other nodes.

No module here or above imports the pass that fills a slot; only `pipeline` knows it.
"""

from __future__ import annotations

from planarc.core.source import Span
from planarc.flatten.tree.nodes import (
    Class,
    Element,
    FunctionInfo,
    Instance,
    Layout,
    Leaf,
    Node,
    Session,
    State,
)
from planarc.ir import flat


def session_of(cls: Class) -> Session:
    """The run that a class belongs to."""
    assert cls.parent is not None
    return cls.parent.session


def layout_of(cls: Class) -> Layout:
    """The layout of a class; while it is being made, as far as it has come."""
    return session_of(cls).makers.layout(cls) if cls.layout is None else cls.layout


def static_instance(cls: Class) -> Instance:
    """A class opened as a class: for packages and the constants in them."""
    if cls.static is None:
        cls.static = Instance(cls, layout_of(cls), None, cls.mod, None, session_of(cls))
    return cls.static


def class_of(element: Element, span: Span | None = None) -> Class:
    """The class that a class element stands for, after all that replaced it."""
    return element.scope.session.makers.cls(element, span) if element.cls is None else element.cls


def node_of(element: Element) -> Node:
    """The node of a component."""
    return element.scope.session.makers.node(element) if element.node is None else element.node


def leaf_binding(leaf: Leaf) -> flat.Expression | None:
    """The typed value of a variable's declaration, None when it has none."""
    if leaf.binding_state is State.DONE:
        return leaf.binding
    return leaf.parent.session.makers.binding(leaf)


def attributes_of(leaf: Leaf) -> flat.Attributes:
    """The attributes of a variable: its modifiers over those of its type."""
    if leaf.attributes is None:
        return leaf.parent.session.makers.attributes(leaf)
    return leaf.attributes


def function_of(cls: Class, span: Span) -> FunctionInfo:
    """The information for calls of a function class; `span` is the place of one."""
    return session_of(cls).makers.function(cls, span)
