"""Newton's method for one block of many runs at once.

The rule is that of `planarc.ir.newton`, but for halving: a run whose residuals do not
vanish gets nan for its unknowns, and the integrator tries a shorter step. Arrays have
the runs as their last axis.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from typing import TYPE_CHECKING, Any

from planarc.ir.newton import BENT, FAR, FITS, QUADRATIC, STEPS_BELOW, STEPS_TOP
from planarc.ir.program import BlockCode, Program

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]


class BatchBlock:
    """What the generated text calls; see `planarc.solve.kernels.numpy.block.Block`."""

    def __init__(
        self, code: BlockCode, program: Program, w: MutableSequence[Any], runs: int
    ) -> None:
        import numpy as np

        self.done = False
        self.matrix_wanted = False  # even where the unknowns are known without it
        self.matrix: Numbers | None = None
        self.slots = [program.slots[str(tear)] for tear in code.tears]
        self._w, self._runs = w, runs
        self._below = code.height > 0
        self._most = STEPS_BELOW if self._below else STEPS_TOP
        self._rows = len(code.residuals)
        candidates = {c.slot: c.derivative for c in program.candidates}
        self._first = [candidates.get(s, -1) for s in self.slots]
        self._second = [candidates.get(s, -1) for s in self._first]
        shape = (len(self.slots), runs)
        self._accepted, self._velocity = np.zeros(shape), np.zeros(shape)
        self._acceleration, self._time = np.zeros(shape), np.zeros(runs)
        self._solved = np.tile(np.arange(self._rows)[:, None], (1, runs))
        self._alike: list[int] | None = list(range(self._rows))

    def select(self, solved: NDArray[np.intp]) -> None:
        """`solved`: of each run the positions of the unknowns among the tears."""
        self._solved = solved
        alike = bool((solved == solved[:, :1]).all())
        self._alike = solved[:, 0].tolist() if alike else None

    def accept(self, t: Numbers, w: Sequence[Any], taken: NDArray[np.bool_]) -> None:
        """The values in `w` are the last accepted ones of the runs `taken`."""
        import numpy as np

        self._time = np.where(taken, t, self._time)
        for row, s in enumerate(self.slots):
            self._accepted[row] = np.where(taken, w[s], self._accepted[row])
        if self._below:
            for kept, slots in (
                (self._velocity, self._first),
                (self._acceleration, self._second),
            ):
                for row, s in enumerate(slots):
                    if s >= 0:
                        kept[row] = np.where(taken, w[s], kept[row])

    # Called from the text

    def start(self, t: Numbers) -> Numbers:
        import numpy as np

        self.done = False
        self._count = 0
        if not self._below:
            self._x: Numbers = self._accepted.copy()
        else:
            h = t - self._time
            bend = 0.5 * h * h * self._acceleration
            bend[np.abs(bend) > BENT * np.maximum(1.0, np.abs(self._accepted))] = 0.0
            guess = self._accepted + h * self._velocity + bend
            self._x = self._states()
            self._put(self._x, self._get(guess))
            self._origin = self._get(self._x)
        return self._x

    def step(self, residuals: Sequence[Any], matrix: Sequence[Sequence[Any]]) -> Numbers:
        import numpy as np

        r, g = self._filled(residuals, matrix)
        if not self._count:
            self._open = np.ones(self._runs, dtype=bool)
        change = solve(self._columns(g), r)
        x = self._get(self._x)
        moved = x - np.where(self._open, change, 0.0)
        size = np.max(np.abs(change) / np.maximum(1.0, np.abs(moved)), axis=0)
        self._put(self._x, moved)
        self._count += 1
        # nan is not open: it stays nan.
        self._open &= size >= QUADRATIC
        if not self._open.any() or self._count >= self._most:
            self._finish(moved)
        return self._x

    def _finish(self, moved: Numbers) -> None:
        """Runs that did not converge, or went too far, have no solution here."""
        import numpy as np

        self.done = True
        bad = self._open
        if self._below:
            far = np.abs(moved - self._origin) > FAR * np.maximum(1.0, np.abs(self._origin))
            bad = bad | far.any(axis=0)
        if bad.any():
            self._put(self._x, np.where(bad, np.nan, moved))

    def take(self, tears: Sequence[Any]) -> Sequence[Any]:
        self.done = False
        return tears

    def fits(self, residuals: Sequence[Any], sizes: Sequence[Any]) -> bool:
        import numpy as np

        if self.matrix_wanted:
            return False
        pairs = zip(residuals, sizes, strict=True)
        return all(bool(np.all(np.abs(r) <= FITS * s)) for r, s in pairs)

    def solve(self, residuals: Sequence[Any], matrix: Sequence[Sequence[Any]]) -> Numbers:
        import numpy as np

        self.done = True
        r, g = self._filled(residuals, matrix)
        if not self._below:
            return -solve(g, r)
        x = self._states()
        self._put(x, np.zeros((self._rows, self._runs)))
        r = r + np.einsum("ijk,jk->ik", g, x)
        self._put(x, -solve(self._columns(g), r))
        return x

    # Unknowns among the tears

    def _states(self) -> Numbers:
        import numpy as np

        x = np.empty((len(self.slots), self._runs))
        for row, s in enumerate(self.slots):
            x[row] = self._w[s]
        return x

    def _get(self, x: Numbers) -> Numbers:
        import numpy as np

        if not self._below:
            return x
        if self._alike is not None:
            return x[self._alike]
        return np.take_along_axis(x, self._solved, axis=0)

    def _put(self, x: Numbers, values: Numbers) -> None:
        import numpy as np

        if not self._below:
            x[:] = values
        elif self._alike is not None:
            x[self._alike] = values
        else:
            np.put_along_axis(x, self._solved, values, axis=0)

    def _columns(self, g: Numbers) -> Numbers:
        import numpy as np

        if not self._below:
            return g
        if self._alike is not None:
            return g[:, self._alike]
        return np.take_along_axis(g, self._solved[None], axis=1)

    def _filled(
        self, residuals: Sequence[Any], matrix: Sequence[Sequence[Any]]
    ) -> tuple[Numbers, Numbers]:
        import numpy as np

        r = np.empty((self._rows, self._runs))
        g = np.empty((self._rows, len(self.slots), self._runs))
        for i, (value, row) in enumerate(zip(residuals, matrix, strict=True)):
            r[i] = value
            for j, entry in enumerate(row):
                g[i, j] = entry
        self.matrix = g
        return r, g


def solve(matrix: Numbers, right: Numbers) -> Numbers:
    """x with matrix*x = right of each run (shapes n x n x runs, n x runs); nan where singular."""
    import numpy as np

    n = len(right)
    if n == 1:
        x: Numbers = right / matrix[0]
        x[~np.isfinite(x)] = np.nan
        return x
    if n == 2:
        (a11, a12), (a21, a22) = matrix
        determinant = a11 * a22 - a12 * a21
        determinant[determinant == 0.0] = np.nan
        pair: Numbers = np.stack((a22 * right[0] - a12 * right[1], a11 * right[1] - a21 * right[0]))
        pair /= determinant
        return pair
    a, b = np.moveaxis(matrix, 2, 0), right.T[:, :, None]
    good = np.isfinite(a).all(axis=(1, 2)) & np.isfinite(b).all(axis=(1, 2))
    x = np.full((len(a), n, 1), np.nan)
    try:
        x[good] = np.linalg.solve(a[good], b[good])
    except np.linalg.LinAlgError:  # one of them is singular
        for i in np.flatnonzero(good):
            try:
                x[i] = np.linalg.solve(a[i], b[i])
            except np.linalg.LinAlgError:
                x[i] = np.nan
    return x[:, :, 0].T
