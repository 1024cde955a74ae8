"""Writes data that holds expressions as bytes, and reads it back.

Expressions share nodes and form chains deeper than Python's recursion limit, so
the nodes below the data are written as columns, in the order of their numbers:

    operations    one byte a node
    data          of the nodes that have some
    counts        of each node's arguments
    arguments     their numbers, one after the other
    texts         those that numbers stand for

and every expression in the data as its `Place`. A compilation leaves many nodes behind
that nothing uses any more; these are not written.
"""

from __future__ import annotations

import io
import pickle
from array import array
from itertools import islice
from typing import Any

from planarc.core import plain
from planarc.core.data import Data
from planarc.ir.expr import Expr, Exprs, Op

#: Operations whose nodes have data.
_TOLD = frozenset({Op.CONST, Op.SYMBOL, Op.PRE, Op.EVENT, Op.CALL, Op.APPLY, Op.PAST})


class Place(Data):
    """What is written for an expression: its number; -1 for the table."""

    number: int


def dumps(value: object, table: Exprs) -> bytes:
    """`value` as bytes; all expressions in it belong to `table`."""
    buffer = io.BytesIO()
    pickler = _Pickler(buffer, table)
    pickler.dump(value)
    nodes = _nodes_below(pickler.found, table)
    columns = (
        array("I", [e.id for e in nodes]),
        bytes([e.op for e in nodes]),
        [e.data for e in nodes if e.op in _TOLD],
        array("I", [len(e.args) for e in nodes]),
        array("I", [a.id for e in nodes for a in e.args]),
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


def _nodes_below(numbers: set[int], table: Exprs) -> list[Expr]:
    """The nodes of these numbers and all that they are made of, in ascending order."""
    needed = bytearray(len(table.all))
    for number in numbers:
        needed[number] = True
    found = []
    for e in reversed(table.all):  # arguments have lower numbers than what uses them
        if needed[e.id]:
            found.append(e)
            for a in e.args:
                needed[a.id] = True
    found.reverse()
    return found


class _Pickler(pickle.Pickler):
    def __init__(self, buffer: io.BytesIO, table: Exprs) -> None:
        super().__init__(buffer, pickle.HIGHEST_PROTOCOL)
        self._table = table
        self.found: set[int] = set()  # numbers of the expressions met so far

    # Asked once for each object, and never for texts, numbers and containers.
    def reducer_override(self, value: object) -> Any:
        if isinstance(value, Expr):
            self.found.add(value.id)
            return Place, (value.id,)
        return (Place, (-1,)) if value is self._table else NotImplemented


class _Unpickler(plain.PlainReader):
    def __init__(self, buffer: io.BytesIO, table: Exprs, nodes: dict[int, Expr]) -> None:
        super().__init__(buffer)
        self._table = table
        self._nodes = nodes

    def find_class(self, module: str, name: str) -> Any:
        found = super().find_class(module, name)
        return self._at if found is Place else found

    def _at(self, number: int) -> Expr | Exprs:
        return self._table if number < 0 else self._nodes[number]
