"""Calls: built-in operators, record constructors, functions of the model.

In:   syntax.Call, Env
Out:  flat.Builtin, flat.Record or flat.Call with complete arguments

Example: with `function f input Real x; input Real k = 2*x; ... end f;`
    f(3)  becomes  Call("f", (3, 2*3));   f(k=1, x=2)  becomes  Call("f", (2, 1))

Reference: Modelica Language Specification 3.6, sections 12.3 to 12.6.
"""

from __future__ import annotations

from planarc.core.diagnostic import error
from planarc.core.nearest import did_you_mean
from planarc.flatten.functions import call_arguments, constructors
from planarc.flatten.functions.values import call_of_argument, function_class
from planarc.flatten.refusal import unsupported
from planarc.flatten.several import for_each
from planarc.flatten.terms.constant import to_expression
from planarc.flatten.tree import lookup
from planarc.flatten.tree.demand import function_of, layout_of
from planarc.flatten.tree.nodes import Class, Env
from planarc.flatten.typing import builtins, comprehension, connections
from planarc.flatten.values import evaluate
from planarc.flatten.values.foreign import LOAD_RESOURCE
from planarc.ir import flat, syntax

_REDUCTIONS = frozenset({"sum", "product", "min", "max"})
_FUNCTION_KINDS = (syntax.ClassKind.FUNCTION, syntax.ClassKind.OPERATOR_FUNCTION)
_CONNECTIONS = "Connections"


def type_call(node: syntax.Call, env: Env, results: bool = False) -> flat.Expression:
    """A call as a value; `results` keeps all results, for the left side of an equation."""
    names = node.function.names
    if len(names) == 1 and not node.function.absolute and names[0] in env.locals:
        return call_of_argument(node, env.locals[names[0]], env)
    if names[0] == _CONNECTIONS and len(names) == 2 and lookup.find(env.scope, names[0]) is None:
        return connections.type_operator(node, env)
    if builtins.is_name(names[-1]) and _is_builtin(node.function, env):
        return _builtin(node, env)
    cls = function_class(node.function, env)
    if cls.definition.name in ("Integer", "String") and cls.name == cls.definition.name:
        return _builtin(node, env)
    layout = layout_of(cls)
    if layout.kind is syntax.ClassKind.RECORD:
        return constructors.construct_record(node, cls, env)
    if layout.builtin is not None and layout.builtin.literals:
        return constructors.convert_to_enumeration(node, layout.builtin, env)
    if layout.kind not in _FUNCTION_KINDS:
        if layout.builtin is not None and layout.builtin.name == "Clock":
            raise unsupported("clocks", "16", node.span)
        if layout.kind in (syntax.ClassKind.OPERATOR_RECORD, syntax.ClassKind.OPERATOR):
            raise unsupported("operator records", "14", node.span)
        raise error(
            "F292", f"`{node.function}` is a {layout.kind.value}, not a function", node.span
        )
    return _call_function(node, cls, env, results)


def _is_builtin(function: syntax.Ref, env: Env) -> bool:
    if len(function.names) > 1:
        return False
    return function.absolute or lookup.find(env.scope, function.names[0]) is None


# Built-ins -----------------------------------------------------------------------------------


def _builtin(node: syntax.Call, env: Env) -> flat.Expression:
    name = node.function.names[-1]
    if name in builtins.REFUSED:
        feature, section = builtins.REFUSED[name]
        raise unsupported(feature, section, node.span)
    if env.function is not None and name in builtins.OF_MODELS:
        raise error("F303", f"a function cannot use `{name}`", node.span)
    if name == "cardinality":
        return _cardinality(node, env)
    if name in ("assert", "terminate", "reinit"):
        raise error("F293", f"`{name}` is an equation of its own, not a value", node.span)
    first = node.arguments[0] if node.arguments else None
    if isinstance(first, syntax.Comprehension):
        if name not in _REDUCTIONS:
            raise error("F290", f"`{name}` does not take an iterator", node.span)
        return comprehension.type_comprehension(first, name, env)
    if name == "String" and node.named:
        return _string(node, env)
    given = _positional(node, name)
    arguments = for_each(given, env.typed)
    return builtins.apply_builtin(name, arguments, node.span, env)


def _string(node: syntax.Call, env: Env) -> flat.Expression:
    if len(node.arguments) != 1:
        raise error("F290", "`String` takes one value and options by name", node.span)
    options = {}
    for named in node.named:
        if named.name not in builtins.STRING_OPTIONS:
            hint = did_you_mean(named.name, builtins.STRING_OPTIONS)
            message = f"`String` has no argument `{named.name}`"
            raise error("F290", message, named.span, hint=hint)
        options[named.name] = env.typed(named.value)
    value = env.typed(node.arguments[0])
    return builtins.to_string(value, options, node.span)


def _positional(node: syntax.Call, name: str) -> list[syntax.Expression]:
    """Arguments in order; the few named ones of built-ins are put in place."""
    if not node.named:
        return list(node.arguments)
    places = builtins.rule_of(name).names
    filled = list(node.arguments)
    for argument in sorted(
        node.named, key=lambda a: places.index(a.name) if a.name in places else 99
    ):
        if argument.name not in places:
            raise error("F290", f"`{name}` has no argument `{argument.name}`", argument.span)
        filled.append(argument.value)
    return filled


def _cardinality(node: syntax.Call, env: Env) -> flat.Expression:
    env.session.warn("F294", "`cardinality` is deprecated", node.span)
    return connections.type_cardinality(node, env)


# Functions -----------------------------------------------------------------------------------


def _call_function(node: syntax.Call, cls: Class, env: Env, results: bool) -> flat.Expression:
    info = function_of(cls, node.span)
    arguments = call_arguments.complete_arguments(info, node, env)
    if info.signature.builtin is not None and not results:
        return builtins.apply_builtin(info.signature.builtin, arguments, node.span, env)
    call = call_arguments.vectorised(info, arguments, node.span, env, results)
    if env.function is None and isinstance(call, flat.Call):
        function = env.session.functions.get(call.function)
        if function is not None and function.external == LOAD_RESOURCE:
            path = evaluate.structural_value(call, env, f"the file of `{node.function}`")
            return to_expression(path, call.type, node.span)
    return call
