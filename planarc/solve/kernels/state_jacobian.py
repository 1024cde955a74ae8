"""The Jacobian of the right-hand side, from the system that `codegen.slopes` describes.

In:   coefficients at a point, and where they stand
Out:  d(derivative of state i)/d(state j)

The motions of all values are the unknowns; their equations are known but for those of
the states, which depend on the choice of states and are put in here: state j moves by
one, and all others stand. Small systems are solved as full matrices, others by SuperLU:
from some size on, full ones would wake the threads of BLAS, which costs more than the work.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]

#: Up to so many unknowns a full matrix is quicker.
LARGEST_FULL = 40


class StateJacobian:
    """For one choice of states at a time."""

    def __init__(
        self,
        nodes: int,
        rows: Sequence[int],
        columns: Sequence[int],
        candidates: Sequence[tuple[int, int]],
    ) -> None:
        import numpy as np

        self._size = nodes
        self._rows, self._columns = np.array(rows, np.intp), np.array(columns, np.intp)
        self._candidates = candidates
        self._states: Any = None
        self._equations = int(self._rows.max(initial=-1)) + 1

    def select(self, selection: Sequence[int]) -> None:
        import numpy as np

        nodes, rates = zip(*(self._candidates[i] for i in selection), strict=True)
        self._states, self._rates = np.array(nodes, np.intp), np.array(rates, np.intp)
        own = self._equations + np.arange(len(selection))
        self._all_rows = np.concatenate([self._rows, own])
        self._all_columns = np.concatenate([self._columns, self._states])
        self._order = np.lexsort((self._all_rows, self._all_columns))
        ends = np.searchsorted(self._all_columns[self._order], np.arange(self._size + 1))
        self._pattern = self._all_rows[self._order].astype(np.int32), ends.astype(np.int32)
        self._right = np.zeros((self._size, len(selection)))
        self._right[own, np.arange(len(selection))] = 1.0

    def solve(self, values: Sequence[float]) -> Matrix | None:
        """None where the system is singular or not finite."""
        import numpy as np

        filled = np.concatenate([np.array(values, float), np.ones(len(self._states))])
        if not np.isfinite(filled).all():
            return None
        motion = self._solved(filled)
        if motion is None:
            return None
        rates = np.where(self._rates[:, None] >= 0, motion[self._rates], 0.0)
        return rates if np.isfinite(rates).all() else None

    def _solved(self, filled: Matrix) -> Matrix | None:
        import numpy as np

        if self._size <= LARGEST_FULL:
            matrix = np.zeros((self._size, self._size))
            matrix[self._all_rows, self._all_columns] = filled
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
            solved: Matrix = splu(sparse).solve(self._right)
        except RuntimeError:  # exactly singular
            return None
        return solved
