"""Operators: the type of `a op b` and what it does with arrays.

In:   an operator, typed operands
Out:  a typed node

Reference: Modelica Language Specification 3.6, sections 3.4, 3.5, 10.4 and 10.6.
"""

from __future__ import annotations

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.terms.conform import (
    NUMERIC,
    dims_conform,
    no_scalar,
    type_text,
    unify,
    unify_dims,
)
from planarc.flatten.tree.nodes import Env
from planarc.flatten.values import evaluate
from planarc.ir import flat

_RELATIONS = frozenset({"<", "<=", ">", ">=", "==", "<>"})
_DOTTED = {".+": "+", ".-": "-", ".*": "*", "./": "/", ".^": "^"}


def unary(op: str, operand: flat.Expression, span: Span) -> flat.Expression:
    base = operand.type.base
    if op == "not":
        if base is not flat.Base.BOOLEAN:
            raise _wrong("not", operand, span)
        return flat.Unary(operand.type, span, "not", operand)
    if base not in NUMERIC:
        raise _wrong(op, operand, span)
    if op in ("+", ".+"):
        return operand
    if isinstance(operand, flat.Literal):
        assert not isinstance(operand.value, str)
        return flat.Literal(operand.type, span, -operand.value)
    return flat.Unary(operand.type, span, "-", operand)


def _wrong(op: str, operand: flat.Expression, span: Span) -> PlanarcError:
    return error("F274", f"`{op}` cannot be applied to {type_text(operand.type)}", span)


def binary(op: str, left: flat.Expression, right: flat.Expression, span: Span) -> flat.Expression:
    if op in _RELATIONS:
        return _relation(op, left, right, span)
    if op in ("and", "or"):
        return _logical(op, left, right, span)
    return _arithmetic(op, left, right, span)


def _mismatch(op: str, left: flat.Expression, right: flat.Expression, span: Span) -> PlanarcError:
    hint = None
    plain = not left.type.dims or not right.type.dims
    if op in ("+", "-") and plain and left.type.dims != right.type.dims:
        number = right if left.type.dims else left
        hint = f"write `.{op}` if the number `{number.span.text}` is meant for each element"
        vector = _only_vector(left if left.type.dims else right)
        if vector is not None:
            name = vector.span.text
            hint = f"write `{name}[1]` or `{name}[2]` for one element, `.{op}` if the number "
            hint += f"`{number.span.text}` is meant for both"
    if flat.Base.STRING in (left.type.base, right.type.base) and op == "+":
        number = right if left.type.base is flat.Base.STRING else left
        hint = f"write `String({number.span.text})` to make it a text"
    sizes = left.type.dims[-1:], right.type.dims[:1]
    if op == "*" and all(sizes) and not dims_conform(*sizes) and len(right.type.dims) < 3:
        columns, rows = sizes[0][0], sizes[1][0]
        hint = (
            f"a product sums over columns of the first ({columns}) and rows of the second ({rows})"
        )
        if dims_conform(left.type.dims[:1], right.type.dims[:1]) and len(left.type.dims) == 2:
            hint += f"; `transpose({left.span.text})` would fit"
    column = next((x for x in (left, right) if x.type.dims[1:] == (1,)), None)
    if op in ("+", "-") and column is not None and 1 in (len(left.type.dims), len(right.type.dims)):
        hint = f"a matrix of one column is no vector: write `vector({column.span.text})`"
    named = next((x for x in (left, right) if x.type.literals), None)
    if named is not None and op in _RELATIONS:
        written = right if named is left else left
        hint = f"compare with a value by its name, such as `{_literal(named.type, written)}`"
    if op in _RELATIONS and left.type.base in NUMERIC and right.type.base in NUMERIC:
        hint = _one_of_each(op, left, right)
    if op == "/" and len(right.type.dims) == 2 and left.type.dims:
        hint = "write an equation for the unknown: `A*x = b` solves for the vector `x`"
    elif op == "/" and right.type.dims:
        hint = "write `./` to divide entry by entry"
    if op == "^" and left.type.dims:
        hint = "write `.^` for the power of each entry"
        if len(left.type.dims) == 1 and isinstance(right, flat.Literal) and right.value == 2:
            base = left.span.text
            hint = (
                f"write `{base}*{base}` for the square of its length, `.^` for that of each entry"
            )
    truth = next((x for x in (left, right) if x.type.base is flat.Base.BOOLEAN), None)
    if truth is not None and op in ("+", "-", "*", "/"):
        hint = f"write `(if {truth.span.text} then 1 else 0)` to count with it"
    phase = next((x for x in (left, right) if x.type.base is flat.Base.ENUMERATION), None)
    if phase is not None and op in ("+", "-") and "\n" not in span.text:
        counted = span.text.replace(phase.span.text, f"Integer({phase.span.text})", 1)
        hint = f"an enumeration is no number: write `{type_text(phase.type)}({counted})`"
    message = f"`{op}` cannot join {type_text(left.type)} and {type_text(right.type)}"
    return error("F274", message, span, hint=hint)


