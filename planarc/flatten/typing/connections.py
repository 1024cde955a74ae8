"""Operators that ask for connections: `Connections.isRoot`, `rooted`, `cardinality`.

Reference: Modelica Language Specification 3.6, sections 9.4.1 and 3.7.4.3.
"""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.flatten.refusal import unsupported
from planarc.flatten.terms.select import integer
from planarc.flatten.tree.nodes import Env, Instance, Leaf
from planarc.flatten.typing import references
from planarc.ir import flat, syntax


def type_operator(call: syntax.Call, env: Env) -> flat.Expression:
    """`Connections.isRoot(a)`, `Connections.rooted(a)` as values."""
    rooting = env.session.rooting
    env.session.asked.append(None)
    name = call.function.names[1]
    if name not in ("isRoot", "rooted", "uniqueRootIndices") or len(call.arguments) != 1:
        raise error("F315", f"`{call.function}` cannot stand here like this", call.span)
    if name == "uniqueRootIndices":
        raise unsupported("`Connections.uniqueRootIndices`", "9.4", call.span)
    if rooting is None:
        message = f"`{call.function}` cannot decide what is declared or connected"
        raise error("F315", message, call.span)
    part = overconstrained_name(call.arguments[0], env)
    if name == "isRoot":
        value = part in rooting.roots
    else:
        other = rooting.partner.get(part)
        far = len(rooting.distance) + 1
        value = other is None or (
            rooting.distance.get(part, far) < rooting.distance.get(other, far)
        )
    return flat.Literal(flat.BOOLEAN, call.span, value)


def type_cardinality(call: syntax.Call, env: Env) -> flat.Expression:
    """`cardinality(c)`: how often a connector stands in a connection (deprecated)."""
    counts = env.session.cardinalities
    env.session.asked.append(None)
    if len(call.arguments) != 1 or not isinstance(call.arguments[0], syntax.Ref):
        raise error("F290", "`cardinality` takes one connector", call.span)
    if counts is None:
        raise error("F315", "`cardinality` cannot decide what is declared or connected", call.span)
    view = references.resolve(call.arguments[0], env)
    if not isinstance(view, Instance | Leaf) or not view.is_connector:
        raise error("F290", "`cardinality` takes one connector", call.span)
    return integer(counts[view.name], call.span)


def overconstrained_name(argument: syntax.Expression, env: Env) -> str:
    """The full name of the record or type that `Connections.*` is about."""
    if isinstance(argument, syntax.Ref):
        view = references.resolve(argument, env)
        if isinstance(view, Instance | Leaf):
            return view.name
    raise error("F315", "`Connections` operators take a record of a connector", argument.span)
