"""Bounds of an expression, whatever its variables are.

A loop whose end is not known when the model is compiled is written out up to the greatest
value that its end can have: `for i in 1:integer(3*sin(x))` has three turns at most.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from planarc.ir.expr import Expr, Op, fold
from planarc.runtime import elementary


class Bounds(NamedTuple):
    low: float = -math.inf
    high: float = math.inf


def bounds(root: Expr) -> Bounds:
    """The least and the greatest value that an expression may have."""
    memo: dict[Expr, Bounds] = {}
    return fold(root, memo, lambda e: _of(e, [memo[a] for a in e.args]))


def _of(e: Expr, args: list[Bounds]) -> Bounds:
    match e.op:
        case Op.CONST:
            return Bounds(e.data, e.data)
        case Op.NEG:
            return Bounds(-args[0].high, -args[0].low)
        case Op.ADD:
            return Bounds(sum(a.low for a in args), sum(a.high for a in args))
        case Op.MUL:
            return _product(args)
        case Op.IF:
            _, then, otherwise = args
            return Bounds(min(then.low, otherwise.low), max(then.high, otherwise.high))
        case Op.CALL:
            return _call(elementary.TABLE[e.data], args)
    return Bounds()


def _product(args: list[Bounds]) -> Bounds:
    low, high = args[0]
    for other in args[1:]:
        ends = [a * b if a and b else 0.0 for a in (low, high) for b in other]
        low, high = min(ends), max(ends)
    return Bounds(low, high)


def _call(row: elementary.Elementary, args: list[Bounds]) -> Bounds:
    if not row.rises:
        return Bounds(-row.size, row.size)
    low, high = (a.low for a in args), (a.high for a in args)
    return Bounds(_value(row, *low), _value(row, *high))


def _value(row: elementary.Elementary, *at: float) -> float:
    """A function that rises, where its arguments may be infinite."""
    return at[0] if row.arity == 1 and math.isinf(at[0]) else row.value(*at)
