"""Newton's method for conditions at the start, in LLVM.

    pc_root(frame, table, rows, wanted, out, m) -> flag

solves m of the numbers that `differences` tells (at `rows`, less those of `wanted`) for the m
candidates of its `table`. The flag is 0 with the root in the workspace, 1 with nothing but other
values there.

It is the ordinary case of `solve.start.newton`, which does the rest: whole steps, none of them long
but along straight lines, as of speeds, and each to a better point, from matrices far from singular
ones. `out` holds what
`pc_differences` writes, and behind it m*(m + 7) numbers.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.codegen.native.differences import HEAD, counts
from planarc.codegen.native.newton import open_frame
from planarc.ir.newton import ENOUGH, LESS, LONGEST, SMALL, SMALLEST_ROW, STRAIGHT

#: Steps, more of which are no ordinary case.
_STEPS = 12
#: Size of a pivot of rows that are no longer than 1 from which a matrix is far from singular.
_REGULAR = 1e-6


@function("i32 pc_root(ptr frame, ptr table, ptr rows, ptr wanted, ptr out, i64 m)", seldom=True)
def root_function(
    c: Code, frame: Value, table: Value, rows: Value, wanted: Value, out: Value, m: Value
) -> None:
    w, _, _, _ = open_frame(frame)
    moved, *others = counts(table)
    width = others[0] + others[1] + others[2]
    matrix = out.at((moved + 1) * width)
    right = matrix.at(m * m)
    change, sizes, before, order = (right.at(m * k) for k in range(1, 5))
    slots = table.at(HEAD)
    least, longest, small = c.variable(1e300), c.variable(LONGEST), c.variable(0, INT)
    with c.loop(_STEPS):
        flag = c.call(FLAG, "pc_differences", frame, table, out)
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        total, vanish = c.variable(0.0), c.variable(1, INT)
        with c.loop(m) as i:
            row = rows.load(INT, i)
            r = out.load(REAL, row) - wanted.load(REAL, row)
            size = c.variable(0.0)
            with c.loop(m) as j:
                slope = out.load(REAL, (j + 1) * width + row)
                size.set(c.largest(size.get(), c.absolute(slope)))
                matrix.store(slope, i * m + j)
            with c.when(~(c.absolute(r) <= c.largest(size.get(), SMALLEST_ROW) * SMALL)):
                vanish.set(c.constant(0, INT))
            scale = c.largest(size.get(), 1.0)
            with c.loop(m) as j:
                matrix.store(matrix.load(REAL, i * m + j) / scale, i * m + j)
            right.store(r / scale, i)
            total.set(total.get() + r * r)
        there = total.get().equals(0.0) | (small.get().equals(1) & (longest.get() < ENOUGH))
        far = longest.get() > LONGEST
        better = total.get() < least.get() * c.select(far, STRAIGHT * STRAIGHT, LESS * LESS)
        with c.when(~better & small.get().equals(1)), c.loop(m) as j:  # only rounding is left
            w.store(before.load(REAL, j), slots.load(INT, j))
        with c.when(there | (~better & small.get().equals(1)), leaves=True):
            c.give(0)
        flag = c.call(FLAG, "pc_solve", matrix, right, change, sizes, order, m)
        with c.when(~better | ~flag.equals(0), leaves=True):
            c.give(1)
        longest.set(0.0)
        with c.loop(m) as j:
            d, slot = c.absolute(change.load(REAL, j)), slots.load(INT, j)
            # What stands on the diagonal are the inverses of the pivots.
            singular = c.absolute(matrix.load(REAL, j * m + j)) * _REGULAR > 1.0
            with c.when(~(d < 1e300) | singular, leaves=True):
                c.give(1)
            longest.set(c.largest(d, longest.get()))
            before.store(w.load(REAL, slot), j)
            w.store(w.load(REAL, slot) - change.load(REAL, j), slot)
        least.set(total.get())
        small.set(vanish.get())
    c.give(1)
