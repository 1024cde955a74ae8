"""Arithmetic on values: what operators and built-in functions give for constants.

Reference: Modelica Language Specification 3.6, sections 3.4, 3.7 and 10.3 to 10.6.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from planarc.core.diagnostic import PlanarcError, error
from planarc.core.source import Span
from planarc.flatten.terms.constant import NotConstant, Value
from planarc.flatten.values.text import string_of
from planarc.ir import flat
from planarc.runtime import elementary
from planarc.runtime.elementary import Result

#: operators that give their (first) argument when nothing changes in time
IDENTITIES = frozenset({"noEvent", "smooth", "homotopy", "pre"})


LARGEST = 2**63 - 1  # Integer
MAX_TEXT = 1_000_000  # letters
MAX_ENTRIES = 4_000_000  # of one array
MAX_PRODUCTS = 10_000_000  # of one product of matrices


def shape(value: Value) -> tuple[int, ...]:
    dims = []
    while isinstance(value, list):
        dims.append(len(value))
        if not value:
            break
        value = value[0]
    return tuple(dims)


def _map(function: Callable[..., Any], *values: Value) -> Value:
    """Elementwise over arrays; scalars go with every element."""
    sizes = {len(v) for v in values if isinstance(v, list)}
    if not sizes:
        return function(*values)  # type: ignore[no-any-return]
    if len(sizes) > 1:
        raise NotConstant("the sizes of the arrays differ")
    return [
        _map(function, *(v[i] if isinstance(v, list) else v for v in values))
        for i in range(sizes.pop())
    ]


def unary(op: str, value: Value) -> Value:
    return _map(operator.not_ if op == "not" else operator.neg, value)


_RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "<>": operator.ne,
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
}


def binary(op: str, left: Value, right: Value, span: Span) -> Value:
    try:
        if op in _RELATIONS:
            return _map(_RELATIONS[op], left, right)
        if op in ("+", ".+"):
            return _map(_plus, left, right)
        if op in ("-", ".-"):
            return _map(operator.sub, left, right)
        if op == ".*":
            return _map(_times, left, right)
        if op in ("/", "./"):
            return _map(operator.truediv, left, right)
        if op == ".^":
            return _map(_power, left, right)
        if op == "^":
            return _matrix_power(left, right) if isinstance(left, list) else _power(left, right)
        return multiply(left, right)
    except ZeroDivisionError:
        raise error("F283", "division by zero in a constant expression", span) from None
    except (ValueError, OverflowError) as problem:
        raise error("F283", f"a constant expression has no value: {problem}", span) from None
    except TypeError:
        raise NotConstant(f"`{op}` has no value here", span) from None


def _plus(a: Any, b: Any) -> Any:
    if isinstance(a, str) and len(a) + len(b) > MAX_TEXT:
        raise OverflowError("the text is too long")
    return a + b


def _times(a: Any, b: Any) -> Any:
    result = a * b
    if isinstance(result, int) and not -LARGEST <= result <= LARGEST:
        raise OverflowError("an Integer is too large")
    return result


def _power(base: Any, exponent: Any) -> Value:
    result = float(base) ** exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


def _matrix_power(base: Value, exponent: Value) -> Value:
    assert isinstance(base, list) and isinstance(exponent, int)
    result: Value = identity(len(base))
    square: Value = base
    while exponent > 0:  # by squaring
        if exponent % 2:
            result = multiply(result, square)
        exponent //= 2
        if exponent:
            square = multiply(square, square)
    return result


def multiply(a: Any, b: Any) -> Value:
    """`*` by the operands' dimensions (10.6.4)."""
    if not isinstance(a, list) or not isinstance(b, list):
        return _map(_times, a, b)
    if a and isinstance(a[0], list):
        columns = len(b[0]) if b and isinstance(b[0], list) else 1
        if len(a) * len(b) * columns > MAX_PRODUCTS:
            raise NotConstant("the matrices are too large")
        return [multiply(row, b) for row in a]
    if b and isinstance(b[0], list):
        return [multiply(a, [row[j] for row in b]) for j in range(len(b[0]))]
    products: list[Any] = [_times(x, y) for x, y in zip(a, b, strict=True)]
    return total(products)


def index(value: Value, subscripts: list[Value | None], span: Span) -> Value:
    """Subscripts on an array value; None stands for `:`."""
    if not subscripts:
        return value
    if not isinstance(value, list):
        raise error("F218", "too many subscripts", span)
    first, rest = subscripts[0], subscripts[1:]
    if first is None:
        return [index(v, rest, span) for v in value]
    if isinstance(first, list):
        return [index(entry(value, i, span), rest, span) for i in first]
    return index(entry(value, first, span), rest, span)


def entry(value: list[Value], index: Any, span: Span) -> Value:
    """The entry at an index from 1."""
    place = int(index)
    if not 1 <= place <= len(value):
        raise error("F219", f"the index {place} is outside of 1 to {len(value)}", span)
    return value[place - 1]


