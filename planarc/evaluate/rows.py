"""Values of expressions over all rows of a result at once.

A node that never changes gives a Python number, any other an array with a value for each row.
Each distinct node is evaluated once, however many attributes share it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from planarc.ir.expr import FUNCTIONS, Expr, Op, postorder, symbol_text

if TYPE_CHECKING:
    from planarc.ir.result import Result


class NotDrawable(Exception):
    """Why an attribute has no value; told to the user as a note."""


class Evaluator:
    """The values of one result's expressions; remembers them."""

    def __init__(self, result: Result) -> None:
        import numpy as np

        self._result = result
        self._values: dict[Expr, Any] = {}
        self._rules = _rules(np)
        self._functions = _functions(np)

    def __call__(self, value: Any) -> Any:
        """Of nested tuples the same nesting with values; texts stay."""
        if isinstance(value, tuple):
            return tuple(self(item) for item in value)
        return self._expression(value) if isinstance(value, Expr) else value

    def _expression(self, root: Expr) -> Any:
        values = self._values
        for e in postorder((root,)):
            if e not in values:
                values[e] = self._node(e, [values[a] for a in e.args])
        return values[root]

    def _node(self, e: Expr, args: list[Any]) -> Any:
        match e.op:
            case Op.CONST:
                return e.data
            case Op.TIME:
                return self._result.time
            case Op.SYMBOL:
                return self._column(symbol_text(*e.data))
            case Op.PRE:
                return self._column(e.data)
            case Op.CALL:
                constant = all(isinstance(a, (int, float)) for a in args)
                return self._constant(e, args) if constant else self._functions[e.data](*args)
            case Op.EVENT | Op.APPLY:
                raise NotDrawable("its attributes use events or functions that cannot be inlined")
        return self._rules[e.op](*args)

    def _constant(self, e: Expr, args: list[Any]) -> float:
        try:
            return FUNCTIONS[e.data](*args)
        except (ValueError, OverflowError, ZeroDivisionError):
            return math.nan

    def _column(self, name: str) -> Any:
        result = self._result
        if name not in result:
            raise NotDrawable(f"the result has no variable `{name}`")
        column = result.columns[name]
        if column.slot in result.stored:
            return result[name]
        return float(column.sign * result.constants[column.slot])


def _rules(np: Any) -> Mapping[Op, Callable[..., Any]]:
    """The operators for numbers and arrays alike."""
    return {
        Op.ADD: lambda *terms: sum(terms),
        Op.MUL: lambda *factors: math.prod(factors),
        Op.NEG: lambda a: -a,
        Op.DIV: lambda a, b: _plain(np.divide(a, b)),
        Op.POW: lambda a, b: _plain(np.power(np.asarray(a, dtype=float), b)),
        Op.LESS: lambda a, b: a < b,
        Op.LESS_EQUAL: lambda a, b: a <= b,
        Op.EQUAL: lambda a, b: a == b,
        Op.AND: lambda a, b: _plain(np.logical_and(a, b)),
        Op.OR: lambda a, b: _plain(np.logical_or(a, b)),
        Op.NOT: lambda a: _plain(np.logical_not(a)),
        Op.IF: lambda c, a, b: _plain(np.where(c, a, b)),
    }


def _functions(np: Any) -> Mapping[str, Callable[..., Any]]:
    """The elementary functions for arrays."""
    same = ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "log10", "sqrt")
    return {
        **{name: getattr(np, name) for name in (*same, "abs", "sign", "floor", "ceil")},
        "asin": np.arcsin,
        "acos": np.arccos,
        "atan": np.arctan,
        "atan2": np.arctan2,
        "min": np.minimum,
        "max": np.maximum,
        "div": lambda x, y: np.trunc(x / y),
        "mod": lambda x, y: x - np.floor(x / y) * y,
        "rem": lambda x, y: x - np.trunc(x / y) * y,
    }


def _plain(value: Any) -> Any:
    return value.item() if value.ndim == 0 else value
