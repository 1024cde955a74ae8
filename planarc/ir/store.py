"""Writes data that holds expressions as bytes, and reads it back.

Expressions share nodes and form chains deeper than Python's recursion limit, so
the nodes below the data are written as columns, in the order of their numbers:

    operations    one byte a node
    data          of the nodes that have some
    counts        of each node's arguments
    arguments     their numbers, one after the other
    texts         those that numbers stand for

and every expression in the data as its `Place`, or with others as a `Placed`: most data is
statements. What a program has many of is written as columns, too, a field of all of them each
(`Rows`), and where that is expressions as `Places`: that takes half the time of one by one. A
compilation leaves many nodes behind that nothing uses any more; these are not written.
"""

from __future__ import annotations

import io
import pickle
from array import array
from collections.abc import Callable
from itertools import chain, compress, islice, repeat
from operator import attrgetter
from typing import Any

from msgspec.structs import astuple

from planarc.core import plain
from planarc.core.data import Data
from planarc.ir.expr import Expr, Exprs, Op
from planarc.ir.program import Let, Program

#: Operations whose nodes have data.
_TOLD = frozenset({Op.CONST, Op.SYMBOL, Op.PRE, Op.EVENT, Op.CALL, Op.APPLY, Op.PAST, Op.LOOP})
#: What is written as columns; plain values need no look.
_COLUMNS = (Expr, Data, tuple)


class Place(Data):
    """What is written for an expression: its number; -1 for the table."""

    number: int


class Placed(Data):
    """What is written for a statement: the numbers of its target and value, and its equation."""

    target: int
    value: int
    equation: int | None


class Rows(Data):
    """What is written for many values of one class, None for tuples of one length."""

    kind: type[Data] | None
    fields: tuple[Any, ...]  # each of all values


class Places(Data):
    """What is written for many expressions: their numbers."""

    numbers: array[int]


def dumps(value: object, table: Exprs) -> bytes:
    """`value` as bytes; all expressions in it belong to `table`."""
    buffer = io.BytesIO()
    needed = bytearray(len(table.all))

    def place(e: Expr) -> tuple[type[Place], tuple[int]]:
        needed[e.id] = True
        return Place, (e.id,)

    def set_of(let: Let) -> tuple[type[Placed], tuple[int, int, int | None]]:
        target, value = let.target.id, let.value.id
        needed[target] = needed[value] = True
        return Placed, (target, value, let.equation)

    def places(found: tuple[Expr, ...]) -> Places:
        numbers = array("I", map(attrgetter("id"), found))
        for number in numbers:
            needed[number] = True
        return Places(numbers)

    def fields(program: Program) -> tuple[type[Program], tuple[Any, ...]]:
        return Program, tuple(map(_in_columns, astuple(program), repeat(places)))

    pickler = pickle.Pickler(buffer, pickle.HIGHEST_PROTOCOL)
    pickler.dispatch_table = {
        Expr: place,
        Let: set_of,
        Exprs: lambda _: (Place, (-1,)),
        Program: fields,
    }
    pickler.dump(value)
    _mark_below(needed, table)
    nodes = list(compress(table.all, needed))
    args = [e.args for e in nodes]
    columns = (
        array("I", compress(range(len(needed)), needed)),
        bytes(map(attrgetter("op"), nodes)),
        [e.data for e in nodes if e.data is not None],
        array("I", map(len, args)),
        array("I", map(attrgetter("id"), chain.from_iterable(args))),
        sorted(table.texts),
    )
    return pickle.dumps((columns, buffer.getvalue()), pickle.HIGHEST_PROTOCOL)


def loads(data: bytes) -> Any:
    """Read what `dumps` wrote, with a table of its own. Only for data that planarc wrote."""
    (numbers, operations, told, counts, arguments, texts), body = plain.loads(data)
    table = Exprs()
    for text in texts:
        table.text(text)
    nodes: dict[int, Expr] = {}
    rest, below = iter(told), map(nodes.__getitem__, arguments)
    kinds = [(op, op in _TOLD) for op in Op]
    for number, operation, count in zip(numbers, operations, counts, strict=True):
        op, has_data = kinds[operation]
        node_data: Any = next(rest) if has_data else None
        if op is Op.CONST:
            nodes[number] = table.const(node_data)
        else:
            nodes[number] = table.node(op, tuple(islice(below, count)), node_data)
    return _Unpickler(io.BytesIO(body), table, nodes).load()


def _in_columns(value: Any, places: Callable[[tuple[Expr, ...]], Places]) -> Any:
    """A tuple as it is written, where all in it are of one kind; else the value itself."""
    kind: Any = type(value[0]) if type(value) is tuple and value else None
    if kind is None or not issubclass(kind, _COLUMNS) or set(map(type, value)) != {kind}:
        return value
    if kind is Expr:
        return places(value)
    own = issubclass(kind, Data)
    if not own and (kind is not tuple or len(set(map(len, value))) != 1):
        return value
    fields = zip(*map(astuple, value) if own else value, strict=True)
    written = tuple(_in_columns(field, places) for field in fields)
    return Rows(kind if own else None, written) if written else value


def _mark_below(needed: bytearray, table: Exprs) -> None:
    """Mark what marked nodes are made of, by numbers."""
    # Arguments have lower numbers than their users: they are marked before it is their turn.
    for e in compress(reversed(table.all), reversed(needed)):
        for a in e.args:
            needed[a.id] = True


class _Unpickler(plain.PlainReader):
    def __init__(self, buffer: io.BytesIO, table: Exprs, nodes: dict[int, Expr]) -> None:
        super().__init__(buffer)
        self._table = table
        self._nodes = nodes
        self._read = {Place: self._at, Placed: self._set, Places: self._all_at, Rows: _of_rows}

    def find_class(self, module: str, name: str) -> Any:
        found = super().find_class(module, name)
        return self._read.get(found, found)

    def _at(self, number: int) -> Expr | Exprs:
        return self._table if number < 0 else self._nodes[number]

    def _set(self, target: int, value: int, equation: int | None) -> Let:
        return Let(self._nodes[target], self._nodes[value], equation)

    def _all_at(self, numbers: array[int]) -> tuple[Expr, ...]:
        return tuple(map(self._nodes.__getitem__, numbers))


def _of_rows(kind: type[Data] | None, fields: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(zip(*fields, strict=True) if kind is None else map(kind, *fields))
