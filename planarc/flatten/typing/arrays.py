"""Built-in functions that build or reshape arrays, opened where sizes are known.

Example: `identity(2)` becomes `{{1, 0}, {0, 1}}`; `cross(a, b)` its three sums.

Reference: Modelica Language Specification 3.6, section 10.3.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.refusal import too_large
from planarc.flatten.terms.conform import NUMERIC, type_text, unify
from planarc.flatten.terms.select import array, element_at, integer, opened, pick, real
from planarc.flatten.tree.nodes import Env
from planarc.flatten.typing import operators
from planarc.flatten.values import evaluate
from planarc.ir import flat

Arguments = list[flat.Expression]
MAX_OPENED = 100_000
MANY = 1000  # arguments: as many as there are
MAX_MATRIX = 1_000_000  # entries of a matrix that is written out


def wrong_argument(name: str, value: flat.Expression) -> PlanarcError:
    return error("F291", f"`{name}` cannot be applied to {type_text(value.type)}", value.span)


def size(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    """`size(A)` and `size(A, i)`: literal when the type tells it."""
    value, *which = arguments
    dims = value.type.dims
    if not which:
        if None in dims:
            return flat.Builtin(flat.INTEGER.with_dims((len(dims),)), span, "size", (value,))
        return array([integer(d or 0, span) for d in dims], flat.INTEGER, span)
    dimension = which[0]
    if dimension.type.base is not flat.Base.INTEGER or dimension.type.dims:
        raise wrong_argument("size", dimension)
    known = evaluate.try_value(dimension, env, mark=True)
    if known is None:
        return flat.Builtin(flat.INTEGER, span, "size", (value, dimension))
    if not isinstance(known, int) or not 1 <= known <= len(dims):
        raise error(
            "F218", f"a value of type {type_text(value.type)} has no dimension {known}", span
        )
    found = dims[known - 1]
    if found is not None:
        return integer(found, span)
    return flat.Builtin(flat.INTEGER, span, "size", (value, integer(known, span)))


def _sizes(name: str, arguments: Arguments, env: Env) -> tuple[int | None, ...]:
    """Sizes given as arguments, None where they are known only when run."""
    sizes: list[int | None] = []
    for argument in arguments:
        if argument.type.base is not flat.Base.INTEGER or argument.type.dims:
            raise wrong_argument(name, argument)
        if env.function is not None or env.in_algorithm:
            value = evaluate.try_value(argument, env, mark=True)
        else:
            value = evaluate.structural_value(argument, env, f"a size given to `{name}`")
        if value is not None and int(value) < 0:  # type: ignore[arg-type]
            raise error("F255", f"a size given to `{name}` is negative: {value}", argument.span)
        sizes.append(None if value is None else int(value))  # type: ignore[arg-type]
    known = prod(s for s in sizes if s is not None)
    if known > 10_000_000:
        raise too_large(f"`{name}` makes an array of {known:,} entries", arguments[0].span)
    return tuple(sizes)


def _filled(
    name: str, value: flat.Expression, sizes: Arguments, span: Span, env: Env
) -> flat.Expression:
    dims = _sizes(name, sizes, env)
    if None in dims or prod(d or 0 for d in dims) > MAX_OPENED:
        type_ = value.type.with_dims((*dims, *value.type.dims))
        return flat.Builtin(type_, span, "fill", (value, *sizes))
    result = value
    for d in reversed(dims):
        result = array([result] * (d or 0), result.type, span)
    return result


def _zeros(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return _filled("zeros", integer(0, span), arguments, span, env)


def _ones(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return _filled("ones", integer(1, span), arguments, span, env)


def _fill(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return _filled("fill", arguments[0], arguments[1:], span, env)


def _identity(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (n,) = _sizes("identity", arguments, env)
    if n is None:
        return flat.Builtin(flat.INTEGER.with_dims((n, n)), span, "identity", tuple(arguments))
    _bound("identity", n, n, span)
    rows: list[Arguments] = [[integer(int(i == j), span) for j in range(n)] for i in range(n)]
    return _rows(rows, flat.INTEGER, span, n)


def _bound(name: str, rows: int, columns: int, span: Span) -> None:
    if rows * columns > MAX_MATRIX:
        raise too_large(f"`{name}` makes an array of {rows * columns:,} entries", span)


def _rows(
    rows: list[list[flat.Expression]], type_: flat.Type, span: Span, width: int
) -> flat.Expression:
    lines: Arguments = [array(row, type_, span) for row in rows]
    return array(lines, type_.with_dims((width,)), span)


def _known(value: flat.Expression) -> bool:
    return None not in value.type.dims


def _kept(
    name: str, dims: tuple[int | None, ...], arguments: Arguments, span: Span
) -> flat.Expression:
    type_ = arguments[-1].type.with_dims(dims)
    return flat.Builtin(type_, span, name, tuple(arguments))


def _diagonal(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (vector,) = arguments
    if len(vector.type.dims) != 1 or vector.type.base not in NUMERIC:
        raise wrong_argument("diagonal", vector)
    n = vector.type.dims[0]
    if n is None:
        return _kept("diagonal", (n, n), arguments, span)
    _bound("diagonal", n, n, span)
    zero = integer(0, span) if vector.type.base is flat.Base.INTEGER else real(0, span)
    rows = [[element_at(vector, i + 1) if i == j else zero for j in range(n)] for i in range(n)]
    return _rows(rows, vector.type.element(), span, n)


def _linspace(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    first, last, count = arguments
    (n,) = _sizes("linspace", [count], env)
    if n is None:
        return flat.Builtin(flat.REAL.with_dims((n,)), span, "linspace", tuple(arguments))
    if n < 2:
        raise error("F291", "`linspace` needs at least two points", span)
    step = operators.binary("-", last, first, span)
    items = []
    for i in range(n):
        part = operators.binary("*", step, real(i / (n - 1), span), span)
        items.append(operators.binary("+", first, part, span))
    items[0], items[-1] = first, last
    return array(items, flat.REAL, span)


def _transpose(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (matrix,) = arguments
    dims = matrix.type.dims
    if len(dims) < 2:
        raise wrong_argument("transpose", matrix)
    if not _known(matrix):
        return _kept("transpose", (dims[1], dims[0], *dims[2:]), arguments, span)
    n, m = dims[0] or 0, dims[1] or 0
    rows = [[pick(matrix, (i, j)) for i in range(1, n + 1)] for j in range(1, m + 1)]
    return _rows(rows, matrix.type.element(2), span, n)


def _three(name: str, value: flat.Expression) -> Arguments:
    if value.type.dims != (3,) or value.type.base not in NUMERIC:
        raise wrong_argument(name, value)
    return opened(value)


def _cross(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    if any(a.type.dims == (None,) for a in arguments):
        return _kept("cross", (3,), arguments, span)
    a, b = (_three("cross", v) for v in arguments)

    def entry(i: int, j: int) -> flat.Expression:
        left = operators.binary("*", a[i], b[j], span)
        return operators.binary("-", left, operators.binary("*", a[j], b[i], span), span)

    items = [entry(1, 2), entry(2, 0), entry(0, 1)]
    return array(items, items[0].type, span)


def _skew(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    x = _three("skew", arguments[0])
    zero = real(0, span)
    rows = [
        [zero, operators.unary("-", x[2], span), x[1]],
        [x[2], zero, operators.unary("-", x[0], span)],
        [operators.unary("-", x[1], span), x[0], zero],
    ]
    return _rows(rows, x[0].type, span, 3)


def _outer(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    a, b = arguments
    for value in arguments:
        if len(value.type.dims) != 1 or value.type.base not in NUMERIC:
            raise wrong_argument("outerProduct", value)
    if not _known(a) or not _known(b):
        return _kept("outerProduct", (*a.type.dims, *b.type.dims), arguments, span)
    _bound("outerProduct", a.type.dims[0] or 0, b.type.dims[0] or 0, span)
    rows = [[operators.binary("*", x, y, span) for y in opened(b)] for x in opened(a)]
    element = rows[0][0].type if rows and rows[0] else flat.REAL
    return _rows(rows, element, span, b.type.dims[0] or 0)


def _symmetric(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (matrix,) = arguments
    dims = matrix.type.dims
    if len(dims) != 2 or dims[0] != dims[1]:
        raise wrong_argument("symmetric", matrix)
    if not _known(matrix):
        return _kept("symmetric", dims, arguments, span)
    n = range(1, (dims[0] or 0) + 1)
    rows = [[pick(matrix, (min(i, j), max(i, j))) for j in n] for i in n]
    return _rows(rows, matrix.type.element(2), span, dims[0] or 0)


def _scalar(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (value,) = arguments
    if any(d not in (1, None) for d in value.type.dims):
        raise wrong_argument("scalar", value)
    return pick(value, (1,) * len(value.type.dims))


def _vector(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (value,) = arguments
    dims = value.type.dims
    if not dims:
        return array([value], value.type, span)
    if len([d for d in dims if d not in (1, None)]) > 1:
        raise wrong_argument("vector", value)
    if not _known(value):
        return value if len(dims) == 1 else _kept("vector", (None,), arguments, span)
    entries = [value]
    for _ in dims:
        entries = [e for v in entries for e in opened(v)]
    return array(entries, value.type.with_dims(()), span)


def _matrix(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    (value,) = arguments
    dims = value.type.dims
    if len(dims) == 2:
        return value
    if not dims:
        return array([array([value], value.type, span)], value.type.with_dims((1,)), span)
    if len(dims) > 2 and any(d != 1 for d in dims[2:]):
        raise wrong_argument("matrix", value)
    if not _known(value):
        return _kept("matrix", (*dims[:2], 1)[:2], arguments, span)
    if len(dims) == 1:
        rows = [[v] for v in opened(value)]
        return _rows(rows, value.type.element(), span, 1)
    rest = (1,) * (len(dims) - 2)
    rows = [[pick(e, rest) for e in opened(row)] for row in opened(value)]
    return _rows(rows, value.type.with_dims(()), span, dims[1] or 0)


def _cat(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    along, *parts = arguments
    dimension = evaluate.structural_value(along, env, "the dimension given to `cat`")
    rank = len(parts[0].type.dims)
    if not isinstance(dimension, int) or not 1 <= dimension <= rank:
        raise error(
            "F291", f"`cat` cannot join arrays of {rank} dimensions along {dimension}", span
        )
    if not all(_known(p) for p in parts):
        _common_element(parts)
        dims = [None if i == dimension - 1 else d for i, d in enumerate(parts[0].type.dims)]
        return _kept("cat", tuple(dims), arguments, span)
    return join(dimension, parts, span)


def join(dimension: int, parts: Arguments, span: Span) -> flat.Expression:
    """Arrays of known sizes joined along a dimension, counted from 1."""
    return _joined(dimension, parts, _common_element(parts), span)


def _common_element(parts: Arguments) -> flat.Type:
    type_ = parts[0].type.with_dims(())
    for part in parts:
        common = unify(type_, part.type, dims=False)
        if common is None or len(part.type.dims) != len(parts[0].type.dims):
            raise wrong_argument("cat", part)
        type_ = common.with_dims(())
    return type_


def _joined(dimension: int, parts: Arguments, type_: flat.Type, span: Span) -> flat.Expression:
    if dimension == 1:
        items = [e for p in parts for e in opened(p)]
        if len({i.type.dims for i in items}) > 1:
            raise error("F291", "the arrays given to `cat` do not fit together", span)
        element = type_.with_dims(parts[0].type.dims[1:])
        return array(items, element, span)
    if len({p.type.dims[0] for p in parts}) > 1:
        raise error("F291", "the arrays given to `cat` do not fit together", span)
    rows = [
        _joined(dimension - 1, list(row), type_, span)
        for row in zip(*(opened(p) for p in parts), strict=True)
    ]
    element = rows[0].type if rows else type_.with_dims(parts[0].type.dims[1:])
    return array(rows, element, span)


def _ndims(arguments: Arguments, span: Span, env: Env) -> flat.Expression:
    return integer(len(arguments[0].type.dims), span)


#: the fewest and the most arguments, and what is built of them
BUILDERS: dict[str, tuple[int, int, Callable[[Arguments, Span, Env], flat.Expression]]] = {
    "ndims": (1, 1, _ndims),
    "zeros": (1, MANY, _zeros),
    "ones": (1, MANY, _ones),
    "fill": (2, MANY, _fill),
    "identity": (1, 1, _identity),
    "diagonal": (1, 1, _diagonal),
    "linspace": (3, 3, _linspace),
    "transpose": (1, 1, _transpose),
    "cross": (2, 2, _cross),
    "skew": (1, 1, _skew),
    "outerProduct": (2, 2, _outer),
    "symmetric": (1, 1, _symmetric),
    "scalar": (1, 1, _scalar),
    "vector": (1, 1, _vector),
    "matrix": (1, 1, _matrix),
    "cat": (2, MANY, _cat),
}
