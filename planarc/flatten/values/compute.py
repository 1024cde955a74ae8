"""Arithmetic on values: what operators and built-in functions give for constants.

Reference: Modelica Language Specification 3.6, sections 3.4, 3.7 and 10.3 to 10.6.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

from planarc.core.diagnostic import Diagnostic, Misfit, PlanarcError, error
from planarc.core.prose import sized
from planarc.core.source import Span
from planarc.flatten.terms.constant import NotConstant, Value
from planarc.ir import flat
from planarc.runtime import elementary, tensor
from planarc.runtime.elementary import Result
from planarc.runtime.tensor import Tensor, TooLarge, alike, power, product, unfit, untaken

#: operators that give their (first) argument when nothing changes in time
IDENTITIES = frozenset({"noEvent", "smooth", "homotopy", "pre"})


LARGEST = 2**63 - 1  # Integer
MAX_TEXT = 1_000_000  # letters
MAX_PRODUCTS = 10_000_000  # of one product of matrices


def shape(value: Value) -> tuple[int, ...]:
    dims = []
    while isinstance(value, list):
        dims.append(len(value))
        if not value:
            break
        value = value[0]
    return tuple(dims)


def each(function: Callable[..., Any], *values: Value) -> Value:
    """Elementwise over arrays; scalars go with every element."""
    sizes = {len(v) for v in values if isinstance(v, list)}
    if not sizes:
        return function(*values)  # type: ignore[no-any-return]
    if len(sizes) > 1:
        raise NotConstant("the sizes of the arrays differ")
    return [
        each(function, *(v[i] if isinstance(v, list) else v for v in values))
        for i in range(sizes.pop())
    ]


def unary(op: str, value: Value) -> Value:
    return each(operator.not_ if op == "not" else operator.neg, value)


def binary(e: flat.Binary, left: Value, right: Value) -> Value:
    op, span = e.op, e.span
    if isinstance(left, list) and left and right != []:  # whose further sizes are not hidden
        message = unfit(op, shape(left), shape(right))
        if message is not None:
            raise Misfit(Diagnostic("F274", message, span))
    try:
        if op in _ELEMENTWISE:
            return each(_ELEMENTWISE[op], left, right)
        if op == "^":
            return _matrix_power(left, right) if isinstance(left, list) else _power(left, right)
        return multiply(left, right, e.left.type.dims, e.right.type.dims)
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


_ELEMENTWISE: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "<>": operator.ne,
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    **dict.fromkeys(("+", ".+"), _plus),
    **dict.fromkeys(("-", ".-"), operator.sub),
    **dict.fromkeys(("/", "./"), operator.truediv),
    ".*": _times,
    ".^": _power,
}


def multiply(a: Value, b: Value, dims_a: flat.Dims, dims_b: flat.Dims) -> Value:
    """`*` by the operands' dimensions (10.6.4)."""
    if not isinstance(a, list) or not isinstance(b, list):
        return each(_times, a, b)
    if math.prod(shape(a)) * math.prod(shape(b)[1:]) > MAX_PRODUCTS:
        raise NotConstant("the matrices are too large")
    return nested(product(Numbers, tensor_of(a, dims_a), tensor_of(b, dims_b)))


def _matrix_power(base: Value, exponent: Value) -> Value:
    if not isinstance(exponent, int | float) or exponent != int(exponent):
        raise TypeError
    return nested(power(Numbers, tensor_of(base), int(exponent)))


class Numbers:
    """Arithmetic for the rules of `runtime.tensor`."""

    zero, one = 0, 1
    const, sub, mul, neg = float, operator.sub, _times, operator.neg

    @staticmethod
    def add(*values: Any) -> Any:
        return sum(values)


def tensor_of(value: Value, dims: flat.Dims = ()) -> Any:
    """A value for the rules of `runtime.tensor`; `dims` are those of its type, which tells
    how many an empty array has."""
    if not isinstance(value, list):
        return value
    sizes = shape(value)
    sizes += tuple(d or 0 for d in dims[len(sizes) :])
    items: list[Any] = [value]
    for _ in sizes:
        items = [entry for row in items for entry in row]
    return Tensor(sizes, tuple(items))


def nested(value: Any) -> Value:
    return [nested(row) for row in value.rows()] if isinstance(value, Tensor) else value


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


