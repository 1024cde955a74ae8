"""Chooses the order in which a large linear block is eliminated.

In:   a linear block of the top level: each equation's slopes by the block's unknowns
Out:  `Direct`: the values in the block's equations, and the operations of its elimination

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

What comes out are operations with numbered numbers (`ir.sparse`); those with 0 and 1 are done
here.

Needs:     slopes that do not depend on the block's unknowns.
Promises:  exact but for rounding, where no pivot vanishes. Pivots are not compared
           with each other while running: whoever uses the result must look at the
           residuals, and solve with pivoting when they are not small.
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
from planarc.codegen.samples import SPREAD, Samples
from planarc.ir.expr import Exprs, Op, Substitution, below
from planarc.ir.program import Direct
from planarc.ir.sorted import Block

if TYPE_CHECKING:
    from planarc.core.arrays import Array as Indices
    from planarc.core.arrays import Vector as Values

#: Products per equation from which an elimination fills up and gains nothing.
MOST_PRODUCTS = 15
#: Least sizes of a pivot, relative to the other coefficients of its unknown, tried in turn, with
#: the part of the samples at which it may be smaller. The last pivots of a long row of loops are
#: products of all before them, and almost zero near one position or other.
TRIALS = ((0.1, 0.0), (0.01, 0.0), (0.001, 0.0), (1e-5, 0.0), (1e-5, 0.49))
#: Least size of a pivot where the largest coefficients are near 1.
SMALLEST = 1e-9


def eliminate(
    table: Exprs, block: Block, formulas: Sequence[Local], samples: Samples
) -> Direct | None:
    """The block and the order of its elimination; None where that does not pay or cannot be done.
    `formulas` are the block's, with their slopes."""
    inner = [f.target for f in formulas if f.target is not None]
    unknowns = (*block.tears, *inner)
    varying = set(unknowns)
    if not varying.isdisjoint(below(slope for f in formulas for _, slope in f.slopes)):
        return None
    zero = Substitution(table, dict.fromkeys(unknowns, table.zero))
    number = {u: i for i, u in enumerate(unknowns)}
    given = {a.target: a.value for a in block.inner}
    residuals = iter(block.residuals)
    formed = [next(residuals).value if f.target is None else given[f.target] for f in formulas]
    constants = [zero(value) for value in formed]
    found = dict.fromkeys((*constants, *(slope for f in formulas for _, slope in f.slopes)))
    values = [e for e in found if e.op is not Op.CONST]
    work = _Work(len(block.tears), _Operations(len(values)))
    done, refs = work.done, {e: 2 * i for i, e in enumerate(values)}
    refs |= {e: done.number(float(e.data)) for e in found if e.op is Op.CONST}
    sizes = dict(zip(found, samples.values(list(found)), strict=True))
    for constant, f in zip(constants, formulas, strict=True):
        entries = [(number[s], refs[slope], sizes[slope]) for s, slope in f.slopes]
        work.add(refs[constant], entries, own=f.target is not None)
    if not work.run():
        return None
    tears = work.substitute()
    values += map(table.const, done.numbers)
    place = {e: i for i, e in enumerate(dict.fromkeys((*values, *found)))}
    rows = [len(unknowns), len(tears)]
    for constant, f in zip(constants, formulas, strict=True):
        rows += (place[constant], len(f.slopes))
        for s, slope in f.slopes:
            rows += (number[s], place[slope])

    operations = tuple([done.placed(listed, len(place)) for listed in done.listed])
    return Direct(unknowns, tuple(place), tuple(rows), operations, done.placed(tears, len(place)))


#: References of 0 and 1; -1 at all samples.
_ZERO, _ONE = -2, -4
_MINUS_ONE = np.full(len(SPREAD), -1.0)


