"""Operators of operator records: functions that their classes name so.

In:   an operator and typed operands, of which one is an operator record; a constructor's call
Out:  the call of a function of the record's class

Example: with `operator record Complex ... encapsulated operator '*' function multiply ...`
    2*z   becomes   Complex.'*'.multiply(Complex.'constructor'.fromReal(2), z)

Functions are tried in their order. Where none takes the operands as they are, what is no such
record becomes one by a constructor that takes it alone. Arrays are taken entry by entry, as by
`+`, `.*` or a number before a vector; matrices are multiplied by sums of products.

Reference: Modelica Language Specification 3.6, chapter 14.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.functions import constructors
from planarc.flatten.functions.call_arguments import vectorised
from planarc.flatten.functions.values import default_of, in_order_of_defaults
from planarc.flatten.terms.conform import base_conforms, conforms, dims_conform, type_text
from planarc.flatten.terms.select import array, opened
from planarc.flatten.tree import lookup
from planarc.flatten.tree.demand import class_of, function_of, layout_of, static_instance
from planarc.flatten.tree.nodes import Class, Env, FunctionInfo
from planarc.ir import flat, syntax

_FUNCTIONS = (syntax.ClassKind.FUNCTION, syntax.ClassKind.OPERATOR_FUNCTION)
_REDUCED = {"sum": "+", "product": "*"}
_BY_ENTRY = {".+": "+", ".-": "-", ".*": "*", "./": "/", ".^": "^"}


def operate(
    op: str, operands: tuple[flat.Expression, ...], span: Span, env: Env
) -> flat.Expression:
    """What an operator gives, of one operand or two; of `sum` and `product` the one is an array."""
    if op in _REDUCED:
        return _reduced(op, operands[0], span, env)
    if op in ("+", ".+") and len(operands) == 1:
        return operands[0]
    for given in _ways(operands, span, env):
        found = _called(op, given, span, env)
        if found is not None:
            return found
    raise _unknown(op, operands, span, env)


def _unknown(op: str, operands: Sequence[flat.Expression], span: Span, env: Env) -> PlanarcError:
    told = " and ".join(type_text(o.type) for o in operands)
    verb = "join" if len(operands) > 1 else "be applied to"
    cls = next(c for o in operands if (c := _class_of(o, env)) is not None)
    known = any(True for _ in _functions(cls, _BY_ENTRY.get(op, op), span))
    hint = None if known else f"give `{cls.name}` a function for it, in `operator '{op}'`"
    return error("F274", f"`{op}` cannot {verb} {told}", span, hint=hint)


def _ways(
    operands: tuple[flat.Expression, ...], span: Span, env: Env
) -> Iterator[tuple[flat.Expression, ...]]:
    """The operands as they are, and then all as operator records."""
    yield operands
    records = [c for o in operands if (c := _class_of(o, env)) is not None]
    others = [o for o in operands if _class_of(o, env) is None]
    if others and records:
        made = {id(o): _converted(o, records[0], span, env) for o in others}
        if None not in made.values():
            yield tuple(made.get(id(o)) or o for o in operands)


def _class_of(value: flat.Expression, env: Env) -> Class | None:
    """The operator record of which a value is, or an array's entries are."""
    if value.type.base is not flat.Base.RECORD:
        return None
    return env.session.operator_records.get(value.type.name)


def _converted(value: flat.Expression, cls: Class, span: Span, env: Env) -> flat.Expression | None:
    """A value as such a record, by the constructor that takes it alone."""
    for info in _functions(cls, "constructor", span):
        (first, *rest) = info.signature.inputs or (None,)
        if first is None or not base_conforms(first.type, value.type) or first.type.dims:
            continue
        if all(v.name in info.signature.defaults for v in rest):
            return _call(info, {first.name: value}, span, env)
    return None


def _functions(cls: Class, operator: str, span: Span) -> Iterator[FunctionInfo]:
    """The functions by which a record overloads an operator."""
    element = lookup.member(static_instance(cls), f"'{operator}'")
    if element is None or not element.is_class:
        return
    held = class_of(element, span)
    if layout_of(held).kind in _FUNCTIONS:
        yield function_of(held, span)
        return
    for name, (_, definition) in layout_of(held).members.items():
        if isinstance(definition, syntax.ClassDef) and definition.kind in _FUNCTIONS:
            yield function_of(class_of(lookup.declared(static_instance(held), name), span), span)


def _called(
    op: str, operands: tuple[flat.Expression, ...], span: Span, env: Env
) -> flat.Expression | None:
    """The call of the function that takes the operands, or the entries of arrays."""
    classes = dict.fromkeys(c for o in operands if (c := _class_of(o, env)) is not None)
    infos = [i for c in classes for i in _functions(c, _BY_ENTRY.get(op, op), span)]
    if op not in _BY_ENTRY:
        for info in infos:
            if _takes(info, operands, conforms):
                return _call(info, _in_order(info, operands), span, env)
    arrays = [o.type.dims for o in operands if o.type.dims]
    if op == "*" and len(arrays) == 2:
        left, right = operands
        return _product(left, right, span, env)
    alone = op not in _BY_ENTRY and len(arrays) < len(operands)  # a number beside an array
    if not arrays or (alone and (op != "*" and (op != "/" or operands[-1].type.dims))):
        return None
    if all(dims_conform(arrays[0], dims) for dims in arrays):
        for info in infos:
            if _takes(info, operands, lambda t, a: not t.dims and base_conforms(t, a)):
                return _call(info, _in_order(info, operands), span, env)
    return None


