"""Arrays of known sizes, and the functions that build or reshape them, each written once.

A value is a scalar, of whatever kind, or a `Tensor` of scalars. The rules compute by `t`, which
has `zero`, `one`, `const`, `add`, `sub`, `mul` and `neg`: so they serve numbers
(`flatten.values.compute`), typed expressions (`flatten.typing.arrays`) and scalar ones (`lower`).

Example: `FUNCTIONS["skew"](t, {x, y, z})` is the 3 x 3 tensor {0, -z, y, z, 0, -x, -y, x, 0}.

Promises:  sizes that do not fit raise ValueError or IndexError, arrays that are too large TooLarge.
Reference: Modelica Language Specification 3.6, sections 10.3, 10.4.2 and 10.6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar, cast

from planarc.core.data import Data
from planarc.core.prose import sized

V = TypeVar("V")  # a value: a scalar or a `Tensor`

MAX_ENTRIES = 4_000_000  # of one array


class TooLarge(Exception):
    """An array has more entries than could be worked with."""


class Tensor(Data):
    """An array: as many `items` as the product of `shape`, row by row (the last subscript
    runs fastest), of any number of dimensions, also of size zero."""

    shape: tuple[int, ...]
    items: tuple[Any, ...]

    def rows(self) -> tuple[Any, ...]:
        """The entries along the first dimension."""
        return self.items if len(self.shape) == 1 else tuple(map(self.row, range(self.shape[0])))

    def row(self, i: int) -> Any:
        """The entry at `i` along the first dimension, counted from 0."""
        inner = self.shape[1:]
        if not inner:
            return self.items[i]
        size = math.prod(inner)
        return Tensor(inner, self.items[i * size : (i + 1) * size])


def shape_of(value: Any) -> tuple[int, ...]:
    return value.shape if isinstance(value, Tensor) else ()


def elements(value: Any) -> tuple[Any, ...]:
    """All scalar entries (a scalar is its own only one)."""
    return value.items if isinstance(value, Tensor) else (value,)


def stack(rows: Sequence[Any], inner: tuple[int, ...] = ()) -> Tensor:
    """Equal values side by side as one array with a dimension more; `inner` if there are none."""
    if rows and not isinstance(rows[0], Tensor):
        return Tensor((len(rows),), tuple(rows))
    shape = rows[0].shape if rows else inner
    return Tensor((len(rows), *shape), tuple(x for r in rows for x in r.items))


def alike(shapes: Iterable[tuple[int, ...]]) -> bool:
    """Whether arrays fit entry by entry. A scalar fits any; of nothing not all sizes are known."""
    return len({s if math.prod(s) else (0,) for s in shapes if s}) < 2


def unfit(operator: str, a: tuple[int, ...], b: tuple[int, ...]) -> str | None:
    """What keeps an operator from joining values of these shapes (10.6), whose types fit."""
    if operator == "^":
        return f"`^` needs a square matrix, not one of {sized([a])}" if len({*a}) > 1 else None
    fits = a[-1] == b[0] if operator == "*" and a and b else alike((a, b))
    return None if fits else f"`{operator}` cannot join arrays of {sized([a, b])}"


def untaken(function: str, shapes: Iterable[tuple[int, ...]]) -> str:
    """That a function cannot take arguments of these shapes."""
    arrays = [s for s in shapes if s]
    if not arrays:
        return f"`{function}` cannot take arguments of these sizes"
    what = "an array" if len(arrays) == 1 else "arrays"
    return f"`{function}` cannot take {what} of {sized(arrays)}"


def each(function: Callable[..., V], *values: V) -> V:
    """A scalar function on every entry; scalars stand for arrays of the others' shape."""
    shapes = [v.shape for v in values if isinstance(v, Tensor)]
    if not shapes:
        return function(*values)
    if len(shapes) > 1 and not alike(shapes):
        raise ValueError
    shape = shapes[0]
    size = math.prod(shape)
    columns = [v.items if isinstance(v, Tensor) else (v,) * size for v in values]
    items = tuple([function(*row) for row in zip(*columns, strict=True)])
    return cast(V, Tensor(shape, items))


# Products ---------------------------------------------------------------------------------


def product(t: Any, a: V, b: V) -> V:
    """`a*b`: by a scalar, inner product, or matrix product (10.6.4)."""
    if not isinstance(a, Tensor) or not isinstance(b, Tensor):
        return each(t.mul, a, b)
    if len(a.shape) > 1:
        return cast(V, stack([product(t, row, b) for row in a.rows()], b.shape[1:]))
    if len(b.shape) > 1:
        rows, n = b.shape
        columns = (Tensor((rows,), b.items[c::n]) for c in range(n))
        return cast(V, stack([product(t, a, column) for column in columns]))
    products = (t.mul(x, y) for x, y in zip(a.items, b.items, strict=True))
    return cast(V, t.add(*products))


def power(t: Any, a: V, exponent: int) -> V:
    """`a^exponent` of a square matrix, by squaring."""
    result, square = cast(V, identity(t, shape_of(a)[0])), a
    while exponent > 0:
        if exponent % 2:
            result = product(t, result, square)
        exponent //= 2
        if exponent:
            square = product(t, square, square)
    return result


