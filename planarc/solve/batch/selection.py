"""The choice of states of many runs at once, each run's own.

The rule is that of `planarc.solve.states.selector`: a state gives way to a candidate that moves
more than WORST times as fast. Where a state that must stay one would have to give way,
the run is told to be `lost`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.ir.program import Program
from planarc.solve.batch.block import solve
from planarc.solve.batch.kernel import BatchKernel
from planarc.solve.solvers.watch import WORST
from planarc.solve.states.selector import (
    LOST,
    MUST_STAY,
    PREFERENCE,
    classes_of,
    leaders_of,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Indices = NDArray[np.intp]


class BatchSelector:
    """`selections`: of each run the candidates that its start has chosen."""

    def __init__(
        self, program: Program, kernel: BatchKernel, selections: Sequence[Sequence[int]]
    ) -> None:
        import numpy as np

        self._program, self._kernel = program, kernel
        self._leader = leaders_of(program)
        self._class = classes_of(program, ())
        self.selection: Indices = np.array(selections, dtype=np.intp).T.reshape(
            program.state_count, kernel.runs
        )
        self.lost = np.zeros(kernel.runs, dtype=bool)
        self._scale: dict[int, NDArray[np.float64]] = {}
        self._out: dict[int, Indices] = {}
        row = 0
        for i, block in enumerate(program.blocks):
            if not block.height:
                continue
            states = self.selection[row : row + block.free] - block.first
            free = np.zeros((len(block.tears), kernel.runs), dtype=bool)
            np.put_along_axis(free, states, True, axis=0)
            count = len(block.residuals)
            self._out[i] = np.argsort(free, axis=0, kind="stable")[:count]
            row += block.free
        self.open = [
            i
            for i, b in enumerate(program.blocks)
            if b.height > 0 and b.residuals and b.free > 0 and i not in self._leader
        ]
        for i in self.open:
            kernel.blocks[i].matrix_wanted = True

    def check(self, taken: NDArray[np.bool_]) -> bool:
        """Whether states of the runs `taken` were exchanged, after a step."""
        import numpy as np

        changed = np.zeros(self._kernel.runs, dtype=bool)
        for i in self.open:
            changed |= self._exchange(i, taken)
        if changed.any():
            self.selection = self._assembled()
        return bool(changed.any())

    def _assembled(self) -> Indices:
        import numpy as np

        rows = []
        for i, block in enumerate(self._program.blocks):
            if block.height:
                out = np.zeros((len(block.tears), self._kernel.runs), dtype=bool)
                np.put_along_axis(out, self._out_of(i), True, axis=0)
                rows.append(block.first + np.argsort(out, axis=0, kind="stable")[: block.free])
        return np.concatenate(rows)

    def _out_of(self, i: int) -> Indices:
        import numpy as np

        if i not in self._leader:
            return self._out[i]
        leader, places = self._leader[i]
        table = np.array([places[j] for j in range(len(places))], dtype=np.intp)
        return table[self._out_of(leader)]

    def _exchange(self, i: int, taken: NDArray[np.bool_]) -> NDArray[np.bool_]:
        import numpy as np

        g = self._kernel.blocks[i].matrix
        assert g is not None
        sizes = np.sqrt((g * g).sum(axis=0))
        scale = np.maximum(sizes, self._scale[i]) if i in self._scale else sizes
        self._scale[i] = np.where(taken, scale, self._scale.get(i, sizes))
        g = g / np.where(scale > 0, scale, 1.0)
        block = self._program.blocks[i]
        n, m = len(block.tears), len(block.residuals)
        kinds = np.array(self._class[block.first : block.first + n])
        out, changed = self._out[i], np.zeros(self._kernel.runs, dtype=bool)
        for _ in range(n):
            solved = np.zeros((n, self._kernel.runs), dtype=bool)
            np.put_along_axis(solved, out, True, axis=0)
            free = np.argsort(solved, axis=0, kind="stable")[: n - m]
            a = np.take_along_axis(g, out[None], axis=1)
            x = np.empty((m, n - m, self._kernel.runs))
            for k in range(n - m):
                right = np.take_along_axis(g, free[None, k : k + 1], axis=1)[:, 0]
                x[:, k] = np.abs(solve(a, right))
            lower = kinds[out][:, None] // 4 < kinds[free][None] // 4
            weighed = np.where(lower, x / PREFERENCE, x)
            must = np.broadcast_to(kinds[free][None] == MUST_STAY, x.shape)
            self.lost |= taken & np.where(must, x > LOST, False).any(axis=(0, 1))
            weighed = np.where(must, 0.0, weighed).reshape(m * (n - m), -1)
            singular = ~np.isfinite(weighed).all(axis=0)
            self.lost |= taken & singular
            most = weighed.argmax(axis=0)
            worst = np.take_along_axis(weighed, most[None], axis=0)[0]
            moving = np.flatnonzero(taken & ~singular & (worst > WORST))
            if not len(moving):
                break
            row, column = most[moving] // (n - m), most[moving] % (n - m)
            out = out.copy()
            out[row, moving] = free[column, moving]
            changed[moving] = True
        self._out[i] = np.sort(out, axis=0)
        return changed
