"""The elementary functions: all that planarc knows of each, in one row.

Whoever types, differentiates, evaluates, prints or draws a call reads its row here, when
it needs it; a new function is a new row of `TABLE`. A formula is written once, over whatever
it is handed: `x` and `y` understand + - * / < <= >, and `f` has the functions of the table,
`f.trunc(x)` and `f.where(condition, a, b)`. So the slopes serve expressions (`ir.calculus`)
and numbers alike, and `built` serves NumPy's arrays (`evaluate.rows`) and compiled
code (`codegen.native.formulas`). Slopes are differentiated again: where a quotient has no value
that the function has, a series belongs in its place, and no constant.

Reference: Modelica Language Specification 3.6, sections 3.7.1 and 3.7.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import Enum, auto
from sys import float_info
from typing import Any, TypeAlias

from planarc.core.data import Data


class Sign:
    """The signs that a value may have, as bits: plain numbers, which are asked often."""

    MINUS, ZERO, PLUS = 1, 2, 4
    ANY = MINUS | ZERO | PLUS


class Result(Enum):
    """The type of a value by those of the arguments."""

    REAL = auto()
    INTEGER = auto()
    SAME = auto()  # an Integer of Integers
    EXTREME = auto()  # one of the arguments, or of the entries of an array


class Units(Enum):
    """The unit of a value by those of the arguments."""

    NUMBER = auto()  # a number of numbers
    KEPT = auto()  # the argument's
    ROOT = auto()  # the root of the argument's
    SAME = auto()  # the one that all arguments share
    RATIO = auto()  # a number of arguments that share one
    UNKNOWN = auto()


Formula: TypeAlias = Callable[..., Any]


class Elementary(Data):
    """A function of numbers. NumPy, the C library and LLVM know it by its name, by the one
    that is given here, or not at all: then it is `built`."""

    name: str
    arity: int
    value: Callable[..., float]  # of Python's floats; ValueError or ArithmeticError: none
    slopes: Formula | None  # by the argument, or a tuple by each; None: steps, flat between
    numpy: str = ""
    native: str = ""
    built: Formula | None = None
    result: Result = Result.REAL
    units: Units = Units.NUMBER
    sign: int = Sign.ANY  # of the value, whatever the arguments are
    odd: bool = False  # has the sign of its argument
    rises: bool = False  # nowhere falls with an argument
    size: float = math.inf  # no value is farther from zero
    total: bool = False  # has a value for all finite arguments
    inverse: Formula | None = None  # where it has one that is defined exactly for its values

    @property
    def in_numpy(self) -> str:
        """The name there; empty where it is built."""
        return self.numpy or ("" if self.built else self.name)

    @property
    def in_native(self) -> str:
        """The name there; empty where it is built."""
        return self.native or ("" if self.built else self.name)


def _minimum(f: Any, x: Any, y: Any) -> Any:
    return f.where(x <= y, 1.0, 0.0), f.where(x <= y, 0.0, 1.0)


def _maximum(f: Any, x: Any, y: Any) -> Any:
    return f.where(y <= x, 1.0, 0.0), f.where(y <= x, 0.0, 1.0)


def _chosen(f: Any, second: Any, first: Any, x: Any, y: Any) -> Any:
    """x or y; not a number where one of them is none."""
    return f.where(second, y, f.where(first, x, x + y))


def _angle(f: Any, y: Any, x: Any) -> Any:
    square = x * x + y * y
    return x / square, -(y / square)


_NOT_NEGATIVE = Sign.ZERO | Sign.PLUS

_ROWS = (
    Elementary("sin", 1, math.sin, lambda f, x: f.cos(x), size=1.0, total=True),
    Elementary("cos", 1, math.cos, lambda f, x: -f.sin(x), size=1.0, total=True),
    Elementary("tan", 1, math.tan, lambda f, x: 1.0 + f.tan(x) * f.tan(x), total=True),
    Elementary("asin", 1, math.asin, lambda f, x: 1.0 / f.sqrt(1.0 - x * x), "arcsin", odd=True),
    Elementary("acos", 1, math.acos, lambda f, x: -(1.0 / f.sqrt(1.0 - x * x)), "arccos",
               sign=_NOT_NEGATIVE),
    Elementary("atan", 1, math.atan, lambda f, x: 1.0 / (1.0 + x * x), "arctan", odd=True,
               total=True),
    Elementary("atan2", 2, math.atan2, _angle, "arctan2", units=Units.RATIO, total=True),
    Elementary("sinh", 1, math.sinh, lambda f, x: f.cosh(x), odd=True,
               inverse=lambda f, y: f.log(y + f.sqrt(y * y + 1.0))),
    Elementary("cosh", 1, math.cosh, lambda f, x: f.sinh(x), sign=Sign.PLUS),
    Elementary("tanh", 1, math.tanh, lambda f, x: 1.0 - f.tanh(x) * f.tanh(x), odd=True,
               size=1.0, total=True, inverse=lambda f, y: 0.5 * f.log((1.0 + y) / (1.0 - y))),
    Elementary("exp", 1, math.exp, lambda f, x: f.exp(x), sign=Sign.PLUS,
               inverse=lambda f, y: f.log(y)),
    Elementary("log", 1, math.log, lambda f, x: 1.0 / x, inverse=lambda f, y: f.exp(y)),
    Elementary("log10", 1, math.log10, lambda f, x: 0.4342944819032518 / x),
    Elementary("sqrt", 1, math.sqrt, lambda f, x: 0.5 / f.sqrt(x), native="llvm.sqrt.f64",
               units=Units.ROOT, sign=_NOT_NEGATIVE),
    Elementary("abs", 1, abs, lambda f, x: f.where(x < 0.0, -1.0, 1.0), native="llvm.fabs.f64",
               result=Result.SAME, units=Units.KEPT, sign=_NOT_NEGATIVE, total=True),
    Elementary("sign", 1, lambda x: float((x > 0.0) - (x < 0.0)), None, "sign",
               built=lambda f, x: f.where(x > 0.0, 1.0, f.where(x < 0.0, -1.0, x)),
               result=Result.INTEGER, units=Units.UNKNOWN, odd=True, size=1.0, total=True),
    Elementary("min", 2, min, _minimum, "minimum",
               built=lambda f, x, y: _chosen(f, y < x, x <= y, x, y),
               result=Result.EXTREME, units=Units.SAME, rises=True, total=True),
    Elementary("max", 2, max, _maximum, "maximum",
               built=lambda f, x, y: _chosen(f, y > x, y <= x, x, y),
               result=Result.EXTREME, units=Units.SAME, rises=True, total=True),
    Elementary("floor", 1, lambda x: float(math.floor(x)), None, native="llvm.floor.f64",
               units=Units.UNKNOWN, rises=True),
    Elementary("ceil", 1, lambda x: float(math.ceil(x)), None, native="llvm.ceil.f64",
               units=Units.UNKNOWN, rises=True),
    Elementary("div", 2, lambda x, y: float(math.trunc(x / y)), None,
               built=lambda f, x, y: f.trunc(x / y), result=Result.SAME, units=Units.UNKNOWN),
    Elementary("mod", 2, lambda x, y: x - math.floor(x / y) * y,
               lambda f, x, y: (1.0, -f.floor(x / y)),
               built=lambda f, x, y: x - f.floor(x / y) * y, result=Result.SAME, units=Units.SAME),
    Elementary("rem", 2, lambda x, y: x - math.trunc(x / y) * y,
               lambda f, x, y: (1.0, -f.div(x, y)),
               built=lambda f, x, y: x - f.trunc(x / y) * y, result=Result.SAME, units=Units.SAME),
)  # fmt: skip

#: Reductions of nothing (10.3.4.1); the greatest number is `Modelica.Constants.inf`.
OF_NOTHING = {"sum": 0.0, "product": 1.0, "min": float_info.max, "max": -float_info.max}

#: The rows by the functions' Modelica names.
TABLE: dict[str, Elementary] = {row.name: row for row in _ROWS}
