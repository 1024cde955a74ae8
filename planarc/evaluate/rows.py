"""Values of expressions over many rows at once, with NumPy.

A value that never changes is a Python number, any other an array with an entry for each row.
Each distinct node is evaluated once, however many expressions share it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from planarc.evaluate.operations import VALUES
from planarc.evaluate.record import Number
from planarc.evaluate.value import apply_function
from planarc.ir.expr import Expr, Op, fold
from planarc.runtime import elementary

# Where it counts: an enumeration looks up its members by a function.
_CONST, _CALL, _OTHERS = Op.CONST, Op.CALL, (Op.APPLY, Op.PAST, Op.LOOP)


class _Functions:
    """The functions that formulas of `runtime.elementary` use."""

    def __getattr__(self, name: str) -> Callable[..., Any]:
        row = elementary.TABLE.get(name)
        found: Callable[..., Any] = on_arrays(row) if row else getattr(np, name)
        return found


def on_arrays(row: elementary.Elementary) -> Callable[..., Any]:
    """An elementary function of arrays, entry by entry."""
    if row.in_numpy:
        found: Callable[..., Any] = getattr(np, row.in_numpy)
        return found
    built = row.built
    assert built is not None
    return lambda *x: built(_Functions(), *map(np.asanyarray, x))


def applied(e: Expr, args: Sequence[Any]) -> Any:
    """A function of numbers in `external`, or a loop, called for each row."""
    rows = zip(*np.broadcast_arrays(*map(np.atleast_1d, args)), strict=True)
    return np.array([apply_function(e, row) for row in rows])


class RowValues:
    """Gives the values of expressions, and remembers them.

    `leaf` gives those of symbols, time, left limits and events, `other` those of calls that
    are no elementary functions. nan stands where there is no value.
    """

    def __init__(
        self, leaf: Callable[[Expr], Any], other: Callable[[Expr, Sequence[Any]], Any] = applied
    ) -> None:
        self._leaf, self._other = leaf, other
        self._values: dict[Expr, Any] = {}
        self._operators = _operators()

    def __call__(self, root: Expr) -> Any:
        return fold(root, self._values, self._of)

    def __contains__(self, e: Expr) -> bool:
        """Whether the value was asked for, or that of something made of it."""
        return e in self._values

    def _of(self, e: Expr) -> Any:
        op = e.op
        if op is _CONST:
            return e.data
        args = [*map(self._values.__getitem__, e.args)]
        if op in self._operators:
            return self._operators[op](*args)
        if op is _CALL:
            return _call(elementary.TABLE[e.data], args)
        return self._other(e, args) if op in _OTHERS else self._leaf(e)


def _call(row: elementary.Elementary, args: Sequence[Any]) -> Any:
    if not all(isinstance(a, (int, float)) and not isinstance(a, Number) for a in args):
        return on_arrays(row)(*args)
    try:
        return row.value(*args)
    except (ValueError, ArithmeticError):
        return math.nan


@cache
def _operators() -> Mapping[Op, Callable[..., Any]]:
    def plain(value: Any) -> Any:
        return value.item() if getattr(value, "ndim", 1) == 0 else value

    return {
        **VALUES,
        Op.DIV: lambda a, b: plain(np.divide(a, b)),
        Op.POW: lambda a, b: plain(np.power(a * 1.0, b)),
        Op.AND: lambda a, b: plain(np.logical_and(a, b)),
        Op.OR: lambda a, b: plain(np.logical_or(a, b)),
        Op.NOT: lambda a: plain(np.logical_not(a)),
        Op.IF: lambda c, a, b: plain(np.where(c, a, b)),
    }
