"""Newton's method for one block, called from the generated NumPy text.

The rule is `planarc.ir.newton`; the native back end follows the same.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from operator import mul

from planarc.ir.kernel import taker
from planarc.ir.newton import (
    BENT,
    FAR,
    FITS,
    HALVINGS,
    NEARLY,
    NOTHING,
    QUADRATIC,
    STEPS_BELOW,
    STEPS_TOP,
)
from planarc.ir.program import BlockCode, Program
from planarc.solve.kernels.numpy.sparse import dense
from planarc.solve.kernels.numpy.support import Rows, solve_linear
from planarc.solve.kernels.singular import solve_open


class UnsolvedError(Exception):
    """A block has no solution here; carries its index."""

    def __init__(self, block: int) -> None:
        super().__init__(block)
        self.block = block


class NotFiniteError(ArithmeticError):
    """A residual of a block, or its slopes, are not finite; carries the equation."""

    def __init__(self, equation: int) -> None:
        super().__init__(equation)
        self.equation = equation


class Block:
    """The tears of a block while it is solved, and its last accepted point."""

    def __init__(
        self, index: int, code: BlockCode, program: Program, w: MutableSequence[float]
    ) -> None:
        self.index = index
        self.done = False
        self._count = 0  # of the steps
        self.evaluating = False  # candidates are given: only residuals are wanted
        self.matrix_asked = False  # even where it is not needed
        self.open = False  # the equations left unknowns open when it was solved last
        self.near = False  # a loop came near to a pose in which it can go on in several ways
        self.lapack = True  # to solve three unknowns and more
        self.lenient = False  # where it cannot be solved its unknowns are zero
        self.content = False  # values that leave nothing are enough where slopes are singular
        self.residuals: Sequence[float] = ()
        self.matrix: Rows = ()
        self._w = w
        self._modal = code.modal
        self._rows = code.direct.rows if code.direct is not None else ()
        self._equations = code.equations
        self._below = code.height > 0
        self.slots = [program.slots[str(tear)] for tear in code.tears]
        self._most = STEPS_BELOW if self._below else STEPS_TOP
        self._solved = list(range(len(code.residuals)))  # positions of the unknowns among the tears
        self._free: list[int] = []  # and of the states
        self._values = taker(self.slots)
        self._accepted: Sequence[float] = [0.0] * len(self.slots)
        self._velocity: Sequence[float] = [0.0] * len(self.slots)
        self._acceleration: Sequence[float] = [0.0] * len(self.slots)
        self._sizes: Sequence[float] = ()  # of the rows, before the last step
        self._size_of_residuals = 0.0
        self._time = 0.0
        first = code.first
        slots = program.candidates[first : first + len(self.slots)] if self._below else ()
        derivatives = {c.slot: c.derivative for c in program.candidates}
        self._velocities = taker([c.derivative for c in slots])
        self._second = [derivatives.get(c.derivative, -1) for c in slots]
        self._accelerates = bool(self._second) and max(self._second) >= 0

    def select(self, states: set[int]) -> None:
        """`states`: positions of the states among the tears."""
        self._solved = [i for i in range(len(self.slots)) if i not in states]
        self._free = sorted(states)

    @property
    def trying(self) -> bool:
        """Whether a step was taken of which nothing is known yet."""
        return not self.done and self._count > 0

    def accept(self, t: float) -> None:
        w = self._w
        self._time = t
        self._accepted = self._values(w)
        if self._below:
            self._velocity = self._velocities(w)
        if self._accelerates:
            self._acceleration = [w[s] if s >= 0 else 0.0 for s in self._second]

    def begin(self, values: Sequence[float]) -> None:
        """Start from given values, at rest."""
        self._accepted = list(values)
        self._velocity = [0.0] * len(self.slots)
        self._acceleration = [0.0] * len(self.slots)

    def origin(self) -> list[float]:
        """The accepted values."""
        return list(self._accepted)

    def start(self, t: float) -> Sequence[float]:
        self.done = False
        self._small = False  # the last step
        self._count = 0
        if not self._below and not self.evaluating:
            self._x = list(self._accepted)
            return self._x
        self._x = x = [*self._values(self._w)]
        if not self.evaluating:
            h = t - self._time
            half = 0.5 * h * h
            for i in self._solved:
                accepted, bend = self._accepted[i], half * self._acceleration[i]
                x[i] = accepted + h * self._velocity[i]
                if abs(bend) <= BENT or abs(bend) <= BENT * abs(accepted):
                    x[i] += bend
            self._origin = x.copy()
        return x

    def take(self, tears: Sequence[float]) -> Sequence[float]:
        """A linear block's tears from an elimination in a fixed order, to be checked."""
        self.done = False
        return self._values(self._w) if self.evaluating else tears

    def fits(self, residuals: Sequence[float], sizes: Sequence[float]) -> bool:
        """Whether the taken tears count; not when the matrix itself is asked for."""
        if self.evaluating:
            self.residuals = residuals
            return True
        if self.matrix_asked:
            return False
        return all(abs(r) <= FITS * s for r, s in zip(residuals, sizes, strict=True))

    def pivot(self, values: Sequence[float]) -> Sequence[float]:
        """The tears where those do not count, from the values in the block's equations."""
        return self.solve(*dense(self._rows, values))

    def solve(self, residuals: Sequence[float], matrix: Rows) -> Sequence[float]:
        """The tears of a linear block, from its residuals at zero and its matrix."""
        self.matrix = matrix
        self.done = True
        if not self._below and not self.evaluating:
            change = solve_linear(matrix, residuals, self.lapack)
            if change is None:
                if self._modal:
                    kept = [-a for a in self._accepted]
                    change = self._solve_open(matrix, residuals, kept)
                change = self._checked(change, residuals, matrix)
            return [-d for d in change]
        x = [*self._values(self._w)]
        solved = self._solved
        if not self.evaluating:
            for i in solved:
                x[i] = 0.0
        residuals = [r + sum(map(mul, row, x)) for r, row in zip(residuals, matrix, strict=True)]
        if self.evaluating:
            self.residuals = residuals
            return x
        part = [[row[j] for j in solved] for row in matrix]
        if sizes := [max(map(abs, row)) for row in part]:
            self.near = self.near or min(sizes) < NEARLY * max(sizes)
        change = self._checked(solve_linear(part, residuals, self.lapack), residuals, part)
        for i, d in zip(solved, change, strict=True):
            x[i] = -d
        return x

    def step(self, residuals: Sequence[float], matrix: Rows) -> Sequence[float]:
        """Better tears of a nonlinear block; `done` when they are the last ones."""
        self.residuals = residuals
        self.matrix = matrix
        solved = self._solved
        if self.evaluating:
            self.done = True
            return self._x
        if self._below:
            matrix = [[row[j] for j in solved] for row in matrix]
        if self._count and not _lessened(_norm(residuals, self._sizes), self._size_of_residuals):
            return self._halve()
        x = self._x
        found = solve_linear(matrix, residuals, self.lapack)
        if found is None and self._modal:
            found = self._solve_open(matrix, residuals, [0.0] * len(residuals))
        if found is None and (self._small or self._is_met(residuals)):
            self._finish()
            return x
        change = self._checked(found, residuals, matrix)
        self._before = x.copy()
        self._change = change
        self._factor = 1.0
        self._count += 1
        size = 0.0
        for i, d in zip(solved, change, strict=True):
            x[i] = moved = x[i] - d
            relative = abs(d) / abs(moved) if abs(moved) > 1.0 else abs(d)
            if not relative <= size:
                size = relative
        self._small = size < QUADRATIC
        if self._small and (self._count >= self._most or self._is_last()):
            self._finish()
            return x
        if not size < 1e300 or self._count >= self._most:  # nan, far out, too many
            self._checked(None, residuals, matrix)
        self._sizes = [max(map(abs, row)) for row in matrix]
        self._size_of_residuals = _norm(residuals, self._sizes)
        return x

    def sway(self, amount: float) -> None:
        """Move the accepted values of all tears."""
        self._accepted = [a + amount for a in self._accepted]

    def _solve_open(
        self, matrix: Rows, right: Sequence[float], kept: Sequence[float]
    ) -> Sequence[float] | None:
        found = solve_open(matrix, right, kept)
        self.open = found is not None
        return found

    def _checked(
        self, change: Sequence[float] | None, residuals: Sequence[float], matrix: Rows
    ) -> Sequence[float]:
        if change is not None:
            return change
        for equation, r, row in zip(self._equations, residuals, matrix, strict=True):
            if not math.isfinite(r + sum(row)):
                raise NotFiniteError(equation)
        if self.lenient:
            self.done = True
            return [0.0] * len(residuals)
        raise UnsolvedError(self.index)

    def _is_met(self, residuals: Sequence[float]) -> bool:
        return self.content and not self._below and not any(residuals)

    def _is_last(self) -> bool:
        """Whether a small step is so beside each unknown, or beside the terms of each equation."""
        x = self._x
        for i, d in zip(self._solved, self._change, strict=True):
            if abs(d) > QUADRATIC * abs(x[i]) and abs(d) > NOTHING:
                for row in self.matrix:
                    if abs(row[i] * d) > QUADRATIC * max(map(abs, map(mul, row, x))):
                        return False
        return True

    def _finish(self) -> None:
        """Converged; below the top only when not far from where it started."""
        self.done = True
        if self._below:
            x, begin = self._x, self._origin
            for i in self._solved:
                moved = abs(x[i] - begin[i])
                if moved > FAR and moved > FAR * abs(begin[i]):
                    raise UnsolvedError(self.index)

    def _halve(self) -> Sequence[float]:
        self._factor *= 0.5
        if self._factor < 0.5**HALVINGS:
            if not self._small:
                raise UnsolvedError(self.index)
            self._factor = 0.0  # nothing is left but rounding
        for i, d in zip(self._solved, self._change, strict=True):
            self._x[i] = self._before[i] - self._factor * d
        if self._factor == 0.0:
            self._finish()
        return self._x


def by_columns(columns: Rows) -> Rows:
    """A matrix that is given by its columns."""
    return list(zip(*columns, strict=True))


def _lessened(size: float, before: float) -> bool:
    return size < before or size == 0.0


def _norm(residuals: Sequence[float], sizes: Sequence[float]) -> float:
    """The largest residual, each relative to the size of its row."""
    pairs = zip(map(float, residuals), map(float, sizes), strict=True)  # NumPy's would warn
    return max(abs(r) / s if s else math.inf for r, s in pairs)
