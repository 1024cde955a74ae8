"""A torn block as code: what is computed before it, in it, and its Jacobian.

In:   a `Block`, and the `Lister` of the section that it stands in
Out:  the statements before the block, and its `BlockCode`

Example, tears (x), r = x*x - a*b:

    before      $t1 := a*b
    body        $t2 := x^2 - $t1
    jacobian    (0, 0, 2*x)

Needs:     the section's Lister has seen the block's formulas (`formulas`).
Promises:  parts that do not depend on the block's unknowns are computed before it;
           a linear block's whole Jacobian is.
"""

from __future__ import annotations

from dataclasses import dataclass

from planarc.codegen import jacobian as forward
from planarc.codegen.statements import Lister, Temporaries, invariants
from planarc.ir.expr import Expr, Exprs, symbols
from planarc.ir.program import BlockCode, Let, Solve, Statement, Tangent
from planarc.ir.sorted import Block


@dataclass(frozen=True, slots=True)
class Derived:
    """A block and its Jacobian in either form."""

    block: Block
    height: int
    first: int  # candidate index of the first tear, -1 in the top level
    unrolled: forward.Unrolled | None
    tangent: forward.Tangent | None

    @property
    def formulas(self) -> list[Expr]:
        """Everything that the section will have to write, in order."""
        found = [a.value for a in self.block.inner]
        found.extend(r.value for r in self.block.residuals)
        found.extend(value for _, value in self.steps)
        found.extend(value for _, _, value in self.entries)
        return found

    @property
    def steps(self) -> tuple[tuple[Expr, Expr], ...]:
        """What the Jacobian computes first, under names of its own."""
        if self.tangent is not None:
            return self.tangent.slopes
        return self.unrolled.steps if self.unrolled is not None else ()

    @property
    def entries(self) -> tuple[tuple[int, int, Expr], ...]:
        return self.unrolled.entries if self.unrolled is not None else ()


def derive_block(table: Exprs, block: Block, height: int, first: int) -> Derived:
    """Choose the form of the Jacobian by its size, and write it."""
    if not block.residuals:
        return Derived(block, height, first, None, None)
    inner = tuple((a.target, a.value) for a in block.inner)
    residuals = tuple(r.value for r in block.residuals)
    slopes = forward.local_slopes(table, block.tears, inner, residuals)
    if forward.count_entries(block.tears, slopes) > forward.LARGEST_UNROLLED:
        return Derived(block, height, first, None, forward.tangent(table, block.tears, slopes))
    return Derived(block, height, first, forward.unroll(table, block.tears, slopes), None)


class BlockWriter:
    """Collects the blocks of a program in the order of `Program.blocks`."""

    def __init__(self, table: Exprs, temporaries: Temporaries) -> None:
        self._table = table
        self._temporaries = temporaries
        self.blocks: list[BlockCode] = []

    def write(self, out: list[Statement], lister: Lister, derived: Derived) -> None:
        """Append the block, and what is computed before it, to a section."""
        block = derived.block
        steps: list[tuple[Expr, Expr]] = []
        if block.residuals:
            before: list[Let] = []
            varying = set(block.tears) | {a.target for a in block.inner}
            for symbol, value in derived.steps:
                if varying.isdisjoint(symbols(value)):
                    if not lister.knows(value, symbol):  # from an earlier block
                        lister.let(before, symbol, value)
                else:
                    varying.add(symbol)
                    steps.append((symbol, value))
            lister.hold(before, invariants(derived.formulas, varying))
            out.extend(before)
        body: list[Let] = []
        for a in block.inner:
            lister.let(body, a.target, a.value, a.equation)
        inner = len(body)
        mark = lister.mark()
        residuals = self._residuals(body, lister, block)
        jacobian_body: list[Let] = []
        for symbol, value in steps:
            lister.let(jacobian_body, symbol, value)
        jacobian = tuple((i, j, lister.value(jacobian_body, v)) for i, j, v in derived.entries)
        tangent = _tangent(derived)
        lister.forget(mark)
        out.append(Solve(len(self.blocks)))
        self.blocks.append(
            BlockCode(
                height=derived.height,
                tears=block.tears,
                body=tuple(body),
                residuals=residuals,
                jacobian_body=tuple(jacobian_body),
                jacobian=jacobian,
                linear=block.linear,
                equations=tuple(r.equation for r in block.residuals),
                first=derived.first,
                inner=inner,
                tangent=tangent,
            )
        )

    def _residuals(self, body: list[Let], lister: Lister, block: Block) -> tuple[Expr, ...]:
        names = []
        for r in block.residuals:
            names.append(self._temporaries.new())
            body.append(Let(names[-1], lister.value(body, r.value), r.equation))
        return tuple(names)


def _tangent(derived: Derived) -> Tangent | None:
    if derived.tangent is None:
        return None
    steps = tuple(Let(symbol, value) for symbol, value in derived.tangent.steps)
    return Tangent(derived.tangent.seeds, steps, derived.tangent.entries)
