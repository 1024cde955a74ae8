"""Incidence of a system of equations, as numbers only.

The graph algorithms of this stage (`matching`, `pantelides`, `blocks`, `tearing`)
see equations and unknowns as integers. A row is an equation and lists its
unknowns; a column is an unknown.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

#: The unknowns of each equation.
Rows: TypeAlias = Sequence[Sequence[int]]


def columns_of(rows: Rows, count: int) -> list[list[int]]:
    """The equations of each of `count` unknowns, in ascending order."""
    columns: list[list[int]] = [[] for _ in range(count)]
    for e, row in enumerate(rows):
        for v in row:
            columns[v].append(e)
    return columns


def reachable(start: Iterable[int], successors: Sequence[Iterable[int]]) -> list[bool]:
    """The nodes that can be reached from `start`, itself included."""
    seen = [False] * len(successors)
    stack = list(start)
    while stack:
        node = stack.pop()
        if not seen[node]:
            seen[node] = True
            stack.extend(n for n in successors[node] if not seen[n])
    return seen
