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

from planarc.core.arrays import Vector
from planarc.evaluate.operations import VALUES
from planarc.evaluate.record import Number
from planarc.evaluate.value import apply_function
from planarc.ir.closing import opened, symbols_of
from planarc.ir.expr import Expr, Exprs, Op, fold, postorder
from planarc.ir.loop import Loop
from planarc.runtime import elementary

# Where it counts: an enumeration looks up its members by a function.
_CONST, _CALL, _LOOP, _OTHERS = Op.CONST, Op.CALL, Op.LOOP, (Op.APPLY, Op.PAST)
#: Turns that rows take together at most; comparisons, of which none may ask for what is no number.
_TOGETHER, _COMPARED = 1000, frozenset({Op.LESS, Op.LESS_EQUAL, Op.EQUAL})


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
    """A function of numbers in `external`, called for each row."""
    rows = zip(*np.broadcast_arrays(*map(np.atleast_1d, args)), strict=True)
    return np.array([apply_function(e, row) for row in rows])


class RowValues:
    """Gives the values of expressions, and remembers them.

    `leaf` gives those of symbols, time, left limits and events, `other` those of calls that
    are no elementary functions. nan stands where there is no value, and where a loop takes very
    many turns and nobody is `patient`.
    """

    def __init__(
        self,
        leaf: Callable[[Expr], Any],
        other: Callable[[Expr, Sequence[Any]], Any] = applied,
        patient: bool = True,
    ) -> None:
        self._leaf, self._other, self._patient = leaf, other, patient
        self._values: dict[Expr, Any] = {}
        self._behind: dict[tuple[Any, ...], Vector] = {}  # loops, for each output
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
        if op is _LOOP:
            return self._of_loop(e, args)
        return self._other(e, args) if op in _OTHERS else self._leaf(e)

    def _of_loop(self, e: Expr, args: Sequence[Any]) -> Any:
        """One of the values behind a loop, which are computed together."""
        loop, output = e.data
        key = (loop, e.args)
        if key not in self._behind:
            columns = np.array(np.broadcast_arrays(*map(np.atleast_1d, args)), dtype=float)
            with np.errstate(all="ignore"):
                self._behind[key] = _turned(loop, columns, self._patient)
        found = self._behind[key][output]
        return found if any(map(np.ndim, args)) else float(found[0])


def _turned(loop: Loop, columns: Vector, patient: bool) -> Vector:
    """The values behind a loop, of each row; rows that take a turn take it together.

    Rows that take very many, or ask for what is not a number, are left to `loops`.
    """
    table = Exprs()
    symbols = symbols_of(table, loop)
    condition, following = opened(table, loop, symbols)
    asked = [a for e in postorder((condition,)) if e.op in _COMPARED for a in e.args]
    found = np.vstack((columns[: loop.carried], np.ones(columns.shape[1])))
    left = np.arange(columns.shape[1])
    apart = np.zeros(len(left), dtype=bool)
    for _ in range(_TOGETHER):
        now = np.vstack((found[:-1, left], columns[loop.carried :, left]))
        values = RowValues(dict(zip(symbols, now, strict=True)).__getitem__, patient=patient)
        goes_on = np.broadcast_to(values(condition), left.shape).astype(bool)
        for e in asked:
            apart[left] |= np.isnan(values(e))
        goes_on &= ~apart[left]
        rest = left[goes_on]
        if not len(rest):
            left = rest
            break
        turned = [np.broadcast_to(values(f), left.shape)[goes_on] for f in following]
        found[:-1, rest] = np.reshape(turned, (loop.carried, len(rest)))
        left = rest
    late = sorted({*left.tolist(), *np.flatnonzero(apart).tolist()})
    if not patient:
        found[:, late] = math.nan
        return found
    from planarc.evaluate.loops import values_behind

    for row in late:
        found[:, row] = values_behind(loop, columns[:, row].tolist())
    return found


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
