"""Values of lowered expressions: scalars, arrays of scalars, records, texts.

A scalar value is an `Expr` itself. Arrays are `Tensor`s, row by row (the last
subscript runs fastest), of any number of dimensions, also of size zero.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from planarc.core.data import Data
from planarc.ir import flat
from planarc.ir.expr import Expr


class Tensor(Data):
    """An array: as many `items` as the product of `shape`."""

    shape: tuple[int, ...]
    items: tuple[Value, ...]

    def rows(self) -> tuple[Value, ...]:
        """The entries along the first dimension."""
        return self.items if len(self.shape) == 1 else tuple(map(self.row, range(self.shape[0])))

    def row(self, i: int) -> Value:
        """The entry at `i` along the first dimension, counted from 0."""
        inner = self.shape[1:]
        if not inner:
            return self.items[i]
        size = math.prod(inner)
        return Tensor(inner, self.items[i * size : (i + 1) * size])


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


def shape_of(value: Value) -> tuple[int, ...]:
    return value.shape if isinstance(value, Tensor) else ()


def stack(rows: Sequence[Value], inner: tuple[int, ...] = ()) -> Tensor:
    """Equal values side by side as one array with a dimension more; `inner` if there are none."""
    if not rows:
        return Tensor((0, *inner), ())
    first = rows[0]
    if isinstance(first, Tensor):
        items = tuple(x for r in rows if isinstance(r, Tensor) for x in r.items)
        return Tensor((len(rows), *first.shape), items)
    return Tensor((len(rows),), tuple(rows))


def elements(value: Value) -> tuple[Value, ...]:
    """All scalar entries (a scalar is its own only one)."""
    return value.items if isinstance(value, Tensor) else (value,)


def expr(value: Value) -> Expr:
    """A value that the types say is a scalar number or truth value."""
    assert isinstance(value, Expr), f"scalar expected, got {value!r}"
    return value


def exprs(value: Value) -> tuple[Expr, ...]:
    return tuple(expr(v) for v in elements(value))


def each(function: Callable[..., Value], *values: Value) -> Value:
    """A scalar function on every entry; scalars stand for arrays of the others' shape."""
    shape = next((v.shape for v in values if isinstance(v, Tensor)), None)
    if shape is None:
        return function(*values)
    size = math.prod(shape)
    columns = [v.items if isinstance(v, Tensor) else (v,) * size for v in values]
    return Tensor(shape, tuple(function(*row) for row in zip(*columns, strict=True)))


def transpose(a: Tensor) -> Tensor:
    rows, columns = a.shape[:2]
    inner = math.prod(a.shape[2:])
    items = tuple(
        a.items[(r * columns + c) * inner + k]
        for c in range(columns)
        for r in range(rows)
        for k in range(inner)
    )
    return Tensor((columns, rows, *a.shape[2:]), items)


def subscripts(dims: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """All subscripts of an array, counted from 1, the last fastest."""
    return itertools.product(*(range(1, n + 1) for n in dims))


def scalar_names(name: str, dims: Sequence[int]) -> tuple[str, ...]:
    """`r` of dimensions (2,) is `r[1]`, `r[2]`."""
    if not dims:
        return (name,)
    return tuple(f"{name}[{','.join(map(str, s))}]" for s in subscripts(dims))


def fixed_dims(type_: flat.Type) -> tuple[int, ...]:
    """The dimensions of a variable of the model, which are all known."""
    return tuple(n for n in type_.dims if n is not None)
