"""The value of an expression at one point, on Python's numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from planarc.ir.expr import Expr, Op
from planarc.runtime import elementary, external


def apply_function(e: Expr, arguments: Sequence[Any]) -> Any:
    """The value of an elementary function, or of one that the model calls."""
    if e.op is Op.CALL:
        return elementary.TABLE[e.data].value(*arguments)
    function, output, _ = e.data
    return external.number(function, output, arguments)


def evaluate(
    root: Expr,
    leaf: Callable[[Expr], Any],
    apply: Callable[[Expr, Sequence[Any]], Any] = apply_function,
    values: dict[Expr, Any] | None = None,
) -> Any:
    """The value of an expression; `leaf` gives that of symbols, time, pre and events, `apply`
    that of functions, of numbers as the leaves are. `values` are known, and are added to.

    Python's arithmetic errors come through (ZeroDivisionError, ValueError, OverflowError).
    Of a condition's branches only the one that it chooses is evaluated.
    """
    values = {} if values is None else values
    stack = [root]
    while stack:
        e = stack[-1]
        needed = _needed(e, values)
        waiting = [a for a in needed if a not in values]
        if waiting:
            stack.extend(waiting)
            continue
        stack.pop()
        if e in values:
            continue
        if e.op is Op.CONST:
            values[e] = e.data
        elif not e.args or e.op is Op.PAST:
            values[e] = leaf(e)
        elif e.op in _CHOICES:
            values[e] = values[needed[-1]]
        elif e.op in (Op.CALL, Op.APPLY):
            values[e] = apply(e, [values[a] for a in e.args])
        else:
            values[e] = VALUES[e.op](*(values[a] for a in e.args))
    return values[root]


_CHOICES = frozenset({Op.IF, Op.AND, Op.OR})


def _needed(e: Expr, values: Mapping[Expr, Any]) -> tuple[Expr, ...]:
    """The arguments that the value hangs on, as far as is known; of a choice the last of
    them is its value."""
    if e.op not in _CHOICES or e.args[0] not in values:
        return e.args if e.op not in _CHOICES else e.args[:1]
    first = bool(values[e.args[0]])
    if e.op is Op.IF:
        return (e.args[0], e.args[1] if first else e.args[2])
    return e.args if first is (e.op is Op.AND) else e.args[:1]


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
