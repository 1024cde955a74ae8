"""Operators on scalars and arrays (specification 10.6), as scalar expressions."""

from __future__ import annotations

import math

from planarc.core.diagnostic import error
from planarc.core.source import Span
from planarc.ir.expr import Expr, Exprs, brief
from planarc.lower import texts
from planarc.lower.scope import Scope
from planarc.lower.values import Text, Value, expect_fit, expr
from planarc.runtime.tensor import Tensor, each, power, product, shape_of

MAX_PRODUCTS = 10_000_000  # in one product of matrices


def binary(scope: Scope, op: str, a: Value, b: Value, span: Span) -> Value:
    """`op` of `+ - * / ^ .+ .- .* ./ .^ and or`, or a relation."""
    t = scope.table
    expect_fit(op, a, b, span)
    if isinstance(a, Text) and isinstance(b, Text):
        return texts.binary(t, op, a, b, span)
    match op:
        case "+" if isinstance(a, Tensor) and isinstance((*a.items[:1], a)[0], Text):
            return each(lambda x, y: texts.binary(t, op, x, y, span), a, b)
        case "+" | ".+":
            return each(t.add, a, b)
        case "-" | ".-":
            return each(t.sub, a, b)
        case ".*":
            return each(t.mul, a, b)
        case "/" | "./":
            return each(lambda x, y: divide(t, x, y, span), a, b)
        case ".^":
            return each(t.pow, a, b)
        case "*":
            _bound(a, b, span)
            return product(t, a, b)
        case "^":
            return t.pow(expr(a), expr(b)) if not shape_of(a) else _matrix_power(t, a, b, span)
        case "and":
            return each(t.and_, a, b)
        case "or":
            return each(t.or_, a, b)
    return relation(scope, op, expr(a), expr(b), span)


def divide(t: Exprs, a: Expr, b: Expr, span: Span) -> Expr:
    if b.is_const and b.data == 0:
        hint = "correct the divisor, which is 0 at all times"
        raise error("L303", "division by zero", span, hint=hint)
    return t.div(a, b)


def _bound(a: Value, b: Value, span: Span) -> None:
    """Products of huge matrices would take for ever."""
    columns = math.prod(shape_of(b)[1:])
    if math.prod(shape_of(a)) * columns > MAX_PRODUCTS:
        raise error("L313", "a product of such large matrices is not supported", span)


def _matrix_power(t: Exprs, a: Value, b: Value, span: Span) -> Value:
    exponent = expr(b)
    whole = exponent.is_const and exponent.data >= 0 and float(exponent.data).is_integer()
    if not whole or not isinstance(a, Tensor):
        hint = None
        if isinstance(a, Tensor) and exponent.is_const and exponent.data < 0:
            hint = (
                "solve for the inverse: in the place of `x = A^(-1)*b` write `A*x = b`; the matrix "
            )
            hint += "`X` itself follows from `A*X = identity(n)`"
        message = "the power of a matrix needs a constant whole exponent that is not negative"
        raise error("L304", message, span, hint=hint)
    return power(t, a, int(exponent.data))


def _written(span: Span, plain: Expr) -> str:
    """A relation as the user wrote it; the span of `(a + b) > c` begins behind the parenthesis."""
    text = span.text
    return text if text and text.count("(") == text.count(")") else brief(plain)


def relation(scope: Scope, op: str, a: Expr, b: Expr, span: Span) -> Expr:
    """`a op b`: a stored truth where a switch makes an event, else evaluated in place."""
    t = scope.table
    if op in (">", ">="):
        a, b, op = b, a, {">": "<", ">=": "<="}[op]
    if op == "==":
        return t.equal(a, b)
    if op == "<>":
        return t.not_(t.equal(a, b))
    plain = t.less(a, b) if op == "<" else t.less_equal(a, b)
    if plain.is_const or not scope.events or scope.at_event or scope.model.is_steady(plain):
        return plain
    return scope.model.relation(t.sub(a, b), op == "<", _written(span, plain), span)
