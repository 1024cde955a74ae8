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

from planarc.core.data import Data


class Torn(Data):
    tears: tuple[int, ...]  # in the order of their choice
    assignments: tuple[tuple[int, int], ...]  # (unknown, equation), in order of evaluation
    residuals: tuple[int, ...]  # equations, ascending


def tear_system(rows: Sequence[Sequence[tuple[int, bool]]], rank: Sequence[int]) -> Torn:
    """`rank` has one entry for each unknown."""
    return _Search(rows, rank).run()


class _Search:
    def __init__(self, rows: Sequence[Sequence[tuple[int, bool]]], rank: Sequence[int]) -> None:
        self.rows = rows
        self.rank = rank
        self.known = [False] * len(rank)
        self.left = [len(row) for row in rows]  # unknowns of each equation not yet known
        self.used = [False] * len(rows)
        self.score = [0] * len(rank)  # equations that would become solvable
        self.columns: list[list[int]] = [[] for _ in rank]
        for e, row in enumerate(rows):
            for v, _ in row:
                self.columns[v].append(e)
        self.ready: deque[int] = deque()
        self.heap: list[tuple[int, int, int]] = []
        self.assignments: list[tuple[int, int]] = []

    def run(self) -> Torn:
        for e, count in enumerate(self.left):
            if count == 1:
                self.ready.append(e)
            elif count == 2:
                self._count_pair(e)
        self.heap = [(self.rank[v], -self.score[v], v) for v in range(len(self.rank))]
        heapify(self.heap)
        tears = []
        self._propagate()
        while (v := self._choose()) is not None:
            tears.append(v)
            self._determine(v)
            self._propagate()
        residuals = tuple(e for e, used in enumerate(self.used) if not used)
        return Torn(tuple(tears), tuple(self.assignments), residuals)

    def _propagate(self) -> None:
        while self.ready:
            e = self.ready.popleft()
            if self.left[e] != 1:
                continue
            v, solvable = self._unknown(e)[0]
            if solvable:
                self.used[e] = True
                self.assignments.append((v, e))
                self._determine(v)

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

    def _determine(self, v: int) -> None:
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