def reduce(kind: str, values: list[Value]) -> Value:
    match kind:
        case "sum":
            return total(values)
        case "product":
            return math.prod(flat_values(values))  # type: ignore[no-any-return]
        case "min":
            return min(flat_values(values), default=math.inf)
        case "max":
            return max(flat_values(values), default=-math.inf)
    return values


def flat_values(value: Value) -> list[Any]:
    return [x for v in value for x in flat_values(v)] if isinstance(value, list) else [value]


def total(value: Value) -> Value:
    return sum(flat_values(value))  # type: ignore[no-any-return]


def identity(n: Any) -> Value:
    _bound(n * n)
    return [[1 if i == j else 0 for j in range(n)] for i in range(n)]


def _bound(entries: int) -> None:
    if entries > MAX_ENTRIES:
        raise NotConstant("the array is too large")


def fill(value: Any, *dims: Any) -> Value:
    _bound(math.prod(dims))
    for size in reversed(dims):
        value = [value] * size
    return value  # type: ignore[no-any-return]


def transpose(a: Any) -> Value:
    return [list(row) for row in zip(*a, strict=True)]


def _min(*values: Any) -> Value:
    return min(flat_values(list(values)))  # type: ignore[no-any-return]


def _max(*values: Any) -> Value:
    return max(flat_values(list(values)))  # type: ignore[no-any-return]


def _cross(a: Any, b: Any) -> Value:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def _skew(x: Any) -> Value:
    return [[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]]


def _linspace(a: Any, b: Any, n: Any) -> Value:
    _bound(n)
    return [a + (b - a) * i / (n - 1) for i in range(n)]


def cat(dimension: Any, *arrays: Any) -> Value:
    if dimension == 1:
        _bound(sum(map(len, arrays)))
        return [x for a in arrays for x in a]
    return [cat(dimension - 1, *rows) for rows in zip(*arrays, strict=True)]


def _scalar(value: Any) -> Value:
    while isinstance(value, list):
        value = value[0]
    return value  # type: ignore[no-any-return]


def _matrix(value: Any) -> Value:
    if not isinstance(value, list):
        return [[value]]
    return [v if isinstance(v, list) else [v] for v in value]


def _symmetric(a: Any) -> Value:
    n = range(len(a))
    return [[a[min(i, j)][max(i, j)] for j in n] for i in n]


def _diagonal(v: Any) -> Value:
    _bound(len(v) ** 2)
    return [[v[i] if i == j else 0 for j in range(len(v))] for i in range(len(v))]


def _outer(a: Any, b: Any) -> Value:
    _bound(len(a) * len(b))
    return [[x * y for y in b] for x in a]


_CONVERSIONS: dict[str, Callable[..., Any]] = {"integer": math.floor, "Integer": int}


def scalar(name: str) -> Callable[..., Any] | None:
    """A function of scalars, which acts on each entry of arrays."""
    row = elementary.TABLE.get(name)
    if row is None:
        return _CONVERSIONS.get(name)
    return None if row.result is Result.EXTREME else row.value


def function_of(name: str) -> Callable[..., Any] | None:
    return scalar(name) or FUNCTIONS.get(name)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "min": _min,
    "max": _max,
    "sum": total,
    "product": lambda v: math.prod(flat_values(v)),
    "zeros": lambda *n: fill(0, *n),
    "ones": lambda *n: fill(1, *n),
    "fill": fill,
    "identity": identity,
    "diagonal": _diagonal,
    "linspace": _linspace,
    "transpose": transpose,
    "cross": _cross,
    "skew": _skew,
    "outerProduct": _outer,
    "symmetric": _symmetric,
    "scalar": _scalar,
    "vector": lambda v: flat_values(v),
    "matrix": _matrix,
    "cat": cat,
    "ndims": lambda v: len(shape(v)),
    "String": str,
}


def apply(function: Callable[..., Any] | None, values: list[Value], e: flat.Builtin) -> Value:
    """A built-in function on values; a failure is the user's error."""
    if e.function == "String":
        return string_of(values, e)
    assert function is not None
    try:
        result = _map(function, *values) if scalar(e.function) else function(*values)
    except ZeroDivisionError:
        raise error("F283", "division by zero in a constant expression", e.span) from None
    except (ValueError, OverflowError, IndexError):
        raise _no_value(e, values) from None
    except TypeError:
        raise NotConstant(f"`{e.function}` has no value here", e.span) from None
    number = _NUMBERS.get(e.type.base)
    return result if number is None else _map(number, result)


#: What the values of a type are: functions of numbers give floats.
_NUMBERS: dict[flat.Base, type] = {flat.Base.REAL: float, flat.Base.INTEGER: int}


def _no_value(e: flat.Builtin, values: list[Value]) -> PlanarcError:
    shown = ", ".join(str(v) for v in values)
    return error("F283", f"`{e.function}({shown[:60]})` has no value", e.span)