class _Operations(Struct):
    """What is done while running, as far as it is known. A number is told by a reference: twice its
    index, and one more for its negative; constants have negative ones until all are known."""

    values: int
    listed: list[tuple[int, ...]] = field(default_factory=list)
    numbers: dict[float, int] = field(default_factory=lambda: {0.0: _ZERO, 1.0: _ONE})
    exact: dict[int, float] = field(
        default_factory=lambda: {_ZERO: 0.0, _ZERO ^ 1: 0.0, _ONE: 1.0, _ONE ^ 1: -1.0}
    )  # by reference
    known: dict[tuple[int, ...], int] = field(default_factory=dict)

    def number(self, value: float) -> int:
        """A constant."""
        ref = self.numbers.setdefault(abs(value), -2 * len(self.numbers) - 2)
        self.exact[ref], self.exact[ref ^ 1] = abs(value), -abs(value)
        return ref ^ (value < 0)

    def inverse(self, a: int) -> int:
        if a in self.exact:
            return self.number(1.0 / self.exact[a])
        return self._done(a & -2) ^ a & 1

    def sum(self, a: int, b: int, c: int) -> int:
        """a + b*c."""
        exact = self.exact
        if b in exact and c in exact:
            b, c = self.number(exact[b] * exact[c]), _ONE
        elif b & -2 == _ONE or c & -2 == _ZERO:
            b, c = c, b
        if b & -2 == _ZERO:
            return a
        if c & -2 == _ONE:
            b, c = b ^ c & 1, _ONE
            if a & -2 == _ZERO:
                return b
            if a == b ^ 1:
                return _ZERO
            if a in exact and b in exact:
                return self.number(exact[a] + exact[b])
        sign = a & 1
        return self._done(a ^ sign, (b ^ c ^ sign) & 1 | b & -2, c & -2) ^ sign

    def _done(self, *operation: int) -> int:
        if operation not in self.known:
            self.known[operation] = 2 * (self.values + len(self.listed))
            self.listed.append(operation)
        return self.known[operation]

    def placed(self, refs: Sequence[int], known: int) -> tuple[int, ...]:
        """References where constants stand behind the values, and results behind all `known`."""
        first, further = 2 * self.values, 2 * (known - self.values)
        constant = first - 2
        return tuple(
            [
                (constant - (r & -2) | r & 1) if r < 0 else r if r < first else r + further
                for r in refs
            ]
        )


