"""A torn block as code: what is computed before it, in it, and its Jacobian.

In:   a `Block`, and the `Lister` of the section that it stands in
Out:  the statements before the block, and its `BlockCode`

Example, tears (x), r = x*x - a*b:          tears (x), y = a*x, r = y - b, linear:

    before      $t1 := a*b                  before      residual at x = 0: $t1 := -b
    body        $t2 := x^2 - $t1            body        y := a*x, once x is known
    jacobian    (0, 0, 2*x)                 jacobian    (0, 0, a)

Needs:     the section's Lister has seen the block's formulas (`formulas`).
Promises:  parts that do not depend on the block's unknowns are computed before it; a
           linear block is solved from its residuals at zero and its matrix alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from planarc.codegen import jacobian as forward
from planarc.codegen.affine import Steps, at_zero
from planarc.codegen.factoring import Factoring
from planarc.codegen.reach import FEWEST
from planarc.codegen.statements import Lister, Temporaries, invariants
from planarc.ir.expr import Expr, Exprs, symbols
from planarc.ir.program import BlockCode, Let, Solve, Statement, Tangent
from planarc.ir.program import Direct as DirectCode
from planarc.ir.sorted import Assignment, Block

if TYPE_CHECKING:
    from planarc.codegen.elimination import Direct
    from planarc.codegen.samples import Samples


@dataclass(frozen=True, slots=True)
class Derived:
    """A block and its Jacobian in either form."""

    block: Block
    height: int
    first: int  # candidate index of the first tear, -1 in the top level
    unrolled: forward.Unrolled | None
    tangent: forward.Tangent | None
    zero: Steps  # inner unknowns of a linear block at zero
    residuals: tuple[Expr, ...]  # of a linear block at zero
    direct: Direct | None
    late: frozenset[Expr]  # inner unknowns that the block need not give
    size_steps: Steps  # what its residuals are compared with
    sizes: tuple[Expr, ...]

    @property
    def formulas(self) -> list[Expr]:
        """Everything that the section will have to write, in order."""
        found = [value for _, value in self.direct.steps] if self.direct else []
        found.extend(a.value for a in self.inner)
        if self.direct is not None:
            found.extend(r.value for r in self.block.residuals)
            found.extend(value for _, value in self.size_steps)
            found.extend(self.sizes)
        found.extend(value for _, value in self.zero)
        found.extend(self.residuals)
        found.extend(value for _, value in self.steps)
        found.extend(value for _, _, value in self.entries)
        return found

    @property
    def inner(self) -> list[Assignment]:
        """What the block computes itself."""
        return [a for a in self.block.inner if a.target not in self.late]

    @property
    def steps(self) -> tuple[tuple[Expr, Expr], ...]:
        """What the Jacobian computes first, under names of its own."""
        if self.tangent is not None:
            return self.tangent.slopes
        return self.unrolled.steps if self.unrolled is not None else ()

    @property
    def entries(self) -> tuple[tuple[int, int, Expr], ...]:
        return self.unrolled.entries if self.unrolled is not None else ()


def derive_block(
    table: Exprs,
    block: Block,
    height: int,
    first: int,
    factoring: Factoring,
    samples: Samples | None,
    late: frozenset[Expr],
) -> Derived:
    """Choose the form of the Jacobian by its size, and write it."""
    if not (block.linear and block.residuals):  # else the matrix may not use them
        _learn(factoring, block, late)
    inner = tuple((a.target, a.value) for a in block.inner)
    residuals = tuple(r.value for r in block.residuals)
    slopes = forward.local_slopes(table, block.tears, inner, residuals)
    unrolled = tangent = None
    if forward.count_entries(block.tears, slopes) > forward.LARGEST_UNROLLED:
        tangent = forward.tangent(table, block.tears, slopes)
    else:
        unrolled = forward.unroll(table, block.tears, slopes, factoring)
    if samples is not None:
        samples.solve(block, slopes)
    zero: Steps = ()
    direct: Direct | None = None
    sizes: tuple[Expr, ...] = ()
    size_steps: Steps = ()
    if block.linear and block.residuals:
        zero, residuals = at_zero(table, block)
        if not height and samples is not None and len(block.tears) >= FEWEST:
            from planarc.codegen.elimination import eliminate, size_terms

            direct = eliminate(table, block, slopes, samples)
            if direct is not None:
                size_steps, sizes = size_terms(table, block)
        _learn(factoring, block, late)
    return Derived(
        block,
        height,
        first,
        unrolled,
        tangent,
        zero,
        residuals,
        direct,
        late,
        size_steps,
        sizes,
    )


def _learn(factoring: Factoring, block: Block, late: frozenset[Expr]) -> None:
    for a in block.inner:
        if a.target not in late:
            factoring.learn(a.target, a.value)


class BlockWriter:
    """Collects the blocks of a program in the order of `Program.blocks`."""

    def __init__(self, table: Exprs, temporaries: Temporaries) -> None:
        self._table = table
        self._temporaries = temporaries
        self.blocks: list[BlockCode] = []

    def write(self, out: list[Statement], lister: Lister, derived: Derived) -> None:
        """Append the block, and what is computed before it, to a section."""
        before: list[Let] = []
        if derived.direct is not None:
            code = self._direct(before, lister, derived, derived.direct)
        elif derived.block.linear and derived.block.residuals:
            code = self._linear(before, lister, derived)
        else:
            code = self._nonlinear(before, lister, derived)
        out.extend(before)
        out.append(Solve(len(self.blocks)))
        self.blocks.append(code)

    def _linear(self, before: list[Let], lister: Lister, derived: Derived) -> BlockCode:
        residuals, jacobian, tangent = self._matrix(before, lister, derived)
        body: list[Let] = []
        for a in derived.inner:
            lister.let(body, a.target, a.value, a.equation)
        return _code(derived, body, len(body), residuals, [], jacobian, tangent)

    def _matrix(
        self, out: list[Let], lister: Lister, derived: Derived
    ) -> tuple[tuple[Expr, ...], tuple[tuple[int, int, Expr], ...], Tangent | None]:
        """Residuals at zero and the matrix of a linear block."""
        for symbol, value in (*derived.zero, *derived.steps):
            lister.name(out, symbol, value)
        residuals = self._residuals(out, lister, derived, derived.residuals)
        jacobian = tuple((i, j, lister.value(out, v)) for i, j, v in derived.entries)
        return residuals, jacobian, _tangent(lister, derived)

    def _direct(
        self, before: list[Let], lister: Lister, derived: Derived, direct: Direct
    ) -> BlockCode:
        block = derived.block
        for symbol, value in direct.steps:
            lister.name(before, symbol, value)
        tears = tuple(lister.value(before, e) for e in direct.tears)
        body: list[Let] = []
        for a in derived.inner:
            lister.let(body, a.target, a.value, a.equation)
        mark = lister.mark()
        check: list[Let] = []
        values = tuple(r.value for r in block.residuals)
        left = self._residuals(check, lister, derived, values)
        for symbol, value in derived.size_steps:
            lister.name(check, symbol, value)
        sizes = []
        for e in derived.sizes:
            sizes.append(self._temporaries.new())
            check.append(Let(sizes[-1], lister.value(check, e)))
        matrix: list[Let] = []
        residuals, jacobian, tangent = self._matrix(matrix, lister, derived)
        lister.forget(mark)
        checked = DirectCode(tears, tuple(check), left, tuple(sizes))
        code = _code(derived, body, len(body), residuals, matrix, jacobian, tangent)
        return replace(code, direct=checked)

    def _nonlinear(self, before: list[Let], lister: Lister, derived: Derived) -> BlockCode:
        block = derived.block
        steps: list[tuple[Expr, Expr]] = []
        if block.residuals:
            varying = set(block.tears) | {a.target for a in block.inner}
            for symbol, value in derived.steps:
                if varying.isdisjoint(symbols(value)):
                    lister.name(before, symbol, value)
                else:
                    varying.add(symbol)
                    steps.append((symbol, value))
            lister.hold(before, invariants(derived.formulas, varying))
        body: list[Let] = []
        for a in derived.inner:
            lister.let(body, a.target, a.value, a.equation)
        inner = len(body)
        mark = lister.mark()
        residuals = self._residuals(body, lister, derived, derived.residuals)
        matrix: list[Let] = []
        for symbol, value in steps:
            lister.name(matrix, symbol, value)
        jacobian = tuple((i, j, lister.value(matrix, v)) for i, j, v in derived.entries)
        tangent = _tangent(lister, derived)
        lister.forget(mark)
        return _code(derived, body, inner, residuals, matrix, jacobian, tangent)

    def _residuals(
        self, out: list[Let], lister: Lister, derived: Derived, values: tuple[Expr, ...]
    ) -> tuple[Expr, ...]:
        names = []
        for r, value in zip(derived.block.residuals, values, strict=True):
            names.append(self._temporaries.new())
            out.append(Let(names[-1], lister.value(out, value), r.equation))
        return tuple(names)


def _tangent(lister: Lister, derived: Derived) -> Tangent | None:
    if derived.tangent is None:
        return None
    mark = lister.mark()
    body: list[Let] = []
    for symbol, value in derived.tangent.steps:
        lister.let(body, symbol, value)
    entries = tuple(lister.value(body, e) for e in derived.tangent.entries)
    lister.forget(mark)
    return Tangent(derived.tangent.seeds, tuple(body), entries)


def _code(
    derived: Derived,
    body: list[Let],
    inner: int,
    residuals: tuple[Expr, ...],
    matrix: list[Let],
    jacobian: tuple[tuple[int, int, Expr], ...],
    tangent: Tangent | None,
) -> BlockCode:
    block = derived.block
    return BlockCode(
        height=derived.height,
        tears=block.tears,
        body=tuple(body),
        residuals=residuals,
        jacobian_body=tuple(matrix),
        jacobian=jacobian,
        linear=block.linear,
        equations=tuple(r.equation for r in block.residuals),
        first=derived.first,
        inner=inner,
        tangent=tangent,
    )
