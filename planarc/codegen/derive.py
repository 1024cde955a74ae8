"""The needs of solving a block beside its own formulas: Jacobian, residuals at zero, elimination.

In:   the steps that are computed while running, in their order
Out:  each block as `Derived`

The Jacobian is unrolled where that is short, else one column as code (`jacobian`). A
linear block is solved from its residuals at zero (`residuals`); a large one of the top
level by sparse elimination (`elimination`).

Needs:     every step that a block depends on was seen before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.codegen import jacobian as forward
from planarc.codegen.factoring import Factoring
from planarc.codegen.reach import FEWEST, Reach
from planarc.codegen.residuals import Steps, at_zero
from planarc.core.data import Data
from planarc.ir.expr import Expr
from planarc.ir.sorted import Assignment, Block, SortedDae, Step

if TYPE_CHECKING:
    from planarc.codegen.samples import Samples
    from planarc.ir.program import Direct


class Derived(Data):
    """A block and what it is solved with."""

    block: Block
    height: int
    first: int  # candidate index of the first tear, -1 in the top level
    inner: tuple[Assignment, ...]  # what the block computes itself
    residuals: tuple[Expr, ...] = ()  # of a linear block: where all tears are zero
    unrolled: forward.Unrolled | None = None
    tangent: forward.Tangent | None = None
    zero: Steps = ()  # of a linear block: inner unknowns where all tears are zero
    direct: Direct | None = None

    @property
    def formulas(self) -> list[Expr]:
        """Everything that the section will have to write, in order."""
        found = [a.value for a in self.inner]
        if self.direct is not None:
            found.extend(self.direct.values)
        found.extend(value for _, value in self.zero)
        found.extend(self.residuals)
        found.extend(value for _, value in self.steps)
        found.extend(value for _, _, value in self.entries)
        return found

    @property
    def steps(self) -> Steps:
        """The values that the Jacobian computes first, under names of its own."""
        if self.tangent is not None:
            return self.tangent.slopes
        return self.unrolled.steps if self.unrolled is not None else ()

    @property
    def entries(self) -> tuple[tuple[int, int, Expr], ...]:
        return self.unrolled.entries if self.unrolled is not None else ()


class Deriver:
    """Goes through the steps in their order."""

    def __init__(self, sorted: SortedDae, reach: Reach) -> None:
        self._table = sorted.dae.table
        self._late = reach.late
        self._factoring = Factoring(self._table)
        self._samples = _take_samples(sorted, reach)
        self._first = {c.symbol: i for i, c in enumerate(sorted.candidates)}

    def derive(self, steps: Sequence[Step], height: int) -> list[Derived | Assignment]:
        return [
            self._assignment(s) if isinstance(s, Assignment) else self._block(s, height)
            for s in steps
        ]

    def _assignment(self, a: Assignment) -> Assignment:
        self._factoring.learn((a,))
        if self._samples is not None:
            self._samples.assign((a,))
        return a

    def _block(self, block: Block, height: int) -> Derived:
        table = self._table
        first = self._first[block.tears[0]] if height and block.tears else -1
        own = tuple(a for a in block.inner if a.target not in self._late)
        residuals = tuple(r.value for r in block.residuals)
        linear = block.linear and bool(residuals)
        if not linear:  # its matrix may use what the block computes
            self._factoring.learn(own)
        assignments = tuple((a.target, a.value) for a in block.inner)
        slopes = forward.local_slopes(table, block.tears, assignments, residuals)
        if self._samples is not None:
            self._samples.solve(block, slopes)
        direct = self._direct(block, slopes) if linear and not height else None
        if direct is not None:
            self._factoring.learn(own)
            return Derived(block, height, first, own, direct=direct)
        unrolled, tangent = self._jacobian(block, slopes)
        zero: Steps = ()
        if linear:
            zero, residuals = at_zero(table, block)
            self._factoring.learn(own)
        return Derived(block, height, first, own, residuals, unrolled, tangent, zero)

    def _jacobian(
        self, block: Block, slopes: tuple[forward.Local, ...]
    ) -> tuple[forward.Unrolled | None, forward.Tangent | None]:
        if forward.is_long(block.tears, slopes):
            return None, forward.tangent(self._table, block.tears, slopes)
        return forward.unroll(self._table, block.tears, slopes, self._factoring), None

    def _direct(self, block: Block, slopes: tuple[forward.Local, ...]) -> Direct | None:
        if self._samples is None or len(block.tears) < FEWEST:
            return None
        from planarc.codegen.elimination import eliminate

        return eliminate(self._table, block, slopes, self._samples)


def _take_samples(sorted: SortedDae, reach: Reach) -> Samples | None:
    """Sample values, where a block is large enough to profit from them."""
    steps = [*reach.levels[-1], *reach.rest] if reach.levels else []
    if not any(isinstance(s, Block) and s.linear and len(s.tears) >= FEWEST for s in steps):
        return None
    from planarc.codegen.samples import Samples

    samples = Samples(sorted)
    samples.assign(reach.constant)
    return samples