# Functions --------------------------------------------------------------------------------


def _made(shape: tuple[int, ...], entry: Callable[..., Any]) -> Tensor:
    """A matrix, maybe of arrays, entry by entry from its subscripts, counted from 0."""
    _bound(math.prod(shape))
    entries = (entry(r, c) for r in range(shape[0]) for c in range(shape[1]))
    return Tensor(shape, tuple(x for e in entries for x in elements(e)))


def _bound(entries: int) -> None:
    if entries > MAX_ENTRIES:
        raise TooLarge


def fill(t: Any, value: Any, *sizes: int) -> Any:
    """An array of equal entries; no sizes give the value itself."""
    inner = shape_of(value)
    _bound(math.prod((*sizes, *inner)))
    items = elements(value) * math.prod(sizes)
    return Tensor((*sizes, *inner), items) if sizes else value


def identity(t: Any, n: int) -> Tensor:
    return _made((n, n), lambda r, c: t.one if r == c else t.zero)


def _diagonal(t: Any, v: Tensor) -> Tensor:
    n = len(v.items)
    return _made((n, n), lambda r, c: v.items[r] if r == c else t.zero)


def _linspace(t: Any, first: Any, last: Any, n: int) -> Tensor:
    _bound(n)
    distance = t.sub(last, first)
    inner = (t.add(first, t.mul(distance, t.const(i / (n - 1)))) for i in range(1, n - 1))
    if n < 2:
        raise ValueError
    return Tensor((n,), (first, *inner, last))


def transpose(t: Any, a: Tensor) -> Tensor:
    rows, columns, *inner = a.shape
    lines = [r.rows() if isinstance(r, Tensor) else r for r in a.rows()]
    return _made((columns, rows, *inner), lambda r, c: lines[c][r])


def _cross(t: Any, a: Tensor, b: Tensor) -> Tensor:
    x, y = a.items, b.items
    if not len(x) == len(y) == 3:
        raise ValueError
    return stack([t.sub(t.mul(x[i], y[j]), t.mul(x[j], y[i])) for i, j in ((1, 2), (2, 0), (0, 1))])


def _skew(t: Any, a: Tensor) -> Tensor:
    x, y, z = a.items
    return Tensor((3, 3), (t.zero, t.neg(z), y, z, t.zero, t.neg(x), t.neg(y), x, t.zero))


def _outer_product(t: Any, a: Tensor, b: Tensor) -> Tensor:
    return _made((*a.shape, *b.shape), lambda r, c: t.mul(a.items[r], b.items[c]))


def _symmetric(t: Any, a: Tensor) -> Tensor:
    rows, n = a.shape
    if rows != n:
        raise ValueError
    return _made(a.shape, lambda r, c: a.items[min(r, c) * n + max(r, c)])


def _scalar(t: Any, value: Any) -> Any:
    (item,) = elements(value)
    return item


def _vector(t: Any, value: Any) -> Tensor:
    items = elements(value)
    if sum(n != 1 for n in shape_of(value)) > 1:
        raise ValueError
    return Tensor((len(items),), items)


def _matrix(t: Any, value: Any) -> Tensor:
    rows, columns, *inner = (*shape_of(value), 1, 1)
    if any(n != 1 for n in inner):
        raise ValueError
    return Tensor((rows, columns), elements(value))


def concatenate(t: Any, dimension: int, *values: Any) -> Tensor:
    """Arrays joined along a dimension, counted from 1."""
    tensors = [v if isinstance(v, Tensor) else stack([v]) for v in values]
    if dimension > 1:
        lines = zip(*(v.rows() for v in tensors), strict=True)
        inner = (*tensors[0].shape[1 : dimension - 1], sum(v.shape[dimension - 1] for v in tensors))
        return stack([concatenate(t, dimension - 1, *line) for line in lines], inner)
    if len({v.shape[1:] for v in tensors}) > 1:
        raise ValueError
    _bound(sum(len(v.items) for v in tensors))
    return stack([row for v in tensors for row in v.rows()], tensors[0].shape[1:])


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "zeros": lambda t, *sizes: fill(t, t.zero, *sizes),
    "ones": lambda t, *sizes: fill(t, t.one, *sizes),
    "fill": fill,
    "identity": identity,
    "diagonal": _diagonal,
    "linspace": _linspace,
    "transpose": transpose,
    "cross": _cross,
    "skew": _skew,
    "outerProduct": _outer_product,
    "symmetric": _symmetric,
    "scalar": _scalar,
    "vector": _vector,
    "matrix": _matrix,
    "cat": concatenate,
}

#: The arguments that are sizes or dimensions, which the rules take as plain numbers.
COUNTS = {
    "zeros": slice(0, None),
    "ones": slice(0, None),
    "fill": slice(1, None),
    "identity": slice(0, 1),
    "linspace": slice(2, 3),
    "cat": slice(0, 1),
}


def apply(t: Any, name: str, count: Callable[[Any], int], arguments: Sequence[V]) -> V:
    """The value of one of `FUNCTIONS`; `count` makes a number of a size."""
    given: list[Any] = list(arguments)
    counts = COUNTS.get(name, slice(0, 0))
    given[counts] = map(count, given[counts])
    return cast(V, FUNCTIONS[name](t, *given))
