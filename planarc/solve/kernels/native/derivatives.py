"""Derivatives of a native kernel: memory in which compiled code passes them on.

See `planarc.ir.derivatives` for the tape, `codegen.native.passing` for what runs along it.
Columns of states are numbered so that positions and velocities of one joint stand side by
side: what only depends on the first joints of a chain then moves in few columns.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.ir.derivatives import CHUNK, Head, Passing, Scope, Tape
from planarc.ir.frame import address
from planarc.ir.program import Program
from planarc.solve.kernels.native.engine import Engine

if TYPE_CHECKING:
    from planarc.core.arrays import Vector as Matrix


class NativeDerivatives:
    """See `kernels.derived.Derivatives`."""

    def __init__(self, program: Program, engine: Engine, scope: Scope, frame: int) -> None:
        self._program = program
        self._ranges, self._pass, self._gather = engine.passing()
        text = engine.address(f"pc_tape_{scope.value}")
        length = ctypes.c_int64.from_address(text + 8 * Head.LENGTH).value
        self._tape = tape = Tape((ctypes.c_int64 * length).from_address(text)[:])
        self.memory = np.zeros(len(Passing), np.int64)
        self._arrays: dict[Passing, Any] = {}
        self._keep(Passing.VALUES, np.zeros(tape.entries))
        self._keep(Passing.COLUMNS, np.full(tape.nodes, -1, np.int64))
        self._keep(Passing.RANGES, np.zeros(2 * tape.nodes, np.int64))
        stride = _whole(tape.largest)
        self.memory[Passing.STRIDE] = stride
        self._keep(Passing.LOCAL, np.zeros(tape.nodes * stride))
        self.memory[Passing.FRAME], self.memory[Passing.TAPE] = frame, text
        self.memory[Passing.COEFFICIENTS] = engine.address(f"pc_slopes_{scope.value}")
        self._seeds: list[int] | None = None  # none yet

    def _keep(self, which: Passing, array: Any) -> None:
        self._arrays[which] = array
        self.memory[which] = address(array)

    def select(self, selection: Sequence[int]) -> None:
        """The choice of states."""
        candidates = self._program.candidates
        pairs = [self._tape.candidates[i] for i in selection]
        self._states, self._rates = [p[0] for p in pairs], [p[1] for p in pairs]
        heights = [self._program.blocks[candidates[i].block].height for i in selection]
        rank = [heights[:j].count(h) for j, h in enumerate(heights)]
        order = sorted(range(len(heights)), key=lambda j: (rank[j], -heights[j]))
        self._columns = np.argsort(order).astype(np.int64)
        self._seeds = None
        if Passing.RATES in self._arrays:
            self._place()

    def _place(self) -> None:
        """The states' nodes and columns, as `pc_cv_jacobian` takes them."""
        self._seed(())
        self._keep(Passing.RATES, np.array(self._rates, np.int64))
        self._keep(Passing.STATE_COLUMNS, self._columns)

    def _seed(self, more: Sequence[int]) -> None:
        """States move in their columns, the nodes `more` behind them (-1: none)."""
        seeds = [*self._states, *more]
        if seeds == self._seeds:
            return
        n, self._seeds = len(self._states), seeds
        columns = self._arrays[Passing.COLUMNS]
        columns[:] = -1
        columns[self._states] = self._columns
        for j, node in enumerate(more, n):
            if node >= 0:
                columns[node] = j
        tape, width = self._tape, _whole(len(seeds))
        self.memory[Passing.WIDTH] = width
        motions = np.zeros((tape.nodes, width))
        moved = np.flatnonzero(columns >= 0)
        motions[moved, columns[moved]] = 1.0
        self._keep(Passing.MOTIONS, motions)
        self._keep(Passing.SCRATCH, np.zeros(tape.largest * (tape.largest + width + 1)))
        self._ranges(address(self.memory))

    def of_values(self, t: float, leaves: Sequence[int], rows: Sequence[int]) -> Matrix | None:
        node_of, memory = self._tape.node_of, address(self.memory)
        leaf_nodes = [node_of.get(s, -1) for s in leaves]
        self._seed(leaf_nodes)
        if self._pass(memory, t):
            return None
        nodes = np.array([node_of.get(s, -1) for s in rows], np.int64)
        found = np.empty((len(nodes), int(self.memory[Passing.WIDTH])))
        if self._gather(memory, address(nodes), len(nodes), address(found)):
            return None
        n = len(self._states)
        found[:, :n] = found[:, self._columns]
        return found[:, : n + len(leaf_nodes)]

    def prepare(self) -> None:
        """Make ready for CVODE."""
        self._place()
        self._keep(Passing.MOVED, np.zeros(len(self._states)))


def _whole(columns: int) -> int:
    """The columns in whole chunks."""
    return -(-columns // CHUNK) * CHUNK
