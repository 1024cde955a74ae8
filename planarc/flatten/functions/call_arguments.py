"""Arguments of a call: one for each input, positional, named, bound or by default.

With arrays in the place of scalars the function is called for each entry.

Reference: Modelica Language Specification 3.6, sections 12.4.1 and 12.4.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.prose import counted, either, listed
from planarc.core.source import Span
from planarc.flatten.functions.values import (
    default_of,
    in_order_of_defaults,
    input_of,
    missing_input,
    type_argument,
)
from planarc.flatten.functions.variables import result_type, type_at_call
from planarc.flatten.refusal import for_each
from planarc.flatten.terms.conform import base_conforms, conforms, dims_conform, expect, mismatch
from planarc.flatten.terms.select import array, integer, opened, subscripted
from planarc.flatten.tree.demand import layout_of
from planarc.flatten.tree.lookup import find_class
from planarc.flatten.tree.nodes import Binding, Env, FunctionInfo
from planarc.flatten.typing import references
from planarc.flatten.typing.modifiers import type_binding
from planarc.ir import flat, syntax


def complete_arguments(info: FunctionInfo, node: syntax.Call, env: Env) -> list[flat.Expression]:
    """One argument for each input: positional, named, bound, default."""
    signature = info.signature
    values = _given(info, node, env)
    for variable in signature.inputs:
        if variable.name not in values and variable.name in info.bound:
            values[variable.name] = _bound(info.bound[variable.name], env)
        elif variable.name not in values and variable.name not in signature.defaults:
            raise missing_input(node, variable)
    for variable in in_order_of_defaults(signature, signature.inputs):
        if variable.name not in values:
            value = default_of(signature, variable, values, env)
            assert value is not None
            values[variable.name] = value
    return [values[variable.name] for variable in signature.inputs]


def _given(info: FunctionInfo, node: syntax.Call, env: Env) -> flat.Named:
    """The inputs that the call gives: what `function g = f(x=5)` binds is a default (12.4.1)."""
    by_name = {v.name: v for v in info.signature.inputs}
    if len(node.arguments) > len(by_name):
        takes = f"`{node.function}` takes {counted(len(by_name), 'argument')}"
        hint = _plain_variables(node, env)
        raise error("F290", f"{takes}, not {len(node.arguments)}", node.span, hint=hint)
    pairs = list(zip(by_name.values(), node.arguments, strict=False))
    values = for_each(pairs, lambda pair: type_argument(pair[1], pair[0], env))
    given = {v.name: value for (v, _), value in zip(pairs, values, strict=True)}
    for named in node.named:
        variable = input_of(by_name, named.name, node.function, named.span)
        if named.name in given:
            raise error("F290", f"the input `{named.name}` is given twice", named.span)
        given[named.name] = type_argument(named.value, variable, env)
    return given


def _plain_variables(node: syntax.Call, env: Env) -> str | None:
    """The hint for a function whose variables were declared without `input`."""
    layout = layout_of(find_class(env.scope, node.function))
    plain = [
        name
        for name, (part, d) in layout.members.items()
        if isinstance(d, syntax.Component)
        and d.causality is syntax.Causality.NONE
        and d.variability is syntax.Variability.CONTINUOUS
        and not (d.prefixes.protected or layout.parts[part].protected)
    ]
    return f"write `input` before {either(plain)}, if that is an argument" if plain else None


def _bound(bound: Binding, env: Env) -> flat.Expression:
    """The value that `function g = f(x=5)` gives an input."""
    if env.function is None:
        return type_binding(bound)
    return Env(bound.scope, {}, env.function).typed(bound.expression)


_MOST_ORDERED = 5  # inputs whose orders are tried


def vectorised(
    info: FunctionInfo, arguments: list[flat.Expression], span: Span, env: Env, results: bool
) -> flat.Expression:
    """The call; with arrays in place of scalars, one call for each entry (12.4.6)."""
    inputs = info.signature.inputs
    if not info.signature.outputs and not results:
        hint = "declare its result as an `output`, outside of `protected`"
        raise error("F290", f"`{info.name}` has no result", span, hint=hint)
    pairs = [*zip(inputs, arguments, strict=True)]
    more = [len(a.type.dims) - len(v.type.dims) for v, a in pairs]
    fits = (base_conforms(v.type, a.type) for v, a in pairs)
    extra = max((m for m, fit in zip(more, fits, strict=True) if fit), default=0)
    if extra <= 0 or results:
        return _single(info, arguments, span, env, results)
    places = [k for k, m in enumerate(more) if m == extra]
    sizes = [arguments[k].type.dims[0] for k in places]
    size = sizes[0]
    if size is None or None in sizes:
        return _for_each_entry(info, arguments, places, span, env)
    if any(other != size for other in sizes):
        raise error("F291", f"the arrays given to `{info.name}` differ in size", span)
    columns = [opened(a) if k in places else [a] * size for k, a in enumerate(arguments)]
    items = [vectorised(info, list(row), span, env, False) for row in zip(*columns, strict=True)]
    element = (
        items[0].type if items else result_type(info.signature, 0, arguments, span, env.session)
    )
    return array(items, element, span)


def _for_each_entry(
    info: FunctionInfo, arguments: list[flat.Expression], places: list[int], span: Span, env: Env
) -> flat.Expression:
    """`{f(x) for x in v}`, where sizes are known only when a function runs; of several
    arrays `{f(x[i], z[i]) for i in 1:size(x, 1)}`."""
    first = next(a for k, a in enumerate(arguments) if k in places and a.type.dims[0] is None)
    name = "entry"
    while name in env.locals:
        name += "_"
    alone = len(places) == len(first.type.dims) == 1
    entry = flat.Reference(first.type.element() if alone else flat.INTEGER, span, name)
    domain = first if alone else _numbers(first, span)
    entries = [
        a if k not in places else entry if alone else subscripted(a, (entry,), span)
        for k, a in enumerate(arguments)
    ]
    inner = vectorised(info, entries, span, env.with_local(name, entry), False)
    type_ = inner.type.with_dims((None, *inner.type.dims))
    alike = () if alone else tuple(arguments[k] for k in places)
    return flat.Comprehension(type_, span, inner, ((name, domain),), alike=alike)


def _numbers(array: flat.Expression, span: Span) -> flat.Expression:
    """`1:size(array, 1)`."""
    size = flat.Builtin(flat.INTEGER, span, "size", (array, integer(1, span)))
    return flat.Range(flat.INTEGER.with_dims((None,)), span, integer(1, span), None, size)


def _single(
    info: FunctionInfo, arguments: list[flat.Expression], span: Span, env: Env, results: bool
) -> flat.Expression:
    inputs = info.signature.inputs
    for variable, argument in zip(inputs, arguments, strict=True):
        what = f"the input `{variable.name}` of `{info.name}`"
        try:
            expect(variable.type, argument, what)
        except PlanarcError as problem:
            if not _fit_otherwise(inputs, arguments):
                raise
            order = listed(f"`{v.name}` ({v.type.base.value})" for v in inputs)
            hint = f"the inputs are, in this order, {order}"
            raise PlanarcError(replace(problem.diagnostics[0], hint=hint)) from None
    _check_sizes(info, arguments, env)
    type_ = flat.Type(flat.Base.RECORD, name="(results)")
    if info.signature.outputs:
        type_ = result_type(info.signature, 0, arguments, span, env.session)
    captured = [references.leaf_value(leaf, span, env) for leaf in info.signature.captures.values()]
    return flat.Call(
        type_, span, info.signature.name, (*arguments, *captured), None if results else 0
    )


def _check_sizes(info: FunctionInfo, arguments: Sequence[flat.Expression], env: Env) -> None:
    """Refuse an array of another size than the other arguments say (12.4.1), where it is known."""
    for variable, argument in zip(info.signature.inputs, arguments, strict=True):
        wanted = type_at_call(variable, info.signature, arguments, env.session)
        if dims_conform(wanted.dims, argument.type.dims):
            continue
        told = (
            f"`{size.span.text}` is {n}"
            for size, n in zip(variable.sizes, wanted.dims, strict=True)
            if size is not None and n is not None
        )
        found = mismatch(
            wanted, argument.type, f"the input `{variable.name}` of `{info.name}`", argument.span
        )
        hint = f"with these arguments, {listed(list(dict.fromkeys(told)))}"
        raise PlanarcError(replace(found.diagnostics[0], hint=hint))


def _fit_otherwise(inputs: Sequence[flat.Variable], arguments: Sequence[flat.Expression]) -> bool:
    """Whether arguments that do not fit would do in another order."""
    if len(inputs) > _MOST_ORDERED:
        return False
    return any(
        all(conforms(v.type, a.type) for v, a in zip(inputs, order, strict=True))
        for order in permutations(arguments)
    )


def result_types(call: flat.Call, env: Env) -> list[flat.Type]:
    """The types of all results of a call."""
    signature = env.session.signatures[call.function]
    arguments = list(call.arguments[: len(signature.inputs)])
    return [
        result_type(signature, k, arguments, call.span, env.session)
        for k in range(len(signature.outputs))
    ]
