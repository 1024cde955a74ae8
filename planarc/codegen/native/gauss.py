"""Gaussian elimination of a block's unknowns, in LLVM.

    pc_solve(a, r, x, sizes, order, m) -> flag
        a*x = r. Pivots are compared relative to the sizes of their rows; of equal ones the first
        row's is taken. `order` tells which row each unknown was taken from; behind it is
        room for 2*m numbers more.
    pc_again(a, r, x, sizes, order, columns, chosen, m, n) -> flag
        the same in the order of the last time. The rows of a are n long, and the unknowns stand at
        `columns` where these are `chosen` (1), else first. It gives `DONE` and no solution where
        pivots would be chosen in another order today, where there is no solution, and for more
        unknowns than are eliminated in registers.

From one point of a motion to the next pivots seldom change. So `pc_again`, where nothing is
exchanged and nothing waits for a pivot to be found, gives the same bits in a third of the time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import reduce
from operator import and_

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.codegen.native.flags import DONE, MORE, NOT_FINITE, SMALL, UNSOLVED
from planarc.ir.newton import SINGULAR


def solve_functions(smalls: Iterable[int] = range(1, SMALL + 1)) -> tuple[str, ...]:
    """`smalls` are numbers of unknowns that are eliminated in registers."""
    return _solve(), _again(smalls)()


@function("i32 pc_solve(ptr a, ptr r, ptr x, ptr sizes, ptr order, i64 m)")
def _solve(c: Code, a: Value, r: Value, x: Value, sizes: Value, order: Value, m: Value) -> None:
    """Gaussian elimination in place. m^3/3 operations, and m*b^2 for a matrix of bandwidth b,
    whose zeros are skipped: `ends` of rows lie behind all that is not zero, and no row below
    `bottom` begins before the next column."""
    ends, lowest = order.at(m), order.at(m * 2)  # the last row that begins in each column
    with c.loop(m) as k:
        lowest.store(c.constant(0, INT), k)
    with c.loop(m) as i:
        row = a.at(i * m)
        largest, first, behind = c.variable(0.0), c.variable(0, INT), c.variable(0, INT)
        with c.loop(m) as k:
            entry = c.absolute(row.load(REAL, k))
            largest.set(c.largest(largest.get(), entry))
            with c.when(~entry.equals(0.0)):
                first.set(c.select(behind.get().equals(0), k, first.get()))
                behind.set(k + 1)
        # Sums with the right side are not finite when one of the two is not.
        size = largest.get()
        with c.when(~((size + c.absolute(r.load(REAL, i))) < 1e300), leaves=True):
            c.give(NOT_FINITE)
        with c.when(size.equals(0.0), leaves=True):
            c.give(UNSOLVED)
        sizes.store(size, i)
        x.store(size, i)  # exchanged with the rows
        order.store(i, i)
        ends.store(behind.get(), i)
        lowest.store(i, first.get())
    bottom = c.variable(0, INT)
    with c.loop(m) as k:
        bottom.set(_later(c, bottom.get(), lowest.load(INT, k)))
        below = bottom.get() + 1
        best = c.variable(k, INT)
        with c.loop(below, k + 1) as i:
            p = best.get()
            other = c.absolute(a.load(REAL, i * m + k)) * x.load(REAL, p)
            pivot = c.absolute(a.load(REAL, p * m + k)) * x.load(REAL, i)
            earlier = order.load(INT, i) < order.load(INT, p)
            with c.when((other > pivot) | (other.equals(pivot) & earlier)):
                best.set(i)
        p = best.get()
        pivot = c.absolute(a.load(REAL, p * m + k))
        with c.when(~(pivot > x.load(REAL, p) * SINGULAR), leaves=True):
            c.give(UNSOLVED)
        with c.when(~p.equals(k)):
            with c.loop(_later(c, ends.load(INT, p), ends.load(INT, k)), k) as j:
                _exchange(a, REAL, p * m + j, k * m + j)
            for array, kind in ((r, REAL), (x, REAL), (order, INT), (ends, INT)):
                _exchange(array, kind, p, k)
        pivot_row, end = a.at(k * m), ends.load(INT, k)
        inverse = 1.0 / pivot_row.load(REAL, k)
        pivot_row.store(inverse, k)
        with c.loop(below, k + 1) as i:
            row = a.at(i * m)
            factor = row.load(REAL, k) * inverse
            with c.when(~factor.equals(0.0)):
                c.subtract(row.at(k + 1), pivot_row.at(k + 1), factor, end - k - 1)
                r.store(r.load(REAL, i) - factor * r.load(REAL, k), i)
                ends.store(_later(c, ends.load(INT, i), end), i)
    with c.loop(m) as back:
        i = m - 1 - back
        total = c.variable(r.load(REAL, i))
        row, end = a.at(i * m), ends.load(INT, i)
        with c.loop(end - 1 - i) as past:  # the one found last comes last
            j = end - 1 - past
            total.set(total.get() - row.load(REAL, j) * x.load(REAL, j))
        x.store(total.get() * row.load(REAL, i), i)
    c.give(MORE)


def _later(c: Code, i: Value, j: Value) -> Value:
    return c.select(i > j, i, j)


def _exchange(a: Value, kind: str, i: Value, j: Value) -> None:
    one, two = a.load(kind, i), a.load(kind, j)
    a.store(two, i)
    a.store(one, j)


def _again(smalls: Iterable[int]) -> Callable[..., str]:
    @function(
        "i32 pc_again(ptr a, ptr r, ptr x, ptr sizes, ptr order, ptr columns, i64 chosen,"
        " i64 m, i64 n)"
    )
    def text(
        c: Code, a: Value, r: Value, x: Value, sizes: Value, order: Value, columns: Value,
        chosen: Value, m: Value, n: Value,
    ) -> None:  # fmt: skip
        some = chosen.equals(1)
        for small in smalls:
            with c.when(m.equals(small), leaves=True):
                places = [c.select(some, columns.load(INT, k), c.constant(k, INT))
                          for k in range(small)]  # fmt: skip
                _in_order(c, a, r, x, sizes, [order.load(INT, i) for i in range(small)], places, n)
        c.give(DONE)

    return text


def _in_order(
    c: Code, a: Value, r: Value, x: Value, sizes: Value, order: list[Value],
    columns: list[Value], n: Value,
) -> None:  # fmt: skip
    """Elimination in registers."""
    starts = [a.at(i * n) for i in order]
    rows = [[at.load(REAL, j) for j in columns] for at in starts]
    found, size, fits = in_order(c, rows, [r.load(REAL, i) for i in order], order)
    with c.when(~fits, leaves=True):
        c.give(DONE)
    for k, i in enumerate(order):
        x.store(found[k], k)
        sizes.store(size[k], i)
    c.give(MORE)


def in_order(
    c: Code, rows: list[list[Value]], right: list[Value], order: list[Value]
) -> tuple[list[Value], list[Value], Value]:
    """The solution with the pivots on the diagonal, the sizes of the rows, and whether these pivots
    are those that would be chosen. `rows` and `right` are changed; `order` tells where the rows
    stand."""
    m = len(order)
    # A number that is none may be lost here, but comes into a pivot or the solution.
    size = [reduce(lambda p, q: c.select(p > q, p, q), map(c.absolute, row)) for row in rows]
    fits = [s + c.absolute(b) < 1e300 for s, b in zip(size, right, strict=True)]
    inverse: list[Value] = []
    for k in range(m):
        pivot = c.absolute(rows[k][k])
        fits.append(pivot > size[k] * SINGULAR)
        for i in range(k + 1, m):
            here, there = pivot * size[i], c.absolute(rows[i][k]) * size[k]
            fits.append((there < here) | ((there <= here) & (order[k] < order[i])))
        inverse.append(1.0 / rows[k][k])
        for i in range(k + 1, m):
            factor = rows[i][k] * inverse[k]
            for j in range(k + 1, m):
                rows[i][j] = rows[i][j] - factor * rows[k][j]
            right[i] = right[i] - factor * right[k]
    found: dict[int, Value] = {}
    for k in reversed(range(m)):
        total = right[k]
        for j, known in found.items():
            total = total - rows[k][j] * known
        found[k] = total * inverse[k]
        fits.append(found[k].equals(found[k]))
    return [found[k] for k in range(m)], size, reduce(and_, fits)
