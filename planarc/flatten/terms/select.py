"""Picking elements of typed expressions: `(a + b)[2]` becomes `a[2] + b[2]`.

In:   flat.Expression of an array type, indices
Out:  flat.Expression of an element

Reference: Modelica Language Specification 3.6, section 10.5.
"""

from __future__ import annotations

from itertools import product

from planarc.core.source import Span
from planarc.ir import flat

ELEMENTWISE = frozenset({"+", "-", ".+", ".-", ".*", "./", ".^", "and", "or"})
#: built-in operators that act on each element by itself
MAPPED = frozenset({"der", "pre", "noEvent", "edge", "change", "previous"})


def integer(value: int, span: Span) -> flat.Literal:
    return flat.Literal(flat.INTEGER, span, value)


def real(value: float, span: Span) -> flat.Literal:
    return flat.Literal(flat.REAL, span, float(value))


def boolean(value: bool, span: Span) -> flat.Literal:
    return flat.Literal(flat.BOOLEAN, span, value)


def string(value: str, span: Span) -> flat.Literal:
    return flat.Literal(flat.STRING, span, value)


def element_at(expression: flat.Expression, index: int) -> flat.Expression:
    """Entry `index` (from 1) along the first dimension."""
    span = expression.span
    type_ = expression.type.element()
    match expression:
        case flat.Array(items=items):
            return items[index - 1]
        case flat.Reference(name=name, subscripts=subscripts):
            return flat.Reference(type_, span, name, _into(subscripts, index, span))
        case flat.Unary(op=op, operand=operand):
            return flat.Unary(type_, span, op, element_at(operand, index))
        case flat.Binary(op=op, left=left, right=right) if op in ELEMENTWISE or (
            op in ("*", "/") and not (left.type.dims and right.type.dims)
        ):
            return flat.Binary(type_, span, op, _entry(left, index), _entry(right, index))
        case flat.If(branches=branches, otherwise=otherwise):
            picked = tuple([(c, element_at(v, index)) for c, v in branches])
            return flat.If(type_, span, picked, element_at(otherwise, index))
        case flat.Builtin(function=function, arguments=arguments) if function in MAPPED:
            return flat.Builtin(type_, span, function, (element_at(arguments[0], index),))
        case flat.Builtin(function="fill", arguments=(value, _)):
            return value
    return flat.Index(type_, span, expression, (integer(index, span),))


def _entry(expression: flat.Expression, index: int) -> flat.Expression:
    return element_at(expression, index) if expression.type.dims else expression


def _into(subscripts: flat.Expressions, index: int, span: Span) -> flat.Expressions:
    """The index goes into the first subscript that keeps a dimension."""
    for place, subscript in enumerate(subscripts):
        if isinstance(subscript, flat.Slice):
            new: flat.Expression = integer(index, span)
        elif subscript.type.dims:
            new = element_at(subscript, index)
        else:
            continue
        return (*subscripts[:place], new, *subscripts[place + 1 :])
    return (*subscripts, integer(index, span))


def pick(expression: flat.Expression, indices: tuple[int, ...]) -> flat.Expression:
    """The entry at constant indices, one for each leading dimension."""
    for index in indices:
        expression = element_at(expression, index)
    return expression


def subscripted(
    expression: flat.Expression, subscripts: flat.Expressions, span: Span
) -> flat.Expression:
    """Typed subscripts applied; what stays an array keeps its dimension."""
    type_ = expression.type.with_dims(_dims_after(expression.type.dims, subscripts))
    if isinstance(expression, flat.Reference) and not expression.subscripts:
        return flat.Reference(type_, span, expression.name, subscripts)
    constants = [s.value for s in subscripts if isinstance(s, flat.Literal)]
    if len(constants) == len(subscripts):
        return pick(expression, tuple(int(c) for c in constants))
    if isinstance(expression, flat.Reference) and not any(
        isinstance(s, flat.Slice) or s.type.dims for s in expression.subscripts
    ):
        return flat.Reference(type_, span, expression.name, expression.subscripts + subscripts)
    return flat.Index(type_, span, expression, subscripts)


def _dims_after(dims: flat.Dims, subscripts: flat.Expressions) -> flat.Dims:
    kept: list[int | None] = []
    for size, subscript in zip(dims, subscripts, strict=False):
        if isinstance(subscript, flat.Slice):
            kept.append(size)
        elif subscript.type.dims:
            kept.append(subscript.type.dims[0])
    return (*kept, *dims[len(subscripts) :])


def array(items: list[flat.Expression], element: flat.Type, span: Span) -> flat.Array:
    """An array constructor of items of one type."""
    return flat.Array(element.with_dims((len(items), *element.dims)), span, tuple(items))


def opened(expression: flat.Expression) -> list[flat.Expression]:
    """The entries along the first dimension, whose size is known."""
    size = expression.type.dims[0]
    assert size is not None
    return [element_at(expression, i) for i in range(1, size + 1)]


def all_indices(dims: tuple[int, ...]) -> list[tuple[int, ...]]:
    return list(product(*(range(1, d + 1) for d in dims)))
