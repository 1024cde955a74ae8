"""A sparse linear system and the operations that solve it, as whole numbers.

`codegen.elimination` writes them. Unknowns are the tears and behind them the inner unknowns, each
of which is given by the row of its number; the rows behind these are the residuals:

    inner row      its unknown = constant + sum of value*unknown
    residual       0 = constant + sum of value*unknown

With each sum comes its size, that of all its terms, |constant| + sum of |value|*size(unknown):
residuals of a good solution are some 1e-15 of that, in whatever units they are (running error
analysis; N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002, 3.3).

Numbers are told by their indices: first come the `program.Direct.values`, which are known before
the block, then what each operation gives. A reference is twice the index, and one more for the
negative.

    rows          how many unknowns and tears there are (`Head`); then of each row its constant,
                  count, and count times unknown and value
    operations    references (a, b, c) for a + b*c, and (p,) for 1/p; b alone may be a negative
    tears         the reference of each

The operations become code; the native back end keeps the rows as a table that it goes through.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import IntEnum
from typing import TypeAlias

from planarc.ir.expr import Expr, Exprs, Op
from planarc.ir.program import Direct

#: A row: its constant, and of each entry the unknown and the value.
Row: TypeAlias = "tuple[int, list[tuple[int, int]]]"


class Head(IntEnum):
    """Counts at the beginning of the rows."""

    UNKNOWNS = 0
    TEARS = 1


SIZE = len(Head)


def read_rows(rows: Sequence[int]) -> list[Row]:
    """The rows of the system, as many as unknowns."""
    found, at = [], SIZE
    for _ in range(rows[Head.UNKNOWNS]):
        constant, count = rows[at : at + 2]
        at += 2 + 2 * count
        entries = rows[at - 2 * count : at]
        found.append((constant, list(zip(entries[::2], entries[1::2], strict=True))))
    return found


def operations_of(direct: Direct) -> Iterator[tuple[int | None, bool, list[int]]]:
    """The operations by indices of numbers, without zeros and factors of 1: what something is added
    to; whether it is taken from that; its factors. Of an inverse there are none."""
    kept = [e.data if e.op is Op.CONST else None for e in direct.values]
    zeros, ones = ({i for i, number in enumerate(kept) if number == n} for n in (0, 1))
    for first, *factors in direct.operations:
        a = first >> 1
        if factors:
            b, c = factors
            named = [b >> 1] if c >> 1 in ones else [b >> 1, c >> 1]
            yield None if a in zeros else a, bool(b & 1), named
        else:
            yield a, False, []


def constant_name(e: Expr) -> str:
    """The symbol whose slot holds a number."""
    return f"$c[{e}]"


def entries_of(direct: Direct) -> list[Expr]:
    """The values of the matrix."""
    return [direct.values[v] for _, entries in read_rows(direct.rows) for _, v in entries]


def residuals_of(table: Exprs, direct: Direct) -> tuple[Expr, ...]:
    """The residuals as formulas of the unknowns."""
    values, unknowns = direct.values, direct.unknowns
    inner = len(unknowns) - direct.rows[Head.TEARS]
    return tuple(
        table.add(values[constant], *(table.mul(values[v], unknowns[j]) for j, v in entries))
        for constant, entries in read_rows(direct.rows)[inner:]
    )