def _literal(type_: flat.Type, written: flat.Expression) -> str:
    """The value of an enumeration that a number or a text stands for, or its first."""
    given = written.value if isinstance(written, flat.Literal) else None
    names = type_.literals
    named = [n for k, n in enumerate(names, 1) if given in (k, n)]
    return f"{type_.name}.{(named or names)[0]}"


def _one_of_each(op: str, left: flat.Expression, right: flat.Expression) -> str:
    """What to write for a relation of vectors."""
    sides = (left, right)
    if all(len(x.type.dims) < 2 and isinstance(x, flat.Reference | flat.Literal) for x in sides):
        first, second = (
            [f"{x.span.text}[{i}]" if x.type.dims else x.span.text for x in sides] for i in (1, 2)
        )
        both = f"`{f' {op} '.join(first)}` or `{f' {op} '.join(second)}`"
        return f"a relation compares two numbers: write {both}"
    return "a relation compares two numbers: write it for one element of each array"


def _only_vector(e: flat.Expression) -> flat.Reference | None:
    """The variable of two elements that alone makes an expression a vector: `r` of `2*m*r`."""
    if isinstance(e, flat.Unary):
        return _only_vector(e.operand)
    if isinstance(e, flat.Binary):
        vectors = [x for x in (e.left, e.right) if x.type.dims]
        return _only_vector(vectors[0]) if len(vectors) == 1 else None
    if isinstance(e, flat.Reference) and e.type.dims == (2,) and not e.span.text.endswith("]"):
        return e
    return None


def _relation(op: str, left: flat.Expression, right: flat.Expression, span: Span) -> flat.Binary:
    common = unify(left.type, right.type)
    if common is None or common.dims or common.base is flat.Base.RECORD:
        raise _mismatch(op, left, right, span)
    return flat.Binary(flat.BOOLEAN, span, op, left, right)


def _logical(op: str, left: flat.Expression, right: flat.Expression, span: Span) -> flat.Binary:
    common = unify(left.type, right.type)
    if common is None or common.base is not flat.Base.BOOLEAN:
        raise _mismatch(op, left, right, span)
    return flat.Binary(common, span, op, left, right)


def _arithmetic(
    op: str, left: flat.Expression, right: flat.Expression, span: Span
) -> flat.Expression:
    a, b = left.type, right.type
    if op == "+" and a.base is flat.Base.STRING and b.base is flat.Base.STRING:
        if not dims_conform(a.dims, b.dims):
            raise _mismatch(op, left, right, span)
        return flat.Binary(a, span, op, left, right)
    if a.base not in NUMERIC or b.base not in NUMERIC:
        raise _mismatch(op, left, right, span)
    dims = _result_dims(op, a.dims, b.dims)
    if dims is None:
        raise _mismatch(op, left, right, span)
    base = flat.INTEGER if a.base is b.base is flat.Base.INTEGER else flat.REAL
    if _DOTTED.get(op, op) in ("/", "^"):
        base = flat.REAL
    if op in _DOTTED and not a.dims and not b.dims:
        op = _DOTTED[op]
    return flat.Binary(base.with_dims(dims), span, op, left, right)


def _result_dims(op: str, a: flat.Dims, b: flat.Dims) -> flat.Dims | None:
    if op in ("+", "-"):
        return unify_dims(a, b) if dims_conform(a, b) else None
    if op in _DOTTED:
        if not a or not b:
            return a or b
        return unify_dims(a, b) if dims_conform(a, b) else None
    if op == "*":
        return _product_dims(a, b)
    if op == "/":
        return None if b else a
    if op == "^":
        square = len(a) == 2 and dims_conform(a[:1], a[1:])
        return a if not b and (not a or square) else None
    return None


def _product_dims(a: flat.Dims, b: flat.Dims) -> flat.Dims | None:
    """Scalar, inner, matrix-vector, vector-matrix and matrix products (10.6.4)."""
    if not a or not b:
        return a or b
    if len(a) > 2 or len(b) > 2 or not dims_conform(a[-1:], b[:1]):
        return None
    return (*a[:-1], *b[1:])


def range_(
    start: flat.Expression,
    step: flat.Expression | None,
    stop: flat.Expression,
    span: Span,
    env: Env,
) -> flat.Expression:
    """`start:step:stop`; its size is known when its ends can be computed now."""
    parts = [start, stop] if step is None else [start, step, stop]
    for part in parts:
        if part.type.dims:
            message = f"a range needs scalars, not {type_text(part.type)}"
            raise no_scalar("F277", message, part.span)
    type_ = start.type
    for part in parts[1:]:
        common = unify(type_, part.type)
        if common is None or common.base in (flat.Base.STRING, flat.Base.RECORD):
            message = f"a range cannot go from {type_text(start.type)} to {type_text(stop.type)}"
            raise error("F277", message, span)
        type_ = common
    size = evaluate.range_size(start, step, stop, env)
    return flat.Range(type_.with_dims((size,)), span, start, step, stop)