class _Work(Struct):
    """The rows while they are eliminated: a reference for each coefficient, and its values at the
    samples, scaled so that the largest of each row and column is near 1: a few each, for which
    lists are quicker than arrays."""

    tears: int
    done: _Operations
    rows: list[dict[int, int]] = field(default_factory=list)
    numbers: list[dict[int, list[float]]] = field(default_factory=list)
    constants: list[int] = field(default_factory=list)
    columns: dict[int, dict[int, None]] = field(default_factory=dict)  # rows of each unknown
    order: list[tuple[int, int, int]] = field(default_factory=list)  # (row, unknown, 1/pivot)
    heap: list[tuple[int, int, int]] = field(default_factory=list)
    products: int = 0

    def add(
        self, constant: int, entries: Sequence[tuple[int, int, Values]], own: bool = False
    ) -> None:
        """A row: unknowns with their coefficients; whether it gives an unknown of its `own`."""
        index, listed = len(self.rows), list(entries)
        if own:
            listed.append((self.tears + index, self.done.number(-1.0), _MINUS_ONE))
        self.rows.append({j: ref for j, ref, _ in listed})
        self.numbers.append({j: sizes for j, _, sizes in listed})  # type: ignore[misc]
        self.constants.append(constant)
        for j, _, _ in listed:
            self.columns.setdefault(j, {})[index] = None

    def run(self) -> bool:
        """Eliminate everything; False when that is not possible or fills up."""
        sizes = np.array([e for row in self.numbers for e in row.values()])
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
        while self.heap and waiting:
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
        rows = np.repeat(np.arange(len(self.rows)), [*map(len, self.rows)])
        unknowns = np.array([j for row in self.rows for j in row])
        largest, of_column = np.abs(sizes).max(axis=1), np.ones(len(self.rows))
        with np.errstate(all="ignore"):
            for _ in range(3):
                of_row = _largest(rows, largest * of_column[unknowns], len(self.rows))
                of_column = 1.0 / _largest(unknowns, largest / of_row[rows], len(self.rows))
            factors = of_column[unknowns] / of_row[rows]
        scaled = iter((sizes * factors[:, None]).tolist())
        self.numbers = [dict(zip(row, scaled, strict=False)) for row in self.rows]

    def _offer(self, i: int) -> None:
        for j in self.rows[i]:
            heappush(self.heap, (self._cost(i, j), i, j))

    def _cost(self, i: int, j: int) -> int:
        """Markowitz' count of possible new entries; a pivot that may vanish counts a little."""
        fill = (len(self.rows[i]) - 1) * (len(self.columns[j]) - 1)
        return 2 * fill + (self.rows[i][j] not in self.done.exact)

    def _is_large(self, i: int, j: int, threshold: float, spared: int) -> bool:
        """Whether the pivot is large beside its column, at all samples but so many."""
        pivots = [*map(abs, self.numbers[i][j])]
        # Nothing is large beside what is not a number.
        large = [p > SMALLEST for p in pivots]
        for k in self.columns[j]:
            if k != i:
                told = zip(large, pivots, self.numbers[k][j], strict=True)
                large = [known and p >= threshold * abs(other) for known, p, other in told]
        return large.count(False) <= spared

    def _eliminate(self, i: int, j: int) -> None:
        row = self.rows[i]
        inverse = self.done.inverse(row.pop(j))
        self.order.append((i, j, inverse))
        others = [k for k in self.columns.pop(j) if k != i]
        for k in row:
            del self.columns[k][i]
        for k in others:
            self._subtract(k, j, i, inverse)
        for k in others:
            self._offer(k)

    def _subtract(self, i: int, j: int, pivot_row: int, inverse: int) -> None:
        """Take the pivot's row from row i, so that unknown j vanishes from it."""
        done, target, numbers = self.done, self.rows[i], self.numbers[i]
        factor = done.sum(_ZERO, target.pop(j), inverse) ^ 1
        beside = self.numbers[pivot_row]
        # A sample whose pivot is 0 was spared: it has no numbers from here on.
        pairs = zip(numbers.pop(j), beside[j], strict=True)
        ratio = [a / b if b else math.nan for a, b in pairs]
        none = [0.0] * len(ratio)
        for k, e in self.rows[pivot_row].items():
            new = done.sum(target.get(k, _ZERO), factor, e)
            self.products += 1
            if new & -2 != _ZERO:
                target[k] = new
                known = zip(numbers.get(k, none), ratio, beside[k], strict=True)
                numbers[k] = [a - r * b for a, r, b in known]
                self.columns[k][i] = None
            elif k in target:
                del target[k], numbers[k], self.columns[k][i]
        self.constants[i] = done.sum(self.constants[i], factor, self.constants[pivot_row])

    def substitute(self) -> list[int]:
        """The tears, backwards; of the other unknowns only those that they need."""
        needed = set(range(self.tears))
        for i, j, _ in self.order:
            if j in needed:
                needed.update(self.rows[i])
        found: dict[int, int] = {}
        for i, j, inverse in reversed(self.order):
            if j in needed:
                total = self.constants[i]
                for k, e in self.rows[i].items():
                    total = self.done.sum(total, e, found[k])
                found[j] = self.done.sum(_ZERO, total, inverse) ^ 1
        return [found[j] for j in range(self.tears)]


def _largest(groups: Indices, sizes: Values, count: int) -> Values:
    """The largest size of each group; 1 where there is none but 0."""
    found = np.zeros(count)
    np.maximum.at(found, groups, sizes)
    found[found == 0.0] = 1.0
    return found
