"""Fewer tears: an unknown that follows from the other tears need not be guessed.

In:   rows         unknowns of each equation, each with whether it can be solved for it
      Torn         tears chosen one after the other, by rank
      droppable    the tears that may be given up, in the order in which to try
Out:  Torn         of the same kind, with as many tears and residuals less as could be

A greedy choice by rank tears what a later tear would have given: the nine entries of a
rotation before the four quaternions that they follow from. Each tear is left out once;
when the others still give every unknown, it stays out, and the equation that gives it
is no residual any more.

Example: rows q.t, qt (t := f(q)), both torn: t follows from q.

Promises:  tears - residuals stays the same; every unknown is a tear or assigned once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from planarc.structure.tearing import Torn

Rows = Sequence[Sequence[tuple[int, bool]]]


def thin_tears(rows: Rows, torn: Torn, droppable: Sequence[int]) -> Torn:
    columns: list[list[int]] = [[] for _ in range(len(torn.tears) + len(torn.assignments))]
    for e, row in enumerate(rows):
        for v, _ in row:
            columns[v].append(e)
    for v in droppable:
        if not torn.residuals:
            break
        tears, assignments = _follow(rows, columns, [u for u in torn.tears if u != v])
        if len(tears) + len(assignments) == len(columns):
            used = {e for _, e in assignments}
            residuals = tuple(e for e in range(len(rows)) if e not in used)
            torn = Torn(tuple(tears), tuple(assignments), residuals)
    return torn


def _follow(
    rows: Rows, columns: Sequence[Sequence[int]], tears: Iterable[int]
) -> tuple[list[int], list[tuple[int, int]]]:
    """The tears that others do not give, and what they all give: (unknown, equation) in
    order of evaluation."""
    known = [False] * len(columns)
    left = [len(row) for row in rows]
    ready = deque(e for e, count in enumerate(left) if count == 1)
    found: list[tuple[int, int]] = []

    def determine(v: int) -> None:
        known[v] = True
        for e in columns[v]:
            left[e] -= 1
            if left[e] == 1:
                ready.append(e)

    def propagate() -> None:
        while ready:
            e = ready.popleft()
            if left[e] == 1:
                v, solvable = next(item for item in rows[e] if not known[item[0]])
                if solvable:
                    found.append((v, e))
                    determine(v)

    propagate()
    needed = []
    for v in tears:
        if not known[v]:
            needed.append(v)
            determine(v)
            propagate()
    return needed, found
