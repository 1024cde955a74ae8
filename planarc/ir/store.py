"""Writes data that holds expressions as bytes, and reads it back.

Expressions share nodes and form chains deeper than Python's recursion limit, so
the table is written as rows (operation, data, arguments) and every expression
in the data as its row number.
"""

from __future__ import annotations

import io
import pickle
from typing import Any

from planarc.ir.expr import Expr, Exprs, Op


def dumps(value: object, table: Exprs) -> bytes:
    """`value` as bytes; all expressions in it belong to `table`."""
    buffer = io.BytesIO()
    pickler = _Pickler(buffer, table)
    pickler.dump(value)
    rows = [(int(e.op), e.data, tuple(a.id for a in e.args)) for e in table.all]
    return pickle.dumps((rows, buffer.getvalue()), pickle.HIGHEST_PROTOCOL)


def loads(data: bytes) -> Any:
    """What `dumps` wrote, with a table of its own. Only for data that planarc wrote."""
    rows, body = pickle.loads(data)
    table = Exprs()
    for op, node_data, args in rows[len(table.all) :]:
        if op == Op.CONST:
            table.const(node_data)
        else:
            table.node(Op(op), tuple(table.all[a] for a in args), node_data)
    return _Unpickler(io.BytesIO(body), table).load()


class _Pickler(pickle.Pickler):
    def __init__(self, buffer: io.BytesIO, table: Exprs) -> None:
        super().__init__(buffer, pickle.HIGHEST_PROTOCOL)
        self._table = table

    def persistent_id(self, value: object) -> int | None:
        if isinstance(value, Expr):
            return value.id
        return -1 if value is self._table else None


class _Unpickler(pickle.Unpickler):
    def __init__(self, buffer: io.BytesIO, table: Exprs) -> None:
        super().__init__(buffer)
        self._table = table

    def persistent_load(self, key: int) -> Expr | Exprs:
        return self._table if key < 0 else self._table.all[key]
