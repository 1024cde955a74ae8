"""Start values told apart: those that the user wrote, and a library's defaults.

A start value counts as written when it stands in the model that is compiled, in a
user's file, or in a modifier at a component's declaration; not when it is the
declaration's own default, or comes from a parameter that nobody changed.

Example, with `model Body  parameter Real r0 = 0; Real r(start=r0); end Body;` from
a library:  `Body b;` writes nothing,  `Body b(r0=1);` and `Body b(r(start=1));` do.
"""

from __future__ import annotations

from planarc.flatten.library.library import Entry
from planarc.flatten.tree.lookup import leaf_named
from planarc.flatten.tree.nodes import Binding, Instance, Leaf, Scope
from planarc.ir import syntax
from planarc.ir.syntaxwalk import references_in

MAX_CHAIN = 50


def is_start_written(leaf: Leaf, binding: Binding | None) -> bool:
    """True when somebody outside of the declaring library class chose this value."""
    if binding is None:
        return False
    return _written(binding, leaf.parent, MAX_CHAIN)


def _written(binding: Binding, declaring: Instance, depth: int) -> bool:
    writer = binding.scope.instance
    if writer.prefix is None:
        return False
    if _belongs_to_user(binding.scope):
        return True
    parameters = _parameters(binding.expression, writer)
    if parameters and depth > 0:
        for parameter in parameters:
            chosen = parameter.mod.binding
            modified = chosen is not None and not chosen.default
            if modified and chosen and _written(chosen, parameter.parent, depth - 1):
                return True
        return False
    return writer is not declaring


def _belongs_to_user(scope: Scope) -> bool:
    """The text of the model that is compiled, or of another class in the user's file."""
    if scope.instance.prefix == "" and scope.part.index == 0:
        return True
    entry = scope.cls.entry
    return isinstance(entry, Entry) and entry.user


def _parameters(expression: syntax.Expression, writer: Instance) -> list[Leaf]:
    """The parameters of the writing instance that an expression names."""
    found = []
    for ref in references_in(expression):
        element = writer.elements.get(ref.names[0])
        node = None if element is None else element.node
        node = node or leaf_named(writer.session, writer.full_name(ref.names[0]))
        if isinstance(node, Leaf):
            found.append(node)
    return found
