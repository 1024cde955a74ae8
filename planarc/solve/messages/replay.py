"""The statements of a program once more, in Python: what each gives where a kernel failed.

A kernel says that a block could not be solved, or that some number is not finite, and
nothing more: it is made to be fast. For the message everything is evaluated again, one
statement after the other, with the states and the tears as they stand in the workspace.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Op, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.program import BlockCode, Let, Program, RelationSlot, Solve, Statement, Tangent


class Replay:
    """Values of all statements at the workspace's present states and tears."""

    def __init__(self, program: Program, kernel: Kernel, t: float) -> None:
        self._program, self._w, self._t = program, kernel.w, t
        self._values: dict[Expr, float] = {}
        self.finite: set[int] = set()  # the equations that gave finite numbers

    def first_not_finite(self) -> int:
        """The first equation, in the order of evaluation, that gives no finite number, or -1."""
        for let in self._run((*self._program.levels, self._program.rest)):
            if let.equation is None:
                continue
            if not math.isfinite(self._values[let.target]):
                return let.equation
            self.finite.add(let.equation)
        return -1

    def first_relation(self) -> RelationSlot | None:
        """The first relation whose sides cannot be compared, after `first_not_finite`."""
        for _ in self._run((self._program.roots,)):
            pass
        relations = (r for r in self._program.relations if r.certain)
        return next((r for r in relations if math.isnan(self._value(r.zero))), None)

    def residuals(self, block: int) -> list[float]:
        """How far a block's equations are from being fulfilled; nan where that is not known."""
        program = self._program
        code = program.blocks[block]
        for _ in self._run((*program.levels, program.rest, program.initial), block):
            pass
        if code.direct is not None:
            return [self._value(r) for r in code.residuals]
        values = [self._values.get(r, math.nan) for r in code.residuals]
        return self._linear(code, values) if code.linear else values

    def values(self, wanted: Iterable[Expr]) -> list[float]:
        """The values of expressions that statements hold; nan where there is none."""
        if not self._values:
            for _ in self._run(self._program.levels):
                pass
        return [self._value(e) for e in wanted]

    def residuals_at(self, block: int, tears: Sequence[float]) -> list[float]:
        """The residuals for other tears, after `residuals`, which has evaluated all before it."""
        code = self._program.blocks[block]
        self._values.update(zip(code.tears, tears, strict=True))
        for _ in self._lets(code.body):
            pass
        return [self._values.get(r, math.nan) for r in code.residuals]

    def slopes(self, block: int) -> list[list[float]]:
        """The derivatives of the residuals that were evaluated last, a row for each."""
        code = self._program.blocks[block]
        for _ in self._lets(code.jacobian_body):
            pass
        found = [[0.0] * len(code.tears) for _ in code.residuals]
        for i, j, slope in code.jacobian:
            found[i][j] = self._value(slope)
        for j, seed in enumerate(code.tangent.seeds if code.tangent else ()):
            self._column(code.tangent, seed, j, found)
        return found

    def _column(
        self, tangent: Tangent | None, chosen: Expr, j: int, found: Sequence[list[float]]
    ) -> None:
        assert tangent is not None
        self._values.update((seed, float(seed is chosen)) for seed in tangent.seeds)
        for _ in self._lets(tangent.body):
            pass
        for row, entry in zip(found, tangent.entries, strict=True):
            row[j] = self._value(entry)

    def _linear(self, code: BlockCode, at_zero: Sequence[float]) -> list[float]:
        """The residuals of a linear block, known where all tears are zero, with their slopes."""
        if not code.jacobian and code.tears:
            return [math.nan] * len(at_zero)
        for _ in self._lets(code.jacobian_body):
            pass
        found = list(at_zero)
        for i, j, slope in code.jacobian:
            found[i] += self._value(slope) * self._values[code.tears[j]]
        return found

    def _run(self, lists: Iterable[Sequence[Statement]], last: int = -1) -> Iterator[Let]:
        """The assignments up to the end of block `last`, each when it is evaluated."""
        for statements in lists:
            for statement in statements:
                if isinstance(statement, Let):
                    yield from self._lets((statement,))
                    continue
                yield from self._block(statement)
                if statement.block == last:
                    return

    def _block(self, statement: Solve) -> Iterator[Let]:
        code = self._program.blocks[statement.block]
        for tear in code.tears:
            self._values[tear] = float(self._w[self._program.slots[repr(tear)]])
        yield from self._lets(code.body)

    def _lets(self, lets: Iterable[Let]) -> Iterator[Let]:
        for let in lets:
            slot = self._program.slots.get(repr(let.target))
            if slot is not None and any(e.op is Op.PAST for e in postorder((let.value,))):
                self._values[let.target] = float(self._w[slot])  # the past is not here
            else:
                self._values[let.target] = self._value(let.value)
            yield let

    def _value(self, e: Expr) -> float:
        try:
            return float(evaluate(e, self._leaf))
        except (ArithmeticError, ValueError):
            return math.nan

    def _leaf(self, e: Expr) -> float:
        if e.op is Op.TIME:
            return self._t
        known = self._values.get(e)
        if known is not None:
            return known
        slot = self._program.slots.get(repr(e))
        return math.nan if slot is None else float(self._w[slot])
