"""Values of lowered expressions: scalars, arrays of scalars, records, texts.

A scalar value is an `Expr` itself. Arrays are `Tensor`s of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TypeAlias

from planarc.core.data import Data
from planarc.ir import flat
from planarc.ir.expr import Expr
from planarc.runtime.tensor import Tensor, elements


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
