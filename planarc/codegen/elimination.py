"""Solves a large linear block by sparse elimination, written out as statements.

In:   a linear block of the top level: each equation's slopes by the block's unknowns
Out:  `Direct`: steps, and the tears as expressions of them

The equations of a mechanism's accelerations and forces are sparse: a body knows its
neighbours only. Eliminated in the right order, a chain of n rods costs a number of
operations proportional to n, where its torn, dense matrix costs n^3. The order is
chosen once: always a pivot that fills little (Markowitz), and that is not small beside
its column at any of a few sample positions of the mechanism (`samples`), or at fewer than
half of them where there is no better one.

    a = m*z - f           z = a/r, f = k*z           (unknowns a, f, z)
    -a + m*z - f = 0      pivot a (-1)
    r*z - a = 0           becomes (r - m)*z + f = 0
    f - k*z = 0           pivot f (1): (r - m + k)*z = 0 ...

Needs:     slopes that do not depend on the block's unknowns.
Promises:  exact but for rounding, where no pivot vanishes. Pivots are not compared
           with each other while running: whoever uses the result must look at the
           residuals (`residuals` gives their scale), and solve with pivoting when
           they are not small.
Reference: H. M. Markowitz, Management Science 3(3), 1957, 255-269; the recursion that
           comes out for chains is R. Featherstone, Robot Dynamics Algorithms, 1987.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from heapq import heappop, heappush
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct, field

from planarc.codegen.jacobian import Local
from planarc.codegen.residuals import Steps, size_terms
from planarc.codegen.samples import Samples
from planarc.codegen.statements import is_trivial
from planarc.core.data import Data
from planarc.ir.expr import Expr, Exprs, Op, Substitution, below
from planarc.ir.sorted import Block

if TYPE_CHECKING:
    from planarc.core.arrays import Vector as Values

_CONST = Op.CONST  # as in `ir.expr`
#: Products per equation from which an elimination fills up and gains nothing.
MOST_PRODUCTS = 40
#: Least sizes of a pivot, relative to the other coefficients of its unknown, tried in turn, with
#: the part of the samples at which it may be smaller. The last pivots of a long row of loops are
#: products of all before them, and almost zero near one position or other.
TRIALS = ((0.1, 0.0), (0.01, 0.0), (0.001, 0.0), (1e-5, 0.0), (1e-5, 0.49))
#: Least size of a pivot where the largest coefficients are near 1.
SMALLEST = 1e-9


class Direct(Data):
    """The steps before the block that give its tears, and those behind it that give the
    sizes which its residuals are compared with."""

    steps: Steps  # (temporary, value), in order
    tears: tuple[Expr, ...]
    size_steps: Steps
    sizes: tuple[Expr, ...]

    @property
    def formulas(self) -> list[Expr]:
        steps = [value for _, value in (*self.steps, *self.size_steps)]
        return [*steps, *self.tears, *self.sizes]


def eliminate(
    table: Exprs, block: Block, formulas: Sequence[Local], samples: Samples
) -> Direct | None:
    """The block solved by elimination; None where that does not pay or cannot be done. `formulas`
    are the block's, with their slopes."""
    tears = block.tears
    unknowns = [*tears, *(f.target for f in formulas if f.target is not None)]
    varying = set(unknowns)
    if not varying.isdisjoint(below(slope for f in formulas for _, slope in f.slopes)):
        return None
    zero = Substitution(table, dict.fromkeys(unknowns, table.zero))
    number = {u: i for i, u in enumerate(unknowns)}
    work = _Work(table)
    inner = {a.target: a.value for a in block.inner}
    residuals = iter(block.residuals)
    for f in formulas:
        value = next(residuals).value if f.target is None else inner[f.target]
        row = {number[s]: slope for s, slope in f.slopes}
        if f.target is not None:
            own = row.get(number[f.target], table.zero)
            row[number[f.target]] = table.sub(own, table.one)
        work.add(row, zero(value))
    if not work.run(samples):
        return None
    found = work.substitute(range(len(tears)))
    return Direct(tuple(work.steps), found, *size_terms(table, block))


