"""Tables of pairs that were written with commas alone, and so in one row.

In:   parameters with their values
Out:  a warning F337 for each

A row of a matrix ends with a semicolon. A table of one row has the same outputs all the while. It
is told where its numbers can be read as pairs whose first ones increase; a row of two numbers is a
constant that was meant.

Example: `table=[0, 0, 0.5, 8, 1, 8]` for `table=[0, 0; 0.5, 8; 1, 8]`.
"""

from __future__ import annotations

from itertools import pairwise

from planarc.flatten.checks.parameters import Pairs
from planarc.flatten.terms.conform import in_rows, numbers_of
from planarc.flatten.tree.nodes import Session

#: How the parameter is called in all blocks that hold a table.
_TABLE = "table"
#: A point of a table, and the numbers of two points.
_PAIR, _TWO_POINTS = 2, 4


def check_tables(pairs: Pairs, session: Session) -> None:
    for leaf, variable in pairs:
        if variable is None or variable.binding is None:
            continue
        value = variable.binding
        if leaf.name.rpartition(".")[2] != _TABLE or value.type.dims[:1] != (1,):
            continue
        numbers = numbers_of(value.span)
        points = in_rows(value.span, _PAIR)
        if points is None or len(numbers) < _TWO_POINTS:
            continue
        if all(a < b for a, b in pairwise(numbers[::_PAIR])):
            session.warn(
                "F337",
                f"all numbers of `{leaf.name}` stand in one row, so that what it gives never "
                "changes",
                value.span,
                f"a semicolon ends a row: write `{points}`",
            )
