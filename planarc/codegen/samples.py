"""Numbers that a model's variables could have: to choose pivots by more than a pattern.

In:   parameters with their values, the levels below the top step by step
Out:  `Samples`: for each symbol known so far, its values at a few positions

The first position is that of the start values, the others are moved away from it by
more and more, always by the same pseudo-random amounts. There relations and discrete values are
others, too: what two surfaces are to each other decides which coefficients vanish. Loops are closed
by Newton's method with steps of least norm. A position at which something is not finite has nan
from there on; nothing here can fail.

Only decisions that change speed and not results may rest on these numbers: the model
will take other positions, and its parameters other values.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.codegen.jacobian import Local
from planarc.evaluate.rows import RowValues
from planarc.ir.dae import Kind
from planarc.ir.expr import Expr
from planarc.ir.sorted import Assignment, Block, SortedDae

if TYPE_CHECKING:
    from planarc.core.arrays import Vector as Values


#: Distance of each position from the start, in the unit of the coordinate.
SPREAD = (0.0, 0.1, 0.3, 0.7, 1.0, 1.5, 3.0)
#: The least and the largest value that a discrete variable may have elsewhere.
_MODES = {Kind.BOOLEAN: (0, 1), Kind.INTEGER: (-1, 2)}
_STEPS = 8  # of Newton's method: what they do not close, twice as many seldom do
_CLOSED = 1e-4  # a step that closes a loop well enough: positions are a tenth apart
_INDEPENDENT = 1e-6  # least size of what a condition adds to those before it, beside the largest


class Samples:
    def __init__(self, sorted: SortedDae) -> None:
        self._values: dict[Expr, Values] = {}
        self._everywhere: dict[float, Values] = {}  # numbers that are the same at all positions
        self._waiting: list[Assignment] = []
        self._formulas = self._anew()
        self._spread = np.array(SPREAD)
        self._seed = 5
        table = sorted.dae.table
        with np.errstate(all="ignore"):
            self.set(table.time, np.zeros(len(SPREAD)))
            for p in sorted.dae.parameters:
                self.set(table.symbol(p.name), self.value(p.value))
            self._starts = {c.symbol: self.value(c.start or table.zero) for c in sorted.candidates}
            for i in range(len(sorted.dae.relations)):
                self.set(table.event(i), self._changed(np.zeros(len(SPREAD)), (0, 1)))
            for d in sorted.dae.discretes:
                start = self.value(d.start or table.zero)
                self.set(table.symbol(d.name), self._changed(start, _MODES.get(d.kind)))

    def _changed(self, start: Values, others: tuple[int, int] | None) -> Values:
        """The start, and at each other position one of the numbers from the first to the last."""
        if others is None:
            return start
        least, most = others
        changed = np.floor(least + (most + 1 - least) * (self._random() + 1.0) / 2.0)
        changed[0] = start[0]
        return changed

    def _random(self) -> Values:
        """A number of -1 to 1 for each position, by a congruential generator (D. E. Knuth, The Art
        of Computer Programming 2, 1997, 3.3.4): NumPy's take long to be imported."""
        found = []
        for _ in SPREAD:
            self._seed = (6364136223846793005 * self._seed + 1442695040888963407) % 2**64
            found.append(self._seed / 2**63 - 1.0)
        return np.array(found)

    def _anew(self) -> RowValues:
        """Values of formulas, none of them known yet."""
        values = self._values  # and not the samples: no cycle
        return RowValues(lambda e: values.get(e, 0.0), lambda e, args: math.nan, patient=False)

    def set(self, symbol: Expr, values: Values) -> None:
        self._values[symbol] = values
        if symbol in self._formulas:
            self._formulas = self._anew()

    def value(self, root: Expr) -> Values:
        """The formula at all positions; unknown leaves (left limits) are 0."""
        found = self._formulas(root)
        if getattr(found, "ndim", 0):
            return np.asarray(found, float)
        number = float(found)
        if number not in self._everywhere:
            self._everywhere[number] = np.full(self._spread.shape, number)
        return self._everywhere[number]

    def values(self, roots: Sequence[Expr]) -> Values:
        """Formulas at all positions, a row each."""
        self._take()
        found = np.empty((len(roots), len(SPREAD)))
        with np.errstate(all="ignore"):
            for row, root in zip(found, roots, strict=True):
                row[:] = self._formulas(root)
        return found

    def _number(self, root: Expr) -> Values:
        """The formula at all positions, without dimensions where it is the same everywhere."""
        return np.asarray(self._formulas(root), float)

    def assign(self, assignments: Iterable[Assignment]) -> None:
        """Note what targets hold from here on: what nothing asks for is not computed."""
        self._waiting += assignments

    def _take(self) -> None:
        with np.errstate(all="ignore"):
            for a in self._waiting:
                self.set(a.target, self.value(a.value))
        self._waiting.clear()

    def solve(self, block: Block, formulas: Sequence[Local]) -> None:
        """Give the block's unknowns values: candidates near their start, others anything."""
        self._take()
        n = len(block.tears)
        x = np.empty((len(SPREAD), n))
        for j, tear in enumerate(block.tears):
            moved = self._spread * self._random()
            x[:, j] = self._starts.get(tear, np.ones(len(SPREAD))) + moved
        with np.errstate(all="ignore"):
            below = any(tear in self._starts for tear in block.tears)
            steps = 1 if block.linear else _STEPS
            for _ in range(steps if below and block.residuals else 0):
                self._put(block, x)
                step = _least(*self._linearised(block, formulas))
                x -= np.clip(step, -0.5, 0.5)
                if not np.abs(step[np.isfinite(step)]).max(initial=0.0) > _CLOSED:
                    break
            self._put(block, x)

    def _put(self, block: Block, x: Values) -> None:
        for j, tear in enumerate(block.tears):
            self.set(tear, x[:, j].copy())
        for a in block.inner:
            self.set(a.target, self.value(a.value))

    def _linearised(self, block: Block, formulas: Sequence[Local]) -> tuple[Values, Values]:
        """Residuals and Jacobian at all positions."""
        n = len(block.tears)
        unit = np.broadcast_to(np.eye(n), (len(SPREAD), n, n))
        tangents: dict[Expr, Any] = {s: unit[:, j] for j, s in enumerate(block.tears)}
        rows: list[Any] = []
        for f in formulas:
            total: Any = np.zeros((len(SPREAD), n))
            for s, slope in f.slopes:
                if s in tangents:
                    total = total + self._number(slope)[..., None] * tangents[s]
            if f.target is None:
                rows.append(total)
            else:
                tangents[f.target] = total
        r = [self.value(residual.value) for residual in block.residuals]
        shape = (len(SPREAD), 0)
        if not rows:
            return np.zeros(shape), np.zeros((*shape, n))
        return np.stack(r, axis=1), np.stack(rows, axis=1)


def _least(r: Values, jacobian: Values) -> Values:
    """Newton's step of least norm at each position; nan where there is none."""
    k, m, n = jacobian.shape
    if not m:
        return np.zeros((k, n))
    steps = np.full((k, n), math.nan)
    for i in range(k):
        if np.isfinite(jacobian[i]).all() and np.isfinite(r[i]).all():
            with suppress(np.linalg.LinAlgError):
                steps[i] = _shortest(jacobian[i], r[i])
    return steps


def _shortest(jacobian: Values, r: Values) -> Values:
    """The shortest x with `jacobian @ x` = r, or nearest to r. Where the conditions are independent
    a QR decomposition has it, at a tenth of what singular values cost."""
    across, triangle = np.linalg.qr(jacobian.T)
    sizes = np.abs(np.diagonal(triangle))
    if len(r) <= jacobian.shape[1] and sizes.min() > _INDEPENDENT * sizes.max():
        return np.asarray(across @ np.linalg.solve(triangle.T, r))
    return np.asarray(np.linalg.lstsq(jacobian, r, rcond=1e-9)[0])
