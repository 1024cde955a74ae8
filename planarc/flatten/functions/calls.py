"""Calls: built-in operators, record constructors, functions of the model.

In:   syntax.Call, Env
Out:  flat.Builtin, flat.Record or flat.Call with complete arguments

Example: with `function f input Real x; input Real k = 2*x; ... end f;`
    f(3)  becomes  Call("f", (3, 2*3));   f(k=1, x=2)  becomes  Call("f", (2, 1))

Reference: Modelica Language Specification 3.6, sections 8.3.6 to 8.3.8 and 12.3 to 12.6.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.mend import Meant
from planarc.core.nearest import did_you_mean
from planarc.core.prose import counted, ticked
from planarc.core.source import Span
from planarc.flatten.functions import call_arguments, constructors, overloads
from planarc.flatten.functions.values import call_of_argument, function_class
from planarc.flatten.refusal import for_each, unsupported
from planarc.flatten.terms.conform import expect, expect_scalar
from planarc.flatten.terms.constant import to_expression
from planarc.flatten.terms.quotes import meant_as_text
from planarc.flatten.tree import lookup
from planarc.flatten.tree.demand import function_of, layout_of
from planarc.flatten.tree.nodes import Class, Env
from planarc.flatten.tree.predefined import ASSERTION_LEVEL
from planarc.flatten.typing import builtins, comprehension, connections
from planarc.flatten.values import evaluate
from planarc.flatten.values.foreign import LOAD_RESOURCE
from planarc.ir import flat, impact, syntax

_REDUCTIONS = frozenset({"array", "sum", "product", "min", "max"})
_FUNCTION_KINDS = (syntax.ClassKind.FUNCTION, syntax.ClassKind.OPERATOR_FUNCTION)
_CONNECTIONS = "Connections"


def type_call(node: syntax.Call, env: Env, results: bool = False) -> flat.Expression:
    """A call as a value; `results` keeps all results, for the left side of an equation."""
    names = node.function.names
    if len(names) == 1 and not node.function.absolute and names[0] in env.locals:
        return call_of_argument(node, env.locals[names[0]], env)
    if names[0] == _CONNECTIONS and len(names) == 2 and _is_predefined(node.function, env):
        return connections.type_operator(node, env)
    if names == ("pure",):
        return type_call(_called_purely(node), env, results)
    if builtins.is_name(names[-1]) and is_builtin(node.function, env):
        return _builtin(node, env)
    cls = function_class(node.function, env, node)
    if cls.definition.name in ("Integer", "String") and cls.name == cls.definition.name:
        return _builtin(node, env)
    layout = layout_of(cls)
    if layout.kind is syntax.ClassKind.RECORD:
        return constructors.construct_record(node, cls, env)
    if layout.kind is syntax.ClassKind.OPERATOR_RECORD:
        return overloads.construct(node, cls, env)
    if layout.builtin is not None and layout.builtin.literals:
        return constructors.convert_to_enumeration(node, layout.builtin, env)
    if layout.kind not in _FUNCTION_KINDS:
        if layout.builtin is not None and layout.builtin.base is flat.Base.CLOCK:
            return _builtin(node, env)
        message = f"`{node.function}` is a {layout.kind.value}, not a function"
        raise error("F292", message, node.span)
    return _call_function(node, cls, env, results)


def _called_purely(node: syntax.Call) -> syntax.Call:
    """The call in `pure(f(x))`, which allows what is impure wherever it stands (12.3)."""
    if len(node.arguments) == 1 and not node.named and isinstance(node.arguments[0], syntax.Call):
        return node.arguments[0]
    raise error("F290", "`pure` takes one call of a function, as in `pure(f(x))`", node.span)


def _is_predefined(name: syntax.Ref, env: Env) -> bool:
    return name.absolute or lookup.find(env.scope, name.parts[0].name, name.span) is None


def is_builtin(function: syntax.Ref, env: Env) -> bool:
    if len(function.names) > 1:
        return False
    return function.absolute or lookup.find(env.scope, function.names[0], function.span) is None


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
    if name == "String" and (text := overloads.text_of(node, env)) is not None:
        return text
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
            hint = None
            if name in _REDUCTIONS and isinstance(argument.value, syntax.Range) and filled:
                each, values = filled[0].span.text, argument.value.span.text
                hint = f"write `{name}({each} for {argument.name} in {values})`"
            message = f"`{name}` has no argument `{argument.name}`"
            raise error("F290", message, argument.span, hint=hint)
        filled.append(argument.value)
    return filled


def _cardinality(node: syntax.Call, env: Env) -> flat.Expression:
    if node.span.source.name in env.session.own_files():  # who uses a library cannot change it
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


def several_results(
    node: syntax.Call, targets: int, span: Span, env: Env
) -> tuple[flat.Call, list[flat.Type]]:
    """A call that gives values to several targets, and the types of all its results."""
    call = type_call(node, env, results=True)
    if not isinstance(call, flat.Call):
        raise error("F302", f"`{node.function}` has one result only", span)
    types = call_arguments.result_types(call, env)
    if targets > len(types):
        message = f"`{node.function}` has {counted(len(types), 'result')}, not {targets}"
        raise error("F302", message, span)
    return call, types


# Calls that are equations -------------------------------------------------------------


def _arguments(
    call: syntax.Call, names: tuple[str, ...], least: int
) -> list[syntax.Expression | None]:
    found: list[syntax.Expression | None] = [*call.arguments]
    if len(found) > len(names):
        raise error("F290", f"`{call.function}` takes {len(names)} arguments", call.span)
    found += [None] * (len(names) - len(found))
    for named in call.named:
        if named.name not in names:
            message = f"`{call.function}` has no argument `{named.name}`"
            raise error("F290", message, named.span, hint=_arguments_meant(call, named, names))
        found[names.index(named.name)] = named.value
    if any(value is None for value in found[:least]):
        raise error("F290", f"`{call.function}` takes at least {least} arguments", call.span)
    return found


def _arguments_meant(
    call: syntax.Call, named: syntax.NamedArgument, names: tuple[str, ...]
) -> Meant | str:
    """What a user means by an argument of another name; of one that is alone, by an equation."""
    if not call.arguments and len(call.named) == 1 < len(names):
        return f"write `{call.function}({named.name}, {named.value.span.text})`"
    return did_you_mean(named.name, names) or f"its arguments are {ticked(names)}"


def type_assert(call: syntax.Call, env: Env) -> tuple[flat.Assert, ...]:
    condition, message, level = _arguments(call, ("condition", "message", "level"), 2)
    assert condition is not None and message is not None
    typed = env.typed(condition)
    expect_scalar(typed, (flat.Base.BOOLEAN,), "the condition of `assert`")
    text = _message(message, "`assert`", env)
    warning = False
    if level is not None:
        typed_level = env.typed(level)
        expect(ASSERTION_LEVEL, typed_level, "the level of `assert`")
        value = evaluate.structural_value(typed_level, env, "the level of `assert`")
        warning = value == 1
    return (flat.Assert(call.span, env.component, typed, text, warning),)


def type_terminate(call: syntax.Call, env: Env) -> tuple[flat.Terminate, ...]:
    (message,) = _arguments(call, ("message",), 1)
    assert message is not None
    text = _message(message, "`terminate`", env)
    return (flat.Terminate(call.span, env.component, text),)


def _message(message: syntax.Expression, of: str, env: Env) -> flat.Expression:
    try:
        text = env.typed(message)
    except PlanarcError as problem:
        raise meant_as_text(problem, message.span) from None
    expect(flat.STRING, text, f"the message of {of}")
    return text


def type_impact(call: syntax.Call, env: Env) -> tuple[flat.Impact, ...]:
    """`impact(...)` or `crowd(...)`."""
    crowd = call.function.names == ("crowd",)
    names = impact.CROWD_NAMES if crowd else impact.NAMES
    kept = impact.CROWD_KEPT if crowd else impact.KEPT
    found = _arguments(call, names, len(names))
    typed = tuple(env.typed(value) for value in found if value is not None)
    for name, value in zip(names, typed, strict=True):
        bases = impact.BASES.get(name, (flat.Base.REAL,))
        expect_scalar(value, bases, f"`{name}` of `{call.function}`")
        if name in kept and not isinstance(value, flat.Reference):
            raise error("F304", f"`{name}` of `{call.function}` must be a variable", value.span)
    return (flat.Impact(call.span, env.component, typed, crowd),)


def type_reinit(call: syntax.Call, env: Env) -> tuple[flat.Reinit, ...]:
    variable, value = _arguments(call, ("x", "expr"), 2)
    assert variable is not None and value is not None
    target = env.typed(variable)
    typed = env.typed(value)
    expect(target.type, typed, "the new value of `reinit`")
    if not isinstance(target, flat.Reference) or target.type.base is not flat.Base.REAL:
        hint = None
        if isinstance(variable, syntax.Call) and str(variable.function) == "der":
            of = f"`{variable.span.text}`"
            hint = f"{of} follows from the equations: name the variable that says what it is"
        raise error("F304", "`reinit` takes a Real variable", call.span, hint=hint)
    return (flat.Reinit(call.span, env.component, target, typed),)
