"""Matching of equations with unknowns, and what remains when there is none.

In:   Rows       unknowns of each equation
Out:  Matching   an unknown for as many equations as possible
      Parts      the over- and the under-determined part of a system

Example: three equations, the first two in the same single unknown.

    e0  {a}        a <- e0
    e1  {a}        no unknown left: over-determined part {e0, e1} in {a}
    e2  {b, c}     b <- e2, under-determined part {b, c} in {e2}

Needs:     nothing.
Promises:  the matching is a maximum one; given pairs of `start` stay matched
           equations and unknowns (perhaps with other partners).
Reference: A. Pothen, C.-J. Fan, ACM Trans. Math. Softw. 16(4), 1990, 303-324
           (phases of depth-first search with lookahead, and the coarse
           Dulmage-Mendelsohn decomposition).
"""

from __future__ import annotations

from planarc.core.data import Data
from planarc.structure.graph import Rows, columns_of, reachable


class Matching(Data):
    """-1 stands for no partner."""

    variable: tuple[int, ...]  # of each equation
    equation: tuple[int, ...]  # of each unknown

    @property
    def exposed(self) -> list[int]:
        """Equations without an unknown."""
        return [e for e, v in enumerate(self.variable) if v < 0]

    @property
    def complete(self) -> bool:
        return -1 not in self.variable


def match_equations(rows: Rows, columns: int, start: Matching | None = None) -> Matching:
    """A maximum matching, grown from `start`."""
    variable = list(start.variable) if start else [-1] * len(rows)
    equation = list(start.equation) if start else [-1] * columns
    looked = [0] * len(rows)  # lookahead: unknowns before this position are taken
    waiting = [e for e in range(len(rows)) if variable[e] < 0]
    while waiting:
        visited = [False] * len(rows)
        rest = [e for e in waiting if not _augment(e, rows, variable, equation, looked, visited)]
        if len(rest) == len(waiting):
            break
        waiting = rest
    return Matching(tuple(variable), tuple(equation))


def _augment(
    root: int,
    rows: Rows,
    variable: list[int],
    equation: list[int],
    looked: list[int],
    visited: list[bool],
) -> bool:
    """Give `root` an unknown by moving others along an alternating path, if there is one."""
    path = [(root, -1)]  # equation, and the unknown that led to it
    position = {root: 0}
    visited[root] = True
    while path:
        e, _ = path[-1]
        row = rows[e]
        while looked[e] < len(row):
            v = row[looked[e]]
            looked[e] += 1
            if equation[v] < 0:
                for holder, taken in reversed(path):
                    variable[holder], equation[v] = v, holder
                    v = taken
                return True
        step = position[e]
        while step < len(row) and visited[equation[row[step]]]:
            step += 1
        position[e] = step + 1
        if step == len(row):
            path.pop()
            continue
        v = row[step]
        visited[equation[v]] = True
        position[equation[v]] = 0
        path.append((equation[v], v))
    return False


class Parts(Data):
    """Equations and unknowns of the two parts that cannot be solved, in ascending order."""

    over_equations: tuple[int, ...]
    over_variables: tuple[int, ...]
    under_equations: tuple[int, ...]
    under_variables: tuple[int, ...]


def find_singular_parts(rows: Rows, columns: int, matching: Matching) -> Parts:
    """The coarse Dulmage-Mendelsohn parts: empty ones where the system is regular."""
    matched = matching.equation
    to_equations = [[matched[v] for v in row if matched[v] >= 0] for row in rows]
    over = reachable(matching.exposed, to_equations)
    by_column = columns_of(rows, columns)
    to_variables = [
        [matching.variable[e] for e in column if matching.variable[e] >= 0] for column in by_column
    ]
    under = reachable((v for v in range(columns) if matched[v] < 0), to_variables)
    return Parts(
        tuple(e for e, inside in enumerate(over) if inside),
        tuple(v for v in range(columns) if matched[v] >= 0 and over[matched[v]]),
        tuple(
            e for e in range(len(rows)) if matching.variable[e] >= 0 and under[matching.variable[e]]
        ),
        tuple(v for v, inside in enumerate(under) if inside),
    )
