"""Newton's method for one block, called from the generated NumPy text.

The rule is `planarc.ir.newton`; the native back end follows the same.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence

from planarc.ir.newton import (
    FAR,
    HALVINGS,
    QUADRATIC,
    STEPS_BELOW,
    STEPS_TOP,
)
from planarc.ir.program import BlockCode, Program
from planarc.solve.kernels.numpy_support import Rows, solve_linear


class UnsolvedError(Exception):
    """A block has no solution here; carries its index."""

    def __init__(self, block: int) -> None:
        super().__init__(block)
        self.block = block


class Block:
    """The tears of a block while it is solved, and its last accepted point."""

    def __init__(
        self, index: int, code: BlockCode, program: Program, w: MutableSequence[float]
    ) -> None:
        self.index = index
        self.done = False
        self.evaluating = False  # candidates are given: only residuals are wanted
        self.residuals: Sequence[float] = ()
        self.matrix: Rows = ()
        self._w = w
        self._below = code.height > 0
        self._linear = code.linear
        self.slots = [program.slots[str(tear)] for tear in code.tears]
        self._size = len(code.residuals)
        self._solved = list(range(self._size))  # positions of the unknowns among the tears
        self._accepted = [0.0] * len(self.slots)
        self._velocity = [0.0] * len(self.slots)
        self._acceleration = [0.0] * len(self.slots)
        self._time = 0.0
        first = code.first
        slots = program.candidates[first : first + len(self.slots)] if self._below else ()
        derivatives = {c.slot: c.derivative for c in program.candidates}
        self._first = [c.derivative for c in slots]
        self._second = [derivatives.get(c.derivative, -1) for c in slots]

    def select(self, states: set[int]) -> None:
        """`states`: positions of the states among the tears."""
        self._solved = [i for i in range(len(self.slots)) if i not in states]

    def accept(self, t: float) -> None:
        w = self._w
        self._time = t
        self._accepted = [w[s] for s in self.slots]
        if self._below:
            self._velocity = [w[s] for s in self._first]
            self._acceleration = [w[s] if s >= 0 else 0.0 for s in self._second]

    def begin(self, values: Sequence[float]) -> None:
        """Start from given values, at rest."""
        self._accepted = list(values)
        self._velocity = [0.0] * len(self.slots)
        self._acceleration = [0.0] * len(self.slots)

    def start(self, t: float) -> Sequence[float]:
        self.done = False
        self._count = 0
        if not self._below:
            self._x = list(self._accepted)
            return self._x
        w = self._w
        self._x = x = [w[s] for s in self.slots]
        if not self.evaluating:
            h = t - self._time
            half = 0.5 * h * h
            for i in self._solved:
                x[i] = self._accepted[i] + h * self._velocity[i] + half * self._acceleration[i]
            self._origin = list(x)
        return x

    def step(self, residuals: Sequence[float], matrix: Rows) -> Sequence[float]:
        self.residuals = residuals
        self.matrix = matrix
        if self._below:
            if self.evaluating:
                self.done = True
                return self._x
            solved = self._solved
            matrix = [[row[j] for j in solved] for row in matrix]
        else:
            solved = range(self._size)  # type: ignore[assignment]
        if not self._linear and self._count and self._worse(residuals):
            return self._halve(solved)
        change = solve_linear(matrix, residuals)
        if change is None:
            raise UnsolvedError(self.index)
        return self._move(solved, change)

    def step_columns(self, residuals: Sequence[float], columns: Rows) -> Sequence[float]:
        """As `step`, with the matrix given by columns."""
        return self.step(residuals, list(zip(*columns, strict=True)))

    def _move(self, solved: Sequence[int], change: Sequence[float]) -> Sequence[float]:
        x = self._x
        if self._linear:
            for i, d in zip(solved, change, strict=True):
                x[i] -= d
            self.done = True
            return x
        self._before = list(x)
        self._change = list(change)
        self._factor = 1.0
        self._count += 1
        size = 0.0
        for i, d in zip(solved, change, strict=True):
            x[i] -= d
            size = max(size, abs(d) / max(1.0, abs(x[i])))
        if not size < 1e300:  # nan or far out
            raise UnsolvedError(self.index)
        self._sizes = _row_sizes(self.matrix)
        self._norm = _norm(self.residuals, self._sizes)
        if size < QUADRATIC:
            self._finish(solved)
        elif self._count >= (STEPS_BELOW if self._below else STEPS_TOP):
            raise UnsolvedError(self.index)
        return x

    def _finish(self, solved: Sequence[int]) -> None:
        self.done = True
        if self._below:
            for i in solved:
                moved = abs(self._x[i] - self._origin[i])
                if moved > FAR * max(1.0, abs(self._origin[i])):
                    raise UnsolvedError(self.index)

    def _worse(self, residuals: Sequence[float]) -> bool:
        """Whether the last step made the residuals larger, measured as before it."""
        return not _norm(residuals, self._sizes) <= self._norm

    def _halve(self, solved: Sequence[int]) -> Sequence[float]:
        self._factor *= 0.5
        if self._factor < 0.5**HALVINGS:
            raise UnsolvedError(self.index)
        for i, d in zip(solved, self._change, strict=True):
            self._x[i] = self._before[i] - self._factor * d
        return self._x


def _row_sizes(matrix: Rows) -> list[float]:
    return [max(map(abs, row)) or 1.0 for row in matrix]


def _norm(residuals: Sequence[float], sizes: Sequence[float]) -> float:
    return max(abs(r) / s for r, s in zip(residuals, sizes, strict=True))
