"""Columns of a sparse Jacobian that one run of its tangent gives together.

In:   Tangent
Out:  `Groups`: columns of which no row has two, and where each row's entry belongs

A row moves with a few tears only. Where the seeds of columns are 1 that no row shares, each entry
has the same bits as with one of them: the others meet nothing in it but zeros. A long row of loops
takes as many runs as one of its loops does.

Example, where x may be other than zero:

    x x . .
    . x x .    columns 0 and 2, then columns 1 and 3
    . . x x

Reference: A. R. Curtis, M. J. D. Powell, J. K. Reid, J. Inst. Maths Applics 13, 1974, 117-119.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.data import Data
from planarc.ir.expr import Expr, below
from planarc.ir.program import Tangent


class Groups(Data):
    of: tuple[int, ...]  # the group of each column
    columns: tuple[tuple[int, ...], ...]  # row by row, for each group, the column of its entry


def group_columns(tangent: Tangent) -> Groups:
    """The groups of a tangent's columns."""
    return grouped(_reached(tangent), len(tangent.seeds))


def grouped(rows: Sequence[frozenset[int]], count: int) -> Groups:
    """Columns `0 .. count`, each in the first group where none shares a row with it. A row that
    has none of a group's columns gives a zero for the first of them."""
    having: list[set[int]] = [set() for _ in range(count)]
    for i, row in enumerate(rows):
        for j in row:
            having[j].add(i)
    taken: list[set[int]] = []  # by each group, rows
    of = []
    for own in having:
        group = next((g for g, others in enumerate(taken) if others.isdisjoint(own)), len(taken))
        if group == len(taken):
            taken.append(set())
        taken[group] |= own
        of.append(group)
    first = [of.index(group) for group in range(len(taken))]
    columns = []
    for row in rows:
        found = list(first)
        for j in row:
            found[of[j]] = j
        columns.append(tuple(found))
    return Groups(tuple(of), tuple(columns))


def _reached(tangent: Tangent) -> list[frozenset[int]]:
    """The columns that each row moves with."""
    moving: dict[Expr, frozenset[int]] = {s: frozenset((j,)) for j, s in enumerate(tangent.seeds)}

    def reach(value: Expr) -> frozenset[int]:
        return frozenset().union(*(moving[e] for e in below((value,)) if e in moving))

    for let in tangent.body:
        moving[let.target] = reach(let.value)
    return [reach(entry) for entry in tangent.entries]
