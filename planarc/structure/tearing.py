"""Tearing: guess few unknowns, so that the others follow one after the other.

In:   rows    unknowns of each equation, each with whether the equation can be solved
              for it without a branch and without dividing by what may vanish
      rank    of each unknown: lower ones are guessed first
Out:  Torn    tears, assignments in their order, residual equations

Whenever an equation has one unknown left and can be solved for it, it is used for
that. When none has, an unknown is torn: among those of the lowest rank the one that
leaves most equations with a single, solvable unknown; then the first. Equations
that are left without unknown are the residuals.

Example: x + y = 1, x - y = 0, z = x, all solvable.

    tear x (three equations wait for it), y := 1 - x, z := x, residual x - y

Needs:     nothing; rows may be fewer than unknowns (then some tears are free).
Promises:  tears - residuals = unknowns - equations; every unknown is a tear or
           assigned once; time near-linear in the number of incidences.
Reference: the greedy rule of F. E. Cellier and E. Kofman, Continuous System
           Simulation, 2006, section 7.4 (tearing), with ranks put before it; see
           P. Taeuber et al., Proc. EOOLT 2014, for a comparison of such rules.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from typing import TypeAlias

from planarc.core.data import Data
from planarc.structure.graph import columns_of

#: The unknowns of each equation, each with whether it can be solved for it.
Rows: TypeAlias = Sequence[Sequence[tuple[int, bool]]]


class Torn(Data):
    tears: tuple[int, ...]  # in the order of their choice
    assignments: tuple[tuple[int, int], ...]  # (unknown, equation), in order of evaluation
    residuals: tuple[int, ...]  # equations, ascending


def tear_system(rows: Rows, rank: Sequence[int]) -> Torn:
    """`rank` has one entry for each unknown."""
    return _Search(rows, rank).run()


class Propagation:
    """What follows from unknowns that are known, one equation after the other."""

    def __init__(self, rows: Rows, columns: Sequence[Sequence[int]]) -> None:
        self.rows, self.columns = rows, columns
        self.known = [False] * len(columns)
        self.left = [len(row) for row in rows]  # unknowns of each equation not yet known
        self.ready = deque(e for e, count in enumerate(self.left) if count == 1)
        self.tears: list[int] = []
        self.assignments: list[tuple[int, int]] = []  # (unknown, equation)

    def tear(self, v: int) -> None:
        self.tears.append(v)
        self.determine(v)
        self.propagate()

    def propagate(self) -> None:
        while self.ready:
            e = self.ready.popleft()
            if self.left[e] == 1:
                v, solvable = next(item for item in self.rows[e] if not self.known[item[0]])
                if solvable:
                    self.assignments.append((v, e))
                    self.determine(v)

    def determine(self, v: int) -> None:
        self.known[v] = True
        for e in self.columns[v]:
            self.left[e] -= 1
            if self.left[e] == 1:
                self.ready.append(e)

    def torn(self) -> Torn:
        used = {e for _, e in self.assignments}
        residuals = tuple(e for e in range(len(self.rows)) if e not in used)
        return Torn(tuple(self.tears), tuple(self.assignments), residuals)


class _Search(Propagation):
    """Propagation that chooses the tears by rank and score."""

    def __init__(self, rows: Rows, rank: Sequence[int]) -> None:
        super().__init__(rows, columns_of([[v for v, _ in row] for row in rows], len(rank)))
        self.rank = rank
        self.score = [0] * len(rank)  # equations that would become solvable
        self.heap: list[tuple[int, int, int]] = []

    def run(self) -> Torn:
        for e, count in enumerate(self.left):
            if count == 2:
                self._count_pair(e)
        self.heap = [(self.rank[v], -self.score[v], v) for v in range(len(self.rank))]
        heapify(self.heap)
        self.propagate()
        while (v := self._choose()) is not None:
            self.tear(v)
        return self.torn()

    def _choose(self) -> int | None:
        while self.heap:
            rank, score, v = heappop(self.heap)
            if self.known[v]:
                continue
            if -score != self.score[v]:  # grown: entered again; shrunk: enter it now
                if -score > self.score[v]:
                    heappush(self.heap, (rank, -self.score[v], v))
                continue
            return v
        return None

    def determine(self, v: int) -> None:
        self.known[v] = True
        for e in self.columns[v]:
            self.left[e] -= 1
            if self.left[e] == 1:
                self.ready.append(e)
                if len(self.rows[e]) > 1:
                    self._uncount(e, v)
            elif self.left[e] == 2:
                self._count_pair(e)

    def _unknown(self, e: int) -> list[tuple[int, bool]]:
        return [item for item in self.rows[e] if not self.known[item[0]]]

    def _count_pair(self, e: int) -> None:
        (a, solves_a), (b, solves_b) = self._unknown(e)
        for v, solvable in ((a, solves_b), (b, solves_a)):
            if solvable:
                self.score[v] += 1
                heappush(self.heap, (self.rank[v], -self.score[v], v))

    def _uncount(self, e: int, v: int) -> None:
        """Note that v of the pair that `e` had has become known."""
        if next(solvable for u, solvable in self.rows[e] if u == v):
            other = self._unknown(e)[0][0]
            self.score[other] -= 1