class _Work(Struct):
    """The rows while they are eliminated: coefficient by unknown, and constant part.

    `numbers` are the coefficients at the samples, scaled so that the largest of each
    row and column is near 1: a few each, for which lists are quicker than arrays.
    """

    table: Exprs
    rows: list[dict[int, Expr]] = field(default_factory=list)
    numbers: list[dict[int, list[float]]] = field(default_factory=list)
    constants: list[Expr] = field(default_factory=list)
    columns: dict[int, dict[int, None]] = field(default_factory=dict)  # rows of each unknown
    order: list[tuple[int, int, Expr]] = field(default_factory=list)  # (row, unknown, 1/pivot)
    steps: list[tuple[Expr, Expr]] = field(default_factory=list)
    heap: list[tuple[int, int, int]] = field(default_factory=list)
    names: dict[Expr, Expr] = field(default_factory=dict)
    products: int = 0

    def add(self, row: dict[int, Expr], constant: Expr) -> None:
        index = len(self.rows)
        self.rows.append({j: e for j, e in row.items() if e is not self.table.zero})
        self.constants.append(constant)
        for j in self.rows[-1]:
            self.columns.setdefault(j, {})[index] = None

    def run(self, samples: Samples) -> bool:
        """Eliminate everything; False when that is not possible or fills up."""
        sizes = samples.values([e for row in self.rows for e in row.values()])
        finite = np.isfinite(sizes).all(axis=0)  # the samples at which all coefficients are
        if not finite.any():
            return False
        self._scale(sizes[:, finite])
        waiting = dict.fromkeys(range(len(self.rows)))
        for threshold, part in TRIALS:
            spared = int(part * finite.sum())
            progress = True
            while waiting and progress:
                for i in waiting:
                    self._offer(i)
                progress = self._pass(waiting, threshold, spared)
                if self.products > MOST_PRODUCTS * len(self.rows):
                    return False
        return not waiting

    def _pass(self, waiting: dict[int, None], threshold: float, spared: int) -> bool:
        """Take pivots from the heap as long as there are any good enough."""
        before = len(waiting)
        while self.heap:
            cost, i, j = heappop(self.heap)
            if i not in waiting or j not in self.rows[i]:
                continue
            now = self._cost(i, j)
            if now > cost:
                heappush(self.heap, (now, i, j))
            elif self._is_large(i, j, threshold, spared):
                del waiting[i]
                self._eliminate(i, j)
        return len(waiting) < before

    def _scale(self, sizes: Values) -> None:
        """Set `numbers` from the coefficients of all rows, one below the other."""
        each = iter(np.abs(sizes).max(axis=1).tolist())
        largest: list[dict[int, float]] = [dict(zip(row, each, strict=False)) for row in self.rows]
        of_column = dict.fromkeys(self.columns, 1.0)
        for _ in range(3):
            of_row = [
                max((a * of_column[j] for j, a in row.items()), default=0.0) or 1.0
                for row in largest
            ]
            of_column = {
                j: 1.0 / (max(largest[i][j] / of_row[i] for i in rows) or 1.0)
                for j, rows in self.columns.items()
            }
        factors = [
            of_column[j] / size for row, size in zip(self.rows, of_row, strict=True) for j in row
        ]
        scaled = iter((sizes * np.array(factors)[:, None]).tolist())
        self.numbers = [dict(zip(row, scaled, strict=False)) for row in self.rows]

    def _offer(self, i: int) -> None:
        for j in self.rows[i]:
            heappush(self.heap, (self._cost(i, j), i, j))

    def _cost(self, i: int, j: int) -> int:
        """Markowitz' count of possible new entries; a division counts a little."""
        fill = (len(self.rows[i]) - 1) * (len(self.columns[j]) - 1)
        return 2 * fill + (self.rows[i][j].op is not _CONST)

    def _is_large(self, i: int, j: int, threshold: float, spared: int) -> bool:
        """Whether the pivot is large beside its column, at all samples but so many."""
        column = zip(*[self.numbers[k][j] for k in self.columns[j]], strict=True)
        for number, others in zip(self.numbers[i][j], column, strict=True):
            pivot = abs(number)
            # Nothing is large beside what is not a number.
            if not (pivot > SMALLEST and all(pivot >= threshold * abs(o) for o in others)):
                if not spared:
                    return False
                spared -= 1
        return True

    def _named(self, e: Expr) -> Expr:
        """A temporary for a value that is used several times."""
        if is_trivial(e):
            return e
        name = self.names.get(e)
        if name is None:
            name = self.names[e] = self.table.symbol(f"$e[{e.id}]")
            self.steps.append((name, e))
        return name

    def _eliminate(self, i: int, j: int) -> None:
        t = self.table
        row = {k: self._named(e) for k, e in self.rows[i].items()}
        constant = self._named(self.constants[i])
        pivot = row.pop(j)
        inverse = self._named(t.div(t.one, pivot))
        self.rows[i], self.constants[i] = row, constant
        self.order.append((i, j, inverse))
        others = [k for k in self.columns.pop(j) if k != i]
        for k in row:
            del self.columns[k][i]
        for k in others:
            self._subtract(k, j, i, inverse)
        for k in others:
            self._offer(k)

    def _subtract(self, i: int, j: int, pivot_row: int, inverse: Expr) -> None:
        """Take the pivot's row from row i, so that unknown j vanishes from it."""
        t, target, numbers = self.table, self.rows[i], self.numbers[i]
        factor = self._named(t.mul(target.pop(j), inverse))
        beside = self.numbers[pivot_row]
        # A sample whose pivot is 0 was spared: it has no numbers from here on.
        pairs = zip(numbers.pop(j), beside[j], strict=True)
        ratio = [a / b if b else math.nan for a, b in pairs]
        none = [0.0] * len(ratio)
        for k, e in self.rows[pivot_row].items():
            product = t.mul(factor, e)
            new = t.sub(target[k], product) if k in target else t.neg(product)
            self.products += 1
            if new is not t.zero:
                target[k] = new
                known = zip(numbers.get(k, none), ratio, beside[k], strict=True)
                numbers[k] = [a - r * b for a, r, b in known]
                self.columns[k][i] = None
            elif k in target:
                del target[k], numbers[k], self.columns[k][i]
        constant = self.constants[pivot_row]
        self.constants[i] = t.sub(self.constants[i], t.mul(factor, constant))

    def substitute(self, wanted: Sequence[int]) -> tuple[Expr, ...]:
        """The unknowns, backwards; only those that the wanted ones need."""
        needed = set(wanted)
        for i, j, _ in self.order:
            if j in needed:
                needed.update(self.rows[i])
        t = self.table
        found: dict[int, Expr] = {}
        for i, j, inverse in reversed(self.order):
            if j in needed:
                terms = (t.mul(e, found[k]) for k, e in self.rows[i].items())
                total = t.add(self.constants[i], *terms)
                found[j] = self._named(t.neg(t.mul(total, inverse)))
        return tuple(found[j] for j in wanted)
