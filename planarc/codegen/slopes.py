"""The Jacobian of the right-hand side as a sparse linear system: the implicit function theorem.

In:   Program
Out:  `Slopes`: formulas of coefficients, and where they stand

Every value that the levels compute is a node, and moves when the states move: by d for
each. A formula ties its target's motion to those of what it reads; the residual of a
block ties the motions of its tears, though none of them has a formula; each state moves
as it is told. That is as many equations as nodes, and solving them for a motion of each
state gives the columns of the Jacobian, through torn blocks and for any choice of states.

    x = L*cos(phi)           d(x) + L*sin(phi)*d(phi) = 0
    residual x*y - a         y*d(x) + x*d(y) = 0
    state phi                d(phi) = 1

Coefficients are read at the present point: tears are taken from the workspace, where
solving has left them. A linear block's residual is its residual at zero and the product
of its matrix with the tears; of one that is solved by elimination, the residual itself.

Needs:     formulas that can be differentiated; `derive_slopes` gives None where the
           program calls functions that cannot.
Promises:  only nodes are kept that the derivatives of candidates, or tears, depend on.
Reference: A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008,
           section 15.3 (extended Jacobian systems).
"""

from __future__ import annotations

from planarc.core.data import Data
from planarc.ir.calculus import Differentiator, partial
from planarc.ir.expr import Expr, Op, postorder, symbols, text
from planarc.ir.program import BlockCode, Let, Program, Solve


class Slopes(Data):
    """`body` gives the present values without solving anything; `entries` are the rows of
    the system by number of equation and node. The rows of states are not among them."""

    nodes: tuple[Expr, ...]
    body: tuple[Let, ...]
    entries: tuple[tuple[int, int, Expr], ...]
    equations: int
    #: For each candidate the nodes of itself and of its derivative (-1: it does not move).
    candidates: tuple[tuple[int, int], ...]


def derive_slopes(program: Program) -> Slopes | None:
    return _Deriver(program).derive()


class _Deriver:
    def __init__(self, program: Program) -> None:
        self._program, self._table = program, program.table
        self._lets: list[Let] = []  # a value by its formula
        self._tears: list[Expr] = []
        self._vanish: list[Expr] = []  # symbols that are zero: residuals
        self._partials: dict[Expr, Differentiator] = {}

    def derive(self) -> Slopes | None:
        for level in self._program.levels:
            for s in level:
                if isinstance(s, Let):
                    self._lets.append(s)
                else:
                    self._block(s)
        lets = self._needed()
        if any(e.op in (Op.APPLY, Op.PAST) for e in postorder(let.value for let in lets)):
            return None
        return self._system(lets)

    def _block(self, s: Solve) -> None:
        code = self._program.blocks[s.block]
        self._tears.extend(code.tears)
        if code.direct is not None:
            self._lets.extend((*code.body[: code.inner], *code.direct.check))
            self._vanish.extend(code.direct.residuals)
        elif code.linear and code.residuals:
            self._lets.extend(code.body[: code.inner])
            self._linear(code)
        else:
            self._lets.extend(code.body)
            self._vanish.extend(code.residuals)

    def _linear(self, code: BlockCode) -> None:
        """The residuals at the tears, from those at zero and the matrix."""
        table = self._table
        sums = [[r] for r in code.residuals]
        if code.tangent is not None:
            pairs = zip(code.tangent.seeds, code.tears, strict=True)
            self._lets.extend(Let(seed, tear) for seed, tear in pairs)
            self._lets.extend(code.tangent.body)
            for i, entry in enumerate(code.tangent.entries):
                sums[i].append(entry)
        for i, j, value in code.jacobian:
            sums[i].append(table.mul(value, code.tears[j]))
        for r, terms in zip(code.residuals, sums, strict=True):
            name = table.symbol(f"$whole({text(r)})")
            self._lets.append(Let(name, table.add(*terms)))
            self._vanish.append(name)

    def _needed(self) -> list[Let]:
        wanted = set(self._vanish)
        by_slot = {self._program.slots.get(text(let.target)): let.target for let in self._lets}
        for c in self._program.candidates:
            if c.derivative in by_slot:
                wanted.add(by_slot[c.derivative])
        kept = []
        for let in reversed(self._lets):
            if let.target in wanted:
                kept.append(let)
                wanted.update(symbols(let.value))
        return kept[::-1]

    def _system(self, lets: list[Let]) -> Slopes:
        nodes = [*self._tears, *(let.target for let in lets)]
        number = {e: i for i, e in enumerate(nodes)}
        entries: list[tuple[int, int, Expr]] = []
        for row, let in enumerate(lets):
            entries.append((row, number[let.target], self._table.const(-1.0)))
            for s in sorted(s for s in symbols(let.value) if s in number):
                slope = self._partial(s)(let.value)
                if slope is not self._table.zero:
                    entries.append((row, number[s], slope))
        for row, name in enumerate(self._vanish, len(lets)):
            entries.append((row, number[name], self._table.one))
        places = {self._program.slots.get(text(e)): i for e, i in number.items()}
        return Slopes(
            tuple(nodes),
            tuple(lets),
            tuple(entries),
            len(lets) + len(self._vanish),
            tuple((places[c.slot], places.get(c.derivative, -1)) for c in self._program.candidates),
        )

    def _partial(self, symbol: Expr) -> Differentiator:
        found = self._partials.get(symbol)
        if found is None:
            found = self._partials[symbol] = partial(self._table, symbol)
        return found
