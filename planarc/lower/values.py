"""Values of lowered expressions: scalars, arrays of scalars, records, texts; whether arrays fit.

A scalar value is an `Expr` itself. Arrays are `Tensor`s of them. What sizes they have may be known
only where a function is called: with `input Real x[:]; input Real z[:];` the sum `x + z` fits
the call f({1, 2}, {3, 4}), and not f({1, 2}, {3}). The run of the function notes the call.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import TypeAlias

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Misfit
from planarc.core.prose import sized
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.expr import Expr
from planarc.runtime.tensor import Tensor, alike, elements, shape_of, stack, unfit, untaken


class RecordValue(Data):
    """A record value."""

    fields: tuple[tuple[str, Value], ...]

    def field(self, name: str) -> Value:
        return next(v for n, v in self.fields if n == name)


class FunctionValue(Data):
    """A function given as an argument, with some inputs bound."""

    function: str
    bound: tuple[tuple[str, Value], ...] = ()


class Text(Data):
    """A string: constant pieces and numbers to be formatted when it is shown."""

    parts: tuple[str | tuple[Expr, str], ...]

    @property
    def constant(self) -> str | None:
        """The text, if nothing in it depends on the run."""
        if all(isinstance(p, str) for p in self.parts):
            return "".join(p for p in self.parts if isinstance(p, str))
        return None


Value: TypeAlias = Expr | Tensor | RecordValue | FunctionValue | Text


def expr(value: Value) -> Expr:
    """A value that the types say is a scalar number or truth value."""
    assert isinstance(value, Expr), f"scalar expected, got {value!r}"
    return value


def exprs(value: Value) -> tuple[Expr, ...]:
    return tuple(expr(v) for v in elements(value))


def known_of(value: Value) -> object:
    """What is known of a value: its numbers, and those that stand foremost in what is not known.

    Example: of {3, x, 2*x + 1} the numbers {3, (), (1)}.
    """
    match value:
        case Expr():
            return value.data if value.is_const else tuple([known_of(a) for a in _numbers(value)])
        case Tensor():
            return value.shape, tuple(map(known_of, value.items))
        case RecordValue():
            return tuple([known_of(v) for _, v in value.fields])
    return value


def _numbers(e: Expr) -> list[Expr]:
    return [a for a in e.args if a.is_const]


def scalar_names(name: str, dims: Sequence[int]) -> tuple[str, ...]:
    """`r` of dimensions (2,) is `r[1]`, `r[2]`."""
    if not dims:
        return (name,)
    numbers = (map(str, range(1, n + 1)) for n in dims)
    return tuple([f"{name}[{','.join(s)}]" for s in product(*numbers)])


def fixed_dims(type_: flat.Type) -> tuple[int, ...]:
    """The dimensions of a variable of the model, which are all known."""
    return tuple([n for n in type_.dims if n is not None]) if type_.dims else ()


# Sizes -------------------------------------------------------------------------------------------


def expect_fit(operator: str, a: Value, b: Value, span: Span) -> None:
    """Refuse operands of sizes that an operator does not join."""
    if message := unfit(operator, shape_of(a), shape_of(b)):
        raise Misfit(Diagnostic("L314", message, span))


def expect_alike(function: str, arguments: Sequence[Value], span: Span) -> None:
    """Refuse arrays of different sizes where a function acts entry by entry."""
    if not alike(map(shape_of, arguments)):
        raise misfit_of(function, arguments, span)


def misfit_of(function: str, arguments: Sequence[Value], span: Span) -> Misfit:
    """The error of arrays that a function cannot take."""
    written = "[...]" if span.text.startswith("[") else function  # a matrix, joined by `cat`
    return Misfit(Diagnostic("L314", untaken(written, map(shape_of, arguments)), span))


def expect_size(what: str, wanted: flat.Dims, value: Value, span: Span) -> None:
    """Refuse an array of other sizes than what it is assigned to."""
    if not isinstance(value, Tensor) or conform(wanted, value.shape):
        return
    message = f"{what} has {sized([wanted])}, its value {sized([value.shape])}"
    raise Misfit(Diagnostic("L331", message, span))


def conform(wanted: flat.Dims, shape: tuple[int, ...]) -> bool:
    """Whether an array has the sizes that are known; of nothing not all are."""
    if not math.prod(shape) and 0 in wanted:
        return True
    return len(wanted) == len(shape) and all(
        w in (None, n) for w, n in zip(wanted, shape, strict=True)
    )


def stacked(rows: Sequence[Value], inner: tuple[int, ...], span: Span) -> Tensor:
    """Values side by side as one array, refused where their sizes differ."""
    other = next((r for r in rows if shape_of(r) != shape_of(rows[0])), None)
    if other is not None:
        sizes = sized([shape_of(rows[0]), shape_of(other)])
        raise Misfit(Diagnostic("L314", f"the entries of an array have {sizes}", span))
    return stack(rows, inner)
