"""Functions as values: handed to a function by name, or with some inputs bound.

Example: `trapezoid(function power(n=2), 0, 1)` binds `n`; the open input of `power` is
the one that the formal input of `trapezoid` declares.

Reference: Modelica Language Specification 3.6, section 12.4.2.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec.structs import replace

from planarc.core.diagnostic import Once, PlanarcError, error, said
from planarc.core.mend import Meant
from planarc.core.nearest import did_you_mean
from planarc.core.prose import both, counted, ticked
from planarc.core.source import Span
from planarc.flatten.functions import constructors
from planarc.flatten.functions.variables import result_type
from planarc.flatten.terms.conform import base_conforms, expect, mismatch
from planarc.flatten.tree import lookup, naming
from planarc.flatten.tree.demand import function_of
from planarc.flatten.tree.nodes import (
    RECORD_KINDS,
    Class,
    Env,
    Family,
    FunctionInfo,
    Instance,
    Leaf,
    Signature,
)
from planarc.flatten.typing import builtins, references
from planarc.ir import flat, syntax

_INTEGRAL = "write `der(y) = x` for the integral y of x"
#: What is said in another way than by a function.
_OTHERWISE = {
    **dict.fromkeys(("integral", "integrate", "int"), _INTEGRAL),
    **dict.fromkeys(("length", "len", "numel"), "write `size(x, 1)`"),
    **{
        f"{f}d": f"write `{f}(Modelica.Units.Conversions.from_deg(x))`"
        for f in ("sin", "cos", "tan")
    },
    **dict.fromkeys(("norm", "magnitude"), "write `sqrt(x*x)` for the length of a vector x"),
    **dict.fromkeys(
        ("saturate", "saturation", "sat", "clip", "clamp", "limit", "constrain"),
        "write `min(max(x, lower), upper)`",
    ),
    "experiment": "write `annotation(experiment(...));`",
    **dict.fromkeys(("diff", "derivative", "ddt", "d"), "write `der(x)`"),
}

#: What is written as a call and is none.
_STATEMENTS = ("annotation", "connect")


def function_class(ref: syntax.Ref, env: Env, call: syntax.Call | None = None) -> Class:
    """The class that the name of a called function means; `call` is the call, if it is one."""
    if lookup.find(env.scope, ref.parts[0].name, ref.span) is None and not ref.absolute:
        if len(ref.parts) == 1:
            names = [*builtins.names(), *naming.names_in_sight(env.scope), *_STATEMENTS]
            hint = _OTHERWISE.get(ref.parts[0].name) or did_you_mean(ref.parts[0].name, names)
            mend = hint if isinstance(hint, Meant) else None
            told = f"unknown function `{ref}`"
            kind = f"{env.scope.instance.cls.name} {ref}"  # a name that is used is used again
            raise PlanarcError(Once("F210", told, ref.span, hint=said(hint), mend=mend, kind=kind))
        raise lookup.unknown(env.scope, ref.parts[0].name, ref.span)
    try:
        view = references.resolve(ref, env)
    except PlanarcError:
        _refuse_method(ref, env)
        raise
    if isinstance(view, Class):
        return view
    if isinstance(view, Leaf | Instance | Family):
        hint = _meant_by_a_call(ref, view, call)
        raise error("F292", f"`{ref}` is a component, not a function", ref.span, hint=hint)
    raise error("F292", f"`{ref}` is not a function", ref.span)


def _meant_by_a_call(
    ref: syntax.Ref, view: Leaf | Instance | Family, call: syntax.Call | None
) -> str:
    """What a user means who calls a component; a record, to change some of its fields."""
    if not isinstance(view, Instance):
        hint = f"for a start value write `{ref}(start=...)` where it is declared, "
        return f"{hint}for an entry `{ref}[...]`, for a product `{ref}*(...)`"
    if view.layout.kind not in RECORD_KINDS or call is None:
        return f"write what you change of it where it is declared: `{ref}(...)`"
    fields = constructors.inputs_of(view.cls)
    given = dict(zip(fields, (a.span.text for a in call.arguments), strict=False))
    given |= {a.name: a.value.span.text for a in call.named}
    declared = view.element and view.element.definition
    own = isinstance(declared, syntax.Component) and len(ref.parts) == 1
    name = declared.type if own else view.cls.name  # type: ignore[union-attr]
    if len(fields) > _MOST_FIELDS:
        written = ", ".join(f"{n}={value}" for n, value in given.items())
        kept = next((n for n in fields if n not in given), fields[0])
        return f"write `{name}({written}, ...)` with its other fields as in `{kept}={ref}.{kept}`"
    written = ", ".join(f"{n}={given.get(n, f'{ref}.{n}')}" for n in fields)
    return f"write `{name}({written})`"


_MOST_FIELDS = 6  # that a hint writes out


def _refuse_method(ref: syntax.Ref, env: Env) -> None:
    """Explain `x.sum()`: functions take what they are applied to in parentheses."""
    name = ref.parts[-1].name
    if len(ref.parts) == 1 or not (name in _OTHERWISE or builtins.is_name(name)):
        return
    owner = replace(ref, parts=ref.parts[:-1])
    view = references.resolve(owner, env)
    if not isinstance(view, Class):
        hint = _OTHERWISE.get(name) or f"write `{name}({owner})`"
        raise error("F292", f"`{ref}` is no function: variables have none", ref.span, hint=hint)


def type_argument(
    argument: syntax.Expression, variable: flat.Variable, env: Env
) -> flat.Expression:
    """The value given for an input, which may be a function itself."""
    if variable.type.base is flat.Base.FUNCTION:
        return function_value(argument, variable.type, env)
    return env.typed(argument)


def default_of(
    signature: Signature, variable: flat.Variable, known: flat.Named, env: Env
) -> flat.Expression | None:
    """The default of an input, with the values of the inputs that are known so far."""
    default = signature.defaults.get(variable.name)
    if default is None:
        return None
    expression, scope = default
    inner = Env(scope, {**signature.constants, **known}, env.function)
    return type_argument(expression, variable, inner)


def in_order_of_defaults(
    signature: Signature, inputs: Sequence[flat.Variable]
) -> list[flat.Variable]:
    """Inputs, each after those that its default is written with, in whatever order they stand."""
    places = {name: k for k, name in enumerate(signature.defaults)}  # made in that order
    return sorted(inputs, key=lambda v: places.get(v.name, -1))


def input_of(
    inputs: dict[str, flat.Variable], name: str, function: syntax.Ref, span: Span
) -> flat.Variable:
    """The input of that name."""
    if name not in inputs:
        message = f"`{function}` has no input `{name}`"
        hint = did_you_mean(name, inputs) or (
            f"its {'input is' if len(inputs) == 1 else 'inputs are'} {ticked(inputs)}"
            if inputs
            else None
        )
        raise error("F290", message, span, hint=hint)
    return inputs[name]


def missing_input(node: syntax.Call, variable: flat.Variable) -> PlanarcError:
    message = f"`{node.function}` needs a value for its input `{variable.name}`"
    return error("F290", message, node.span)


def function_value(argument: syntax.Expression, formal: flat.Type, env: Env) -> flat.Expression:
    """A function given to a function: its name, or `function f(a=1)`."""
    if isinstance(argument, syntax.PartialApplication):
        name, *others = argument.function.names
        passed = None if others else env.locals.get(name)
        if passed is not None and passed.type.base is flat.Base.FUNCTION:
            return _bound_further(argument, passed.type.name, formal, env)
        return _partial_call(argument.function, argument.named, argument.span, formal, env)
    if not isinstance(argument, syntax.Ref):
        raise error("F292", "this input needs a function", argument.span)
    if argument.parts[0].name in env.locals:
        value = env.locals[argument.parts[0].name]
        expect(flat.Type(flat.Base.FUNCTION), value, f"`{argument}`")
        return value
    return _partial_call(argument, (), argument.span, formal, env)


def _bound_further(
    node: syntax.PartialApplication, own: str, formal: flat.Type, env: Env
) -> flat.Expression:
    """A function that was handed in, handed on with more of its inputs bound."""
    signature = env.session.formals[own]
    by_name = {v.name: v for v in signature.inputs}
    bound: flat.Named = {}
    for argument in node.named:
        variable = input_of(by_name, argument.name, node.function, argument.span)
        bound[argument.name] = type_argument(argument.value, variable, env)
    name = str(node.function)
    _bind_defaults(FunctionInfo(name, signature, {}), formal, bound, node.span, env)
    type_ = flat.Type(flat.Base.FUNCTION, name=own)
    return flat.PartialCall(type_, node.span, name, tuple(bound.items()), tuple(by_name))


def _partial_call(
    ref: syntax.Ref,
    named: tuple[syntax.NamedArgument, ...],
    span: Span,
    formal: flat.Type,
    env: Env,
) -> flat.Expression:
    """The function with all its inputs bound but for those of the formal input."""
    info = function_of(function_class(ref, env), span)
    by_name = {v.name: v for v in info.signature.inputs}
    bound: flat.Named = {}
    for argument in named:
        variable = input_of(by_name, argument.name, ref, argument.span)
        bound[argument.name] = type_argument(argument.value, variable, env)
    _bind_defaults(info, formal, bound, span, env)
    for leaf in info.signature.captures.values():
        bound[leaf.name] = references.leaf_value(leaf, span, env)
    type_ = flat.Type(flat.Base.FUNCTION, name=info.signature.name)
    return flat.PartialCall(type_, span, info.signature.name, tuple(bound.items()))


def _bind_defaults(
    info: FunctionInfo, formal: flat.Type, bound: flat.Named, span: Span, env: Env
) -> None:
    """Inputs that the formal input does not have get their defaults (12.4.2)."""
    name, wanted = info.name, env.session.formals[formal.name]
    rest = [v for v in info.signature.inputs if v.name not in bound]
    for variable, other in zip(rest, wanted.inputs, strict=False):
        if not base_conforms(variable.type, other.type):
            raise mismatch(other.type, variable.type, f"the input `{variable.name}`", span)
    count = len(wanted.inputs)
    if len(rest) < count:
        own = f"`{name}` has {counted(len(rest), 'open input')}"
        raise error("F292", f"{own}, but `{wanted.name}` has {count}", span)
    for variable in in_order_of_defaults(info.signature, rest[count:]):
        value = _own_default(info, variable, bound, env)
        if value is None:
            message = f"`{name}` needs a value for `{variable.name}`"
            hint = _hint_to_bind(info, rest[:count], span)
            raise error("F290", message, span, hint=hint)
        bound[variable.name] = value


def _own_default(
    info: FunctionInfo, variable: flat.Variable, known: flat.Named, env: Env
) -> flat.Expression | None:
    """The value that `function g = f(x=5)` gives an input, or its default."""
    own = info.bound.get(variable.name)
    if own is not None:
        return Env(own.scope, {}, env.function).typed(own.expression)
    return default_of(info.signature, variable, known, env)


def _hint_to_bind(info: FunctionInfo, taken: Sequence[flat.Variable], span: Span) -> str | None:
    """What keeps the inputs for which `function g = f(x=5)` has values from taking arguments."""
    own = [v.name for v in taken if v.name in info.bound]
    if not own or " " in span.text:
        return None
    values = (f"{name}={info.bound[name].expression.span.text}" for name in own)
    return f"write `function {span.text}({', '.join(values)})`, which leaves {both(own)} as it is"


def call_of_argument(node: syntax.Call, value: flat.Expression, env: Env) -> flat.Expression:
    """A call, inside a function, of an input that is a function."""
    if value.type.base is not flat.Base.FUNCTION or not isinstance(value, flat.Reference):
        raise error("F292", f"`{node.function}` is not a function", node.span)
    signature = env.session.formals[value.type.name]
    arguments = [env.typed(a) for a in node.arguments]
    by_name = {a.name: a.value for a in node.named}
    for variable in signature.inputs[len(arguments) :]:
        if variable.name not in by_name:
            raise missing_input(node, variable)
        arguments.append(env.typed(by_name[variable.name]))
    type_ = result_type(signature, 0, arguments, node.span, env.session)
    return flat.Call(type_, node.span, value.name, tuple(arguments))