def row(values: list[Value], e: flat.Expression) -> list[Value]:
    """Entries of an array, refused where their sizes differ."""
    if len(e.type.dims) > 1:
        sizes = list(map(shape, values))
        other = next((s for s in sizes if s != sizes[0]), None)
        if other is not None:
            message = f"the entries of an array have {sized([sizes[0], other])}"
            raise Misfit(Diagnostic("F272", message, e.span))
    return values


def reduce(kind: str, values: list[Value]) -> Value:
    """A reduction, of maybe no values at all."""
    if kind in ("min", "max") and not flat_values(values):
        return elementary.OF_NOTHING[kind]
    return values if kind == "array" else _FUNCTIONS[kind](values)


def flat_values(value: Value) -> list[Any]:
    return [x for v in value for x in flat_values(v)] if isinstance(value, list) else [value]


def total(value: Value) -> Value:
    return sum(flat_values(value))  # type: ignore[no-any-return]


def fill(value: Any, *dims: Any) -> Value:
    if math.prod(dims) > tensor.MAX_ENTRIES:
        raise NotConstant("the array is too large")
    for size in reversed(dims):
        value = [value] * size
    return value  # type: ignore[no-any-return]


_CONVERSIONS: dict[str, Callable[..., Any]] = {"integer": math.floor, "Integer": int}


def scalar(name: str) -> Callable[..., Any] | None:
    """A function of scalars, which acts on each entry of arrays."""
    row = elementary.TABLE.get(name)
    if row is None:
        return _CONVERSIONS.get(name)
    return None if row.result is Result.EXTREME else row.value


def is_known(name: str) -> bool:
    return scalar(name) is not None or name in _FUNCTIONS or name in tensor.FUNCTIONS


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "min": lambda *values: min(flat_values(list(values))),
    "max": lambda *values: max(flat_values(list(values))),
    "sum": total,
    "product": lambda v: math.prod(flat_values(v)),
    "ndims": lambda v: len(shape(v)),
    "String": str,
}


def apply(values: list[Value], e: flat.Builtin) -> Value:
    """A built-in function on values; a failure is the user's error."""
    if e.function == "String":
        return string_of(values, e)
    try:
        result = _result(e, values)
    except ZeroDivisionError:
        raise error("F283", "division by zero in a constant expression", e.span) from None
    except (ValueError, OverflowError, IndexError):
        raise _refused(e, values) from None
    except TooLarge:
        raise NotConstant("the array is too large", e.span) from None
    except TypeError:
        raise NotConstant(f"`{e.function}` has no value here", e.span) from None
    number = _NUMBERS.get(e.type.base)
    return result if number is None else each(number, result)


def _result(e: flat.Builtin, values: list[Value]) -> Value:
    function = scalar(e.function)
    if function is not None:
        if not alike(map(shape, values)):
            raise ValueError
        return each(function, *values)
    if e.function in _FUNCTIONS:
        return _FUNCTIONS[e.function](*values)  # type: ignore[no-any-return]
    dims = [a.type.dims for a in e.arguments] or [()] * len(values)
    given = [tensor_of(v, d) for v, d in zip(values, dims, strict=True)]
    return nested(tensor.apply(Numbers, e.function, int, given))


#: What the values of a type are: functions of numbers give floats.
_NUMBERS: dict[flat.Base, type] = {flat.Base.REAL: float, flat.Base.INTEGER: int}


def _refused(e: flat.Builtin, values: list[Value]) -> PlanarcError:
    """The error of numbers, or of sizes, that a function cannot take."""
    sizes = [s for v in values if (s := shape(v))]
    if sizes and (e.function in tensor.FUNCTIONS or not alike(sizes)):
        return Misfit(Diagnostic("F291", untaken(e.function, sizes), e.span))
    shown = ", ".join(str(v) for v in values)
    return error("F283", f"`{e.function}({shown[:60]})` has no value", e.span)


def string_of(values: list[Value], call: flat.Builtin) -> Value:
    """The text of a value; formats other than the plain one are left to the run."""
    if len(values) == 2:
        raise NotConstant("`String` with a format has no value before the run", call.span)
    if len(values) == 4:
        plain = _plain(values[0], call, values[1])
        length, left = values[2], values[3]
        assert isinstance(length, int)
        return plain.ljust(length) if left else plain.rjust(length)
    return _plain(values[0], call, 6)


def _plain(value: Value, call: flat.Builtin, digits: Value) -> str:
    type_ = call.arguments[0].type
    if type_.literals and isinstance(value, int):
        return type_.literals[value - 1]
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, int | str):
        return str(value)
    raise NotConstant("`String` of an array", call.span)
