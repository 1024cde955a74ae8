"""Calls: built-in operators, record constructors, functions of the model.

In:   syntax.Call, Env
Out:  flat.Builtin, flat.Record or flat.Call with complete arguments

Example: with `function f input Real x; input Real k = 2*x; ... end f;`
    f(3)  becomes  Call("f", (3, 2*3));   f(k=1, x=2)  becomes  Call("f", (2, 1))

Reference: Modelica Language Specification 3.6, sections 12.3 to 12.6.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten import (
    bindings,
    builtins,
    comprehension,
    connection_operators,
    constructors,
    expressions,
    functions,
    inherit,
    lookup,
    references,
)
from planarc.flatten.conform import base_conforms, counted, dims_conform, expect, mismatch
from planarc.flatten.environment import Env
from planarc.flatten.refusal import unsupported
from planarc.flatten.select import array, opened
from planarc.flatten.tree import Class, Family, Instance, Leaf
from planarc.ir import flat, syntax

_REDUCTIONS = frozenset({"sum", "product", "min", "max"})
_FUNCTION_KINDS = (syntax.ClassKind.FUNCTION, syntax.ClassKind.OPERATOR_FUNCTION)
_CONNECTIONS = "Connections"


def type_call(node: syntax.Call, env: Env, results: bool = False) -> flat.Expression:
    """A call as a value; `results` keeps all results, for the left side of an equation."""
    names = node.function.names
    if len(names) == 1 and not node.function.absolute and names[0] in env.locals:
        return _call_of_argument(node, env.locals[names[0]], env)
    if names[0] == _CONNECTIONS and len(names) == 2 and lookup.find(env.scope, names[0]) is None:
        return connection_operators.type_operator(node, env)
    if names[-1] in builtins.NAMES and _is_builtin(node.function, env):
        return _builtin(node, env)
    cls = function_class(node.function, env)
    if cls.definition.name in ("Integer", "String") and cls.name == cls.definition.name:
        return _builtin(node, env)
    layout = inherit.layout_of(cls)
    if layout.kind is syntax.ClassKind.RECORD:
        return constructors.construct_record(node, cls, env)
    if layout.builtin is not None and layout.builtin.literals:
        return constructors.convert_to_enumeration(node, layout.builtin, env)
    if layout.kind not in _FUNCTION_KINDS:
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


def function_class(ref: syntax.Ref, env: Env) -> Class:
    """The class that the name of a called function means."""
    if lookup.find(env.scope, ref.parts[0].name) is None and not ref.absolute:
        if len(ref.parts) == 1:
            hint = lookup.suggestion(
                ref.parts[0].name, [*builtins.NAMES, *_functions_in_sight(env)]
            )
            raise error("F210", f"unknown function `{ref}`", ref.span, hint=hint)
        raise lookup.unknown(env.scope, ref.parts[0].name, ref.span)
    view = references.resolve(ref, env)
    if isinstance(view, Class):
        return view
    if isinstance(view, Leaf | Instance | Family):
        raise error("F292", f"`{ref}` is a component, not a function", ref.span)
    raise error("F292", f"`{ref}` is not a function", ref.span)


def _functions_in_sight(env: Env) -> list[str]:

    return lookup.names_in_sight(env.scope)


# Built-ins -----------------------------------------------------------------------------------


def _builtin(node: syntax.Call, env: Env) -> flat.Expression:
    name = node.function.names[-1]
    if name in builtins.REFUSED:
        feature, section = builtins.REFUSED[name]
        raise unsupported(feature, section, node.span)
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
    arguments = [expressions.type_expression(a, env) for a in _positional(node, name)]
    return builtins.apply_builtin(name, arguments, node.span, env)


def _string(node: syntax.Call, env: Env) -> flat.Expression:
    if len(node.arguments) != 1:
        raise error("F290", "`String` takes one value and options by name", node.span)
    options = {}
    for named in node.named:
        if named.name not in builtins.STRING_OPTIONS:
            hint = lookup.suggestion(named.name, builtins.STRING_OPTIONS)
            message = f"`String` has no argument `{named.name}`"
            raise error("F290", message, named.span, hint=hint)
        options[named.name] = expressions.type_expression(named.value, env)
    value = expressions.type_expression(node.arguments[0], env)
    return builtins.to_string(value, options, node.span)


def _positional(node: syntax.Call, name: str) -> list[syntax.Expression]:
    """Arguments in order; the few named ones of built-ins are put in place."""
    if not node.named:
        return list(node.arguments)
    places = builtins.RULES[name].names
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
    return connection_operators.type_cardinality(node, env)


# Functions -----------------------------------------------------------------------------------


def _call_function(node: syntax.Call, cls: Class, env: Env, results: bool) -> flat.Expression:
    info = functions.function_of(cls, env.session, node.span)
    arguments = complete_arguments(info, node, env)
    if info.signature.builtin is not None and not results:
        return builtins.apply_builtin(info.signature.builtin, arguments, node.span, env)
    return _vectorised(info, arguments, node.span, env, results)


def complete_arguments(
    info: functions.FunctionInfo, node: syntax.Call, env: Env
) -> list[flat.Expression]:
    """One argument for each input: positional, named, bound, default."""
    signature = info.signature
    given = _given(signature, info, node, env)
    arguments: list[flat.Expression] = []
    so_far: dict[str, flat.Expression] = {}
    for variable in signature.inputs:
        value = given.get(variable.name)
        if value is None:
            value = _missing_input(info, variable, so_far, node, env)
        arguments.append(value)
        so_far[variable.name] = value
    return arguments


def _given(
    signature: functions.Signature, info: functions.FunctionInfo, node: syntax.Call, env: Env
) -> dict[str, flat.Expression]:
    open_inputs = [v for v in signature.inputs if v.name not in info.bound]
    if len(node.arguments) > len(open_inputs):
        raise error(
            "F290",
            f"`{node.function}` takes {counted(len(open_inputs), 'argument')}, "
            f"not {len(node.arguments)}",
            node.span,
        )
    given = {}
    for variable, argument in zip(open_inputs, node.arguments, strict=False):
        given[variable.name] = _argument(argument, variable, env)
    by_name = {v.name: v for v in signature.inputs}
    for named in node.named:
        if named.name not in by_name:
            raise error(
                "F290",
                f"`{node.function}` has no input `{named.name}`",
                named.span,
                hint=lookup.suggestion(named.name, by_name),
            )
        if named.name in given:
            raise error("F290", f"the input `{named.name}` is given twice", named.span)
        given[named.name] = _argument(named.value, by_name[named.name], env)
    return given


def _argument(argument: syntax.Expression, variable: flat.Variable, env: Env) -> flat.Expression:
    if variable.type.base is flat.Base.FUNCTION:
        return function_value(argument, variable.type, env)
    return expressions.type_expression(argument, env)


def _missing_input(
    info: functions.FunctionInfo,
    variable: flat.Variable,
    so_far: dict[str, flat.Expression],
    node: syntax.Call,
    env: Env,
) -> flat.Expression:
    bound = info.bound.get(variable.name)
    if bound is not None:
        if env.function is None:
            return bindings.type_binding(bound)
        return expressions.type_expression(bound.expression, Env(bound.scope, {}, env.function))
    default = info.signature.defaults.get(variable.name)
    if default is None:
        raise error(
            "F290", f"`{node.function}` needs a value for its input `{variable.name}`", node.span
        )
    expression, scope = default
    locals_ = {**info.signature.constants, **so_far}
    return expressions.type_expression(expression, Env(scope, locals_, env.function))


def _vectorised(
    info: functions.FunctionInfo,
    arguments: list[flat.Expression],
    span: Span,
    env: Env,
    results: bool,
) -> flat.Expression:
    """The call; with arrays in place of scalars, one call for each entry (12.4.6)."""
    inputs = info.signature.inputs
    extra = 0
    for variable, argument in zip(inputs, arguments, strict=True):
        more = len(argument.type.dims) - len(variable.type.dims)
        if more > 0 and base_conforms(variable.type, argument.type):
            extra = max(extra, more)
    if extra == 0 or results:
        return _single(info, arguments, span, env, results)
    size = next(
        a.type.dims[0]
        for v, a in zip(inputs, arguments, strict=True)
        if len(a.type.dims) - len(v.type.dims) == extra
    )
    if size is None:
        raise error("F291", "a call for each entry of an array needs a known size", span)
    columns = []
    for variable, argument in zip(inputs, arguments, strict=True):
        if len(argument.type.dims) - len(variable.type.dims) == extra:
            if argument.type.dims[0] != size:
                raise error("F291", f"the arrays given to `{info.name}` differ in size", span)
            columns.append(opened(argument))
        else:
            columns.append([argument] * size)
    items = [_vectorised(info, list(row), span, env, False) for row in zip(*columns, strict=True)]
    element = items[0].type if items else _result_type(info, arguments, span)
    return array(items, element, span)


def _single(
    info: functions.FunctionInfo,
    arguments: list[flat.Expression],
    span: Span,
    env: Env,
    results: bool,
) -> flat.Expression:
    for variable, argument in zip(info.signature.inputs, arguments, strict=True):
        what = f"the input `{variable.name}` of `{info.name}`"
        if not base_conforms(variable.type, argument.type):
            raise mismatch(variable.type, argument.type, what, argument.span)
        if not dims_conform(variable.type.dims, argument.type.dims):
            raise mismatch(variable.type, argument.type, what, argument.span)
    if not info.signature.outputs and not results:
        raise error("F290", f"`{info.name}` has no result", span)
    type_ = flat.Type(flat.Base.RECORD, name="(results)")
    if info.signature.outputs:
        type_ = _result_type(info, arguments, span)
    captured = [references.leaf_value(leaf, span, env) for leaf in info.signature.captures]
    return flat.Call(
        type_, span, info.signature.name, (*arguments, *captured), None if results else 0
    )


def _result_type(
    info: functions.FunctionInfo, arguments: list[flat.Expression], span: Span
) -> flat.Type:
    return info.signature.result_type(0, arguments, span)


def result_types(call: flat.Call, env: Env) -> list[flat.Type]:
    """The types of all results of a call."""
    signature = env.session.signatures[call.function]
    arguments = list(call.arguments[: len(signature.inputs)])
    return [signature.result_type(k, arguments, call.span) for k in range(len(signature.outputs))]


# Functions as values ---------------------------------------------------------------------------


def function_value(argument: syntax.Expression, formal: flat.Type, env: Env) -> flat.Expression:
    """A function given to a function: its name, or `function f(a=1)`."""
    if isinstance(argument, syntax.PartialApplication):
        return _partial_call(argument.function, argument.named, argument.span, formal, env)
    if not isinstance(argument, syntax.Ref):
        raise error("F292", "this input needs a function", argument.span)
    if argument.parts[0].name in env.locals:
        value = env.locals[argument.parts[0].name]
        expect(flat.Type(flat.Base.FUNCTION), value, f"`{argument}`")
        return value
    return _partial_call(argument, (), argument.span, formal, env)


def type_partial(node: syntax.PartialApplication, env: Env) -> flat.Expression:
    raise error("F292", "a function can be given only to an input that is a function", node.span)


def _partial_call(
    ref: syntax.Ref,
    named: tuple[syntax.NamedArgument, ...],
    span: Span,
    formal: flat.Type,
    env: Env,
) -> flat.Expression:
    """The function with all its inputs bound but for those of the formal input."""
    info = functions.function_of(function_class(ref, env), env.session, span)
    by_name = {v.name: v for v in info.signature.inputs}
    bound: dict[str, flat.Expression] = {}
    for name, binding in info.bound.items():
        bound[name] = expressions.type_expression(
            binding.expression, Env(binding.scope, {}, env.function)
        )
    for argument in named:
        if argument.name not in by_name:
            raise error(
                "F290",
                f"`{ref}` has no input `{argument.name}`",
                argument.span,
                hint=lookup.suggestion(argument.name, by_name),
            )
        bound[argument.name] = _argument(argument.value, by_name[argument.name], env)
    _bind_defaults(info, formal, bound, span, env)
    for leaf in info.signature.captures:
        bound[leaf.name] = references.leaf_value(leaf, span, env)
    type_ = flat.Type(flat.Base.FUNCTION, name=info.signature.name)
    return flat.PartialCall(type_, span, info.signature.name, tuple(bound.items()))


def _bind_defaults(
    info: functions.FunctionInfo,
    formal: flat.Type,
    bound: dict[str, flat.Expression],
    span: Span,
    env: Env,
) -> None:
    """Inputs that the formal input does not have get their defaults (12.4.2)."""
    wanted = env.session.formals[formal.name]
    rest = [v for v in info.signature.inputs if v.name not in bound]
    for variable, other in zip(rest, wanted.inputs, strict=False):
        if not base_conforms(variable.type, other.type):
            raise mismatch(other.type, variable.type, f"the input `{variable.name}`", span)
    if len(rest) < len(wanted.inputs):
        raise error(
            "F292",
            f"`{info.name}` has {counted(len(rest), 'open input')}, "
            f"but `{wanted.name}` has {len(wanted.inputs)}",
            span,
        )
    for variable in rest[len(wanted.inputs) :]:
        default = info.signature.defaults.get(variable.name)
        if default is None:
            raise error("F290", f"`{info.name}` needs a value for `{variable.name}`", span)
        expression, scope = default
        locals_ = {**info.signature.constants, **bound}
        bound[variable.name] = expressions.type_expression(
            expression, Env(scope, locals_, env.function)
        )


def _call_of_argument(node: syntax.Call, value: flat.Expression, env: Env) -> flat.Expression:
    """Inside a function: a call of an input that is a function."""
    if value.type.base is not flat.Base.FUNCTION or not isinstance(value, flat.Reference):
        raise not_a_function(node)
    signature = env.session.formals[value.type.name]
    arguments = [expressions.type_expression(a, env) for a in node.arguments]
    by_name = {a.name: a.value for a in node.named}
    for variable in signature.inputs[len(arguments) :]:
        if variable.name not in by_name:
            raise error(
                "F290",
                f"`{node.function}` needs a value for its input `{variable.name}`",
                node.span,
            )
        arguments.append(expressions.type_expression(by_name[variable.name], env))
    return flat.Call(
        signature.result_type(0, arguments, node.span), node.span, value.name, tuple(arguments)
    )


def not_a_function(node: syntax.Call) -> PlanarcError:
    return error("F292", f"`{node.function}` is not a function", node.span)