def _product(
    a: flat.Expression, b: flat.Expression, span: Span, env: Env
) -> flat.Expression | None:
    """A product of vectors and matrices of known sizes (10.6.4)."""
    sizes = (*a.type.dims, *b.type.dims)
    if None in sizes or 0 in sizes or a.type.dims[-1] != b.type.dims[0]:
        return None
    if len(a.type.dims) > 1:
        return _side_by_side([operate("*", (row, b), span, env) for row in opened(a)], span)
    if len(b.type.dims) > 1:
        columns = zip(*map(opened, opened(b)), strict=True)
        vectors = [_side_by_side(list(column), span) for column in columns]
        return _side_by_side([operate("*", (a, v), span, env) for v in vectors], span)
    products = [operate("*", pair, span, env) for pair in zip(opened(a), opened(b), strict=True)]
    return _joined("+", products, span, env)


def _joined(op: str, terms: Sequence[flat.Expression], span: Span, env: Env) -> flat.Expression:
    return reduce(lambda a, b: operate(op, (a, b), span, env), terms)


def _reduced(name: str, value: flat.Expression, span: Span, env: Env) -> flat.Expression:
    """The sum or the product of all entries (10.3.4); that of none is the operator `'0'`."""
    entries = [value]
    for size in value.type.dims:
        if size is None:
            message = f"`{name}` of operator records needs a size that is known when compiling"
            raise error("F291", message, span)
        entries = [e for row in entries for e in opened(row)]
    cls = _class_of(value, env)
    if not entries and cls is not None and name == "sum":
        for info in _functions(cls, "0", span):
            return _call(info, {}, span, env)
    if not entries:
        raise _unknown(name, (value,), span, env)
    return _joined(_REDUCED[name], entries, span, env)


def _side_by_side(items: list[flat.Expression], span: Span) -> flat.Expression:
    return array(items, items[0].type, span)


# Constructors and texts ---------------------------------------------------------------------


def construct(node: syntax.Call, cls: Class, env: Env) -> flat.Expression:
    """`Complex(1, im=2)`, by a constructor of the record's own, or field by field."""
    for info in _functions(cls, "constructor", node.span):
        names = [v.name for v in info.signature.inputs]
        if len(node.arguments) > len(names) or not {n.name for n in node.named} <= {*names}:
            continue
        given = {n: env.typed(a) for n, a in zip(names, node.arguments, strict=False)}
        given |= {n.name: env.typed(n.value) for n in node.named}
        if _is_call(info, given):
            return _call(info, given, node.span, env)
    return constructors.construct_record(node, cls, env)


def text_of(node: syntax.Call, env: Env) -> flat.Expression | None:
    """`String(z)` of an operator record; None of anything else."""
    value = env.typed(node.arguments[0]) if node.arguments else None
    cls = None if value is None or value.type.dims else _class_of(value, env)
    if value is None or cls is None:
        return None
    for info in _functions(cls, "String", node.span):
        names = [v.name for v in info.signature.inputs]
        given = {n: env.typed(a) for n, a in zip(names, node.arguments, strict=False)}
        given |= {n.name: env.typed(n.value) for n in node.named}
        if len(node.arguments) <= len(names) and _is_call(info, given):
            return _call(info, given, node.span, env)
    raise _unknown("String", (value,), node.span, env)


# Calls ------------------------------------------------------------------------------------------


def _takes(
    info: FunctionInfo,
    operands: Sequence[flat.Expression],
    fits: Callable[[flat.Type, flat.Type], bool],
) -> bool:
    """Whether a function takes some operands in this order."""
    first, rest = info.signature.inputs[: len(operands)], info.signature.inputs[len(operands) :]
    return (
        len(first) == len(operands)
        and all(fits(v.type, o.type) for v, o in zip(first, operands, strict=True))
        and all(v.name in info.signature.defaults for v in rest)
    )


def _is_call(info: FunctionInfo, given: flat.Named) -> bool:
    """Whether inputs are given values of their kinds, and no other is missing."""
    inputs = {v.name: v for v in info.signature.inputs}
    return (
        all(
            base_conforms(v.type, given[n].type) if n in given else n in info.signature.defaults
            for n, v in inputs.items()
        )
        and given.keys() <= inputs.keys()
    )


def _in_order(info: FunctionInfo, operands: Sequence[flat.Expression]) -> flat.Named:
    return {v.name: o for v, o in zip(info.signature.inputs, operands, strict=False)}


def _call(info: FunctionInfo, values: flat.Named, span: Span, env: Env) -> flat.Expression:
    signature, values = info.signature, dict(values)
    for variable in in_order_of_defaults(signature, signature.inputs):
        if variable.name not in values:
            value = default_of(signature, variable, values, env)
            assert value is not None, f"`{variable.name}` has a default"
            values[variable.name] = value
    return vectorised(info, [values[v.name] for v in signature.inputs], span, env, False)
