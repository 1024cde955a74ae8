"""What operations make of Python's numbers: with its errors, or nan where there is no value."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from planarc.ir.expr import Op


def _power(a: float, b: float) -> float:
    value: float | complex = a**b
    if isinstance(value, complex):
        raise ValueError("power of a negative number")
    return value


#: The values of operations whose arguments are all known; arithmetic errors come through.
VALUES: Mapping[Op, Callable[..., Any]] = {
    Op.ADD: lambda *terms: sum(terms),
    Op.MUL: lambda *factors: math.prod(factors),
    Op.NEG: lambda a: -a,
    Op.DIV: lambda a, b: a / b,
    Op.POW: _power,
    Op.LESS: lambda a, b: a < b,
    Op.LESS_EQUAL: lambda a, b: a <= b,
    Op.EQUAL: lambda a, b: a == b,
    Op.NOT: lambda a: not a,
}


def safe(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, with nan where it has no value or gets none."""

    def call(*args: Any) -> Any:
        for a in args:
            if a != a:
                return math.nan
        try:
            return function(*args)
        except (ArithmeticError, ValueError):
            return math.nan

    return call


def _both(a: Any, b: Any) -> Any:
    return a if a != a else a and b


def _either(a: Any, b: Any) -> Any:
    return a if a != a else a or b


#: The values of operations, nan where there are none.
SAFE: Mapping[Op, Callable[..., Any]] = {
    **{op: safe(value) for op, value in VALUES.items()},
    Op.AND: _both,
    Op.OR: _either,
}
