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
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

#: Nodes up to which a full matrix is quicker.
LARGEST_FULL = 40


class NumpyDerivatives:
    """See `kernels.derived.Derivatives`; `functions` are those of the text."""

    def __init__(self, functions: Mapping[str, Any], w: MutableSequence[float]) -> None:
        self._w = w
        self._coefficients = functions["slopes"]
        self._tape = Tape(functions["tape"])
        self._states: list[int] = []
        self._rates: list[int] = []
        self._seeds: list[int] | None = None
        self._system: System | None = None

    def select(self, selection: Sequence[int]) -> None:
        pairs = [self._tape.candidates[i] for i in selection]
        self._states, self._rates = [p[0] for p in pairs], [p[1] for p in pairs]

    def by_states(self, t: float) -> Matrix | None:
        motions = self._motions(t, self._states)
        return None if motions is None else _finite(_taken(motions, self._rates))

    def of_values(self, t: float, leaves: Sequence[int], rows: Sequence[int]) -> Matrix | None:
        node_of = self._tape.node_of
        motions = self._motions(t, [*self._states, *(node_of.get(s, -1) for s in leaves)])
        taken = [node_of.get(s, -1) for s in rows]
        return None if motions is None else _finite(_taken(motions, taken))

    def _motions(self, t: float, seeds: list[int]) -> Matrix | None:
        if seeds != self._seeds:
            self._seeds, self._system = seeds, System(self._tape, seeds)
        assert self._system is not None
        try:
            values = self._coefficients(t, self._w, ())
        except (ArithmeticError, ValueError):
            return None
        return self._system.solve(values)


def _taken(motions: Matrix, nodes: Sequence[int]) -> Matrix:
    """Rows of nodes; those of -1 do not move."""
    import numpy as np

    at = np.array(nodes, np.intp)
    found: Matrix = np.where(at[:, None] >= 0, motions[at], 0.0)
    return found


def _finite(matrix: Matrix) -> Matrix | None:
    import numpy as np

    return matrix if np.isfinite(matrix).all() else None


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
