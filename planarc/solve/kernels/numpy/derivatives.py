"""Derivatives from the coefficients of NumPy text: one sparse linear system.

In:   coefficients at a point, and the tape that tells where they stand
Out:  motions of values when states, parameters or unknowns of blocks move by one

The motions of all nodes are the unknowns (`planarc.ir.derivatives`): a row ties its target
to its sources, residuals of blocks do not move, and what is told to move, moves. Small
systems are solved as full matrices, others by SuperLU: from some size on, full ones would
wake the threads of BLAS, which costs more than the work.
"""

from __future__ import annotations

from collections.abc import Mapping, MutableSequence, Sequence
from typing import TYPE_CHECKING, Any

from planarc.ir.derivatives import Tape

if TYPE_CHECKING:
    from planarc.core.arrays import Vector as Matrix


#: Nodes up to which a full matrix is quicker.
LARGEST_FULL = 40


class NumpyDerivatives:
    """See `kernels.derived.Derivatives`; `functions` are those of the text."""

    def __init__(self, functions: Mapping[str, Any], w: MutableSequence[float]) -> None:
        self._w = w
        self._coefficients = functions["slopes"]
        self._tape = Tape(functions["tape"])
        self._states: list[int] = []
        self._seeds: list[int] | None = None
        self._system: System | None = None

    def select(self, selection: Sequence[int]) -> None:
        self._states = [self._tape.candidates[i][0] for i in selection]

    def of_values(self, t: float, leaves: Sequence[int], rows: Sequence[int]) -> Matrix | None:
        import numpy as np

        node_of = self._tape.node_of
        seeds = [*self._states, *(node_of.get(s, -1) for s in leaves)]
        if seeds != self._seeds:
            self._seeds, self._system = seeds, System(self._tape, seeds)
        assert self._system is not None
        try:
            motions = self._system.solve(self._coefficients(t, self._w, ()))
        except (ArithmeticError, ValueError):
            return None
        if motions is None:
            return None
        nodes = np.array([node_of.get(s, -1) for s in rows], np.intp)
        found: Matrix = np.where(nodes[:, None] >= 0, motions[nodes], 0.0)  # -1 does not move
        return found if np.isfinite(found).all() else None


class System:
    """The linear system in which node `seeds[j]` moves by one in column j (-1: none does)."""

    def __init__(self, tape: Tape, seeds: Sequence[int]) -> None:
        import numpy as np

        moved = {node: j for j, node in enumerate(seeds) if node >= 0}
        starts, size = tape.starts, tape.nodes
        rows = [i for i in range(tape.rows) for _ in range(starts[i + 1] - starts[i])]
        columns = list(tape.sources)
        self._fixed = [-1.0] * tape.rows
        rows += range(tape.rows)
        columns += tape.targets
        still = set(range(size)) - set(tape.targets)
        count = tape.rows
        for _, tears, residuals in tape.blocks():
            free = [node for node in tears if node not in moved]
            still.difference_update(free)
            held = residuals if free else ()
            rows += range(count, count + len(held))
            columns += held
            count += len(held)
        own = {node: count + i for i, node in enumerate(sorted(still))}
        rows += own.values()
        columns += own
        self._fixed += [1.0] * (len(rows) - len(tape.sources) - tape.rows)
        self._size = size
        self._square = count + len(own) == size
        self._rows, self._columns = np.array(rows, np.intp), np.array(columns, np.intp)
        self._order = np.lexsort((self._rows, self._columns))
        ends = np.searchsorted(self._columns[self._order], np.arange(size + 1))
        self._pattern = self._rows[self._order].astype(np.int32), ends.astype(np.int32)
        self._right = np.zeros((size, len(seeds)))
        for node, j in moved.items():
            self._right[own[node], j] = 1.0

    def solve(self, values: Sequence[float]) -> Matrix | None:
        """The motions of all nodes; None where the system is singular or not finite."""
        import numpy as np

        filled = np.concatenate([np.array(values, float), self._fixed])
        if not self._square or not np.isfinite(filled).all():
            return None
        if self._size <= LARGEST_FULL:
            matrix = np.zeros((self._size, self._size))
            matrix[self._rows, self._columns] = filled
            try:
                full: Any = np.linalg.solve(matrix, self._right)
            except np.linalg.LinAlgError:
                return None
            return np.asarray(full, float)
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        shape = (self._size, self._size)
        sparse = csc_matrix((filled[self._order], *self._pattern), shape=shape)
        try:
            # Columns share little here: looking for such that do costs more than it gives.
            solved: Matrix = splu(sparse, panel_size=1, relax=1).solve(self._right)
        except RuntimeError:  # exactly singular
            return None
        return solved
