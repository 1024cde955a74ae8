"""A torn block as code: what is computed before it, in it, and its Jacobian.

In:   a block with its derivatives, and the `Lister` of the section that it stands in
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

from collections.abc import Iterable

from msgspec.structs import replace

from planarc.codegen.derive import Derived
from planarc.codegen.layout import Layout
from planarc.codegen.statements import Lister, Temporaries, invariants
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs, Op, postorder, symbols
from planarc.ir.program import BlockCode, Direct, Let, Solve, Statement, Tangent
from planarc.ir.sorted import Assignment
from planarc.ir.sparse import constant_name, entries_of, residuals_of


class Modes:
    """Blocks that change their shape at events: their matrix depends on discrete values.

    `mass := if event[0] then 2 else 0` switches, and mass*der(v) = f is a modal block. `steps` are
    those that are computed while running, in their order.
    """

    def __init__(self, dae: Dae, steps: Iterable[Derived | Assignment]) -> None:
        self._present = bool(dae.discretes or dae.relations or dae.samplers)
        self._discretes = frozenset(v.name for v in dae.discretes)
        self._switching: set[Expr] = set()
        for step in steps if self._present else ():
            for a in step.inner:
                if self._switches((a.value,)):
                    self._switching.add(a.target)

    def is_modal(self, derived: Derived) -> bool:
        """Whether the matrix of a block of the top level depends on discrete values."""
        if not self._present or derived.height or not derived.block.residuals:
            return False
        slopes = [value for _, value in derived.steps] + [v for _, _, v in derived.entries]
        if derived.direct is not None:
            slopes += entries_of(derived.direct)
        if derived.tangent is not None:
            slopes += [v for _, v in derived.tangent.steps] + list(derived.tangent.entries)
        return self._switches(slopes)

    def _switches(self, formulas: Iterable[Expr]) -> bool:
        return any(
            e.op in (Op.EVENT, Op.PRE)
            or e in self._switching
            or (e.op is Op.SYMBOL and e.name in self._discretes)
            for e in postorder(formulas)
        )


class BlockWriter:
    """Collects the blocks of a program in the order of `Program.blocks`."""

    def __init__(
        self, table: Exprs, layout: Layout, temporaries: Temporaries, modes: Modes
    ) -> None:
        self._table = table
        self._layout = layout
        self._temporaries = temporaries
        self._modes = modes
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
        self.blocks.append(replace(code, modal=self._modes.is_modal(derived)))

    def _linear(self, before: list[Let], lister: Lister, derived: Derived) -> BlockCode:
        residuals, jacobian, tangent = self._matrix(before, lister, derived)
        body = lister.assigned(derived.inner)
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
        """All values of the equations in slots, for a table that says where to find them."""
        lister.hold(before, direct.values)
        values = [lister.value(before, e) for e in direct.values]
        for e in values:
            if e.op is Op.CONST and constant_name(e) not in self._layout.slots:
                before.append(Let(self._table.symbol(constant_name(e)), e))
                self._layout.add(constant_name(e))
        self._layout.add(*(e for e in values if e.op is Op.SYMBOL))
        body = lister.assigned(derived.inner)
        written = replace(direct, values=tuple(values))
        residuals = residuals_of(self._table, written)
        code = _code(derived, body, len(body), residuals, [], (), None)
        return replace(code, direct=written)

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
        body = lister.assigned(derived.inner)
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
