"""Gaussian elimination with many right sides, in LLVM.

    pc_eliminate(a, r, sizes, m, count, stride) -> flag      a*x = r, in place; x in r

Pivots are chosen by column, relative to the sizes of their rows. The flag is 1 where the matrix is
singular or not finite.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.ir.newton import SINGULAR


@function("i32 pc_eliminate(ptr a, ptr r, ptr sizes, i64 m, i64 count, i64 stride)")
def eliminate_function(
    c: Code, a: Value, r: Value, sizes: Value, m: Value, count: Value, stride: Value
) -> None:
    """Gaussian elimination with many right sides, in place: a*x = r, x in r.

    Rows of r are `stride` long, of which `count` numbers count.
    """
    with c.loop(m) as i:
        largest = c.variable(0.0)
        with c.loop(m) as k:
            largest.set(c.largest(largest.get(), c.absolute(a.load(REAL, i * m + k))))
        with c.when(~(largest.get() < 1e300) | largest.get().equals(0.0), leaves=True):
            c.give(1)
        sizes.store(largest.get(), i)
    with c.loop(m) as k:
        best, most = c.variable(k, INT), c.variable(0.0)
        with c.loop(m, k) as i:
            pivot = c.absolute(a.load(REAL, i * m + k)) / sizes.load(REAL, i)
            with c.when(pivot > most.get()):
                best.set(i)
                most.set(pivot)
        with c.when(~(most.get() > SINGULAR), leaves=True):
            c.give(1)
        p = best.get()
        with c.when(~p.equals(k)):
            _exchange(c, a.at(p * m), a.at(k * m), m)
            _exchange(c, r.at(p * stride), r.at(k * stride), count)
            _exchange(c, sizes.at(p), sizes.at(k), c.constant(1, INT))
        pivot_row = a.at(k * m)
        inverse = c.constant(1.0, REAL) / pivot_row.load(REAL, k)
        with c.loop(m, k + 1) as i:
            row = a.at(i * m)
            factor = row.load(REAL, k) * inverse
            with c.when(~factor.equals(0.0)):
                c.subtract(row.at(k + 1), pivot_row.at(k + 1), factor, m - k - 1)
                c.subtract(r.at(i * stride), r.at(k * stride), factor, count)
    with c.loop(m) as back:
        i = m - 1 - back
        row, right = a.at(i * m), r.at(i * stride)
        with c.loop(m, i + 1) as j:
            factor = row.load(REAL, j)
            with c.when(~factor.equals(0.0)):
                c.subtract(right, r.at(j * stride), factor, count)
        inverse = c.constant(1.0, REAL) / row.load(REAL, i)
        with c.loop(count) as j:
            right.store(right.load(REAL, j) * inverse, j)
    c.give(0)


def _exchange(c: Code, a: Value, b: Value, count: Value) -> None:
    with c.loop(count) as j:
        one, two = a.load(REAL, j), b.load(REAL, j)
        a.store(two, j)
        b.store(one, j)
