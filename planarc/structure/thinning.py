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

from collections.abc import Sequence

from planarc.structure.graph import columns_of
from planarc.structure.tearing import Propagation, Rows, Torn


def thin_tears(rows: Rows, torn: Torn, droppable: Sequence[int]) -> Torn:
    count = len(torn.tears) + len(torn.assignments)
    columns = columns_of([[v for v, _ in row] for row in rows], count)
    for v in droppable:
        if not torn.residuals:
            break
        found = Propagation(rows, columns)
        found.propagate()
        for u in torn.tears:
            if u != v and not found.known[u]:
                found.tear(u)
        if len(found.tears) + len(found.assignments) == count:
            torn = found.torn()
    return torn
