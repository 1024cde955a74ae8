"""Newton's method for conditions at the start, in LLVM.

    pc_root(frame, table, rows, wanted, out, m) -> flag
    pc_seek(frame, table, rows, wanted, out, m) -> flag    the same from farther away

solves m of the numbers that `differences` tells (at `rows`, less those of `wanted`) for the m
candidates of its `table`. The flag is 0 with the root in the workspace, 1 with nothing but other
values there. `out` holds what `pc_differences` writes, and behind it m*(m + 7) numbers.

`solve.start.newton` is the rule, and does the rest: matrices that are nearly singular, points where
a number is none, damping. `pc_root` is its ordinary case: whole steps, none of them long but along
straight lines, as of speeds, and each to a better point. `pc_seek` shortens and halves steps, too,
by the same rule, so that it finds the same root.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, Variable, function
from planarc.codegen.native.differences import HEAD, counts
from planarc.codegen.native.newton import open_frame
from planarc.ir.newton import (
    ENOUGH,
    LESS,
    LONGEST,
    MOST_HALVINGS,
    SMALL,
    SMALLEST_ROW,
    STRAIGHT,
)

#: Steps, more of which are no ordinary case; and of a search.
_STEPS, _SOUGHT = 12, 60
#: Size of a pivot of rows that are no longer than 1 from which a matrix is far from singular.
_REGULAR = 1e-6
_ARGUMENTS = "ptr frame, ptr table, ptr rows, ptr wanted, ptr out, i64 m"


class _Conditions:
    """The numbers, and the room for a step."""

    def __init__(
        self, frame: Value, table: Value, rows: Value, wanted: Value, out: Value, m: Value
    ) -> None:
        self.c, self.frame, self.table, self.m = frame.code, frame, table, m
        self.rows, self.wanted, self.out = rows, wanted, out
        self.w, *_ = open_frame(frame)
        moved, *others = counts(table)
        self.width = others[0] + others[1] + others[2]
        self.matrix = out.at((moved + 1) * self.width)
        self.right = self.matrix.at(m * m)
        self.change, self.sizes, self.before, self.order = (
            self.right.at(m * k) for k in range(1, 5)
        )
        self.slots = table.at(HEAD)

    def rest(self, i: Value) -> Value:
        """What is left of a condition."""
        row = self.rows.load(INT, i)
        return self.out.load(REAL, row) - self.wanted.load(REAL, row)

    def linearise(self) -> tuple[Value, Value]:
        """Matrix and right side here, scaled by rows; the sum of squares, and whether all vanish
        but for rounding (1). The function ends where a number is none."""
        c, m = self.c, self.m
        flag = c.call(FLAG, "pc_differences", self.frame, self.table, self.out)
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        total, vanish = c.variable(0.0), c.variable(1, INT)
        with c.loop(m) as i:
            r, size = self.rest(i), c.variable(0.0)
            with c.loop(m) as j:
                slope = self.out.load(REAL, (j + 1) * self.width + self.rows.load(INT, i))
                size.set(c.largest(size.get(), c.absolute(slope)))
                self.matrix.store(slope, i * m + j)
            with c.when(~(c.absolute(r) <= c.largest(size.get(), SMALLEST_ROW) * SMALL)):
                vanish.set(c.constant(0, INT))
            scale = c.largest(size.get(), 1.0)
            with c.loop(m) as j:
                self.matrix.store(self.matrix.load(REAL, i * m + j) / scale, i * m + j)
            self.right.store(r / scale, i)
            total.set(total.get() + r * r)
        return total.get(), vanish.get()

    def solve(self) -> Value:
        """The flag of the step to the root of the linear conditions."""
        given = self.matrix, self.right, self.change, self.sizes, self.order, self.m
        return self.c.call(FLAG, "pc_solve", *given)

    def measure(self, longest: Variable) -> None:
        """The step's largest part; the function ends where the matrix is nearly singular."""
        c, m = self.c, self.m
        longest.set(0.0)
        with c.loop(m) as j:
            d = c.absolute(self.change.load(REAL, j))
            # What stands on the diagonal are the inverses of the pivots.
            singular = c.absolute(self.matrix.load(REAL, j * m + j)) * _REGULAR > 1.0
            with c.when(~(d < 1e300) | singular, leaves=True):
                c.give(1)
            longest.set(c.largest(d, longest.get()))

    def keep(self) -> None:
        with self.c.loop(self.m) as j:
            self.before.store(self.w.load(REAL, self.slots.load(INT, j)), j)

    def go(self, part: Value | float) -> None:
        """From the kept point, by so much of the step."""
        with self.c.loop(self.m) as j:
            way = self.change.load(REAL, j) * part
            self.w.store(self.before.load(REAL, j) - way, self.slots.load(INT, j))

    def squares(self) -> Value:
        """The sum of squares here. The function ends where a number is none."""
        c = self.c
        flag = c.call(FLAG, "pc_point", self.frame, self.table, self.out)
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        total = c.variable(0.0)
        with c.loop(self.m) as i:
            r = self.rest(i)
            total.set(total.get() + r * r)
        return total.get()


@function(f"i32 pc_root({_ARGUMENTS})", seldom=True)
def root_function(
    c: Code, frame: Value, table: Value, rows: Value, wanted: Value, out: Value, m: Value
) -> None:
    f = _Conditions(frame, table, rows, wanted, out, m)
    least, longest, small = c.variable(1e300), c.variable(LONGEST), c.variable(0, INT)
    with c.loop(_STEPS):
        total, vanish = f.linearise()
        there = total.equals(0.0) | (small.get().equals(1) & (longest.get() < ENOUGH))
        far = longest.get() > LONGEST
        better = total < least.get() * c.select(far, STRAIGHT * STRAIGHT, LESS * LESS)
        with c.when(~better & small.get().equals(1)):  # only rounding is left
            f.go(0.0)
        with c.when(there | (~better & small.get().equals(1)), leaves=True):
            c.give(0)
        flag = f.solve()
        with c.when(~better | ~flag.equals(0), leaves=True):
            c.give(1)
        f.measure(longest)
        f.keep()
        f.go(1.0)
        least.set(total)
        small.set(vanish)
    c.give(1)


@function(f"i32 pc_seek({_ARGUMENTS})", seldom=True)
def seek_function(
    c: Code, frame: Value, table: Value, rows: Value, wanted: Value, out: Value, m: Value
) -> None:
    f = _Conditions(frame, table, rows, wanted, out, m)
    longest, small, done = c.variable(LONGEST), c.variable(0, INT), c.variable(0, INT)
    part, tries = c.variable(1.0), c.variable(0, INT)
    with c.loop(_SOUGHT):
        total, vanish = f.linearise()
        with c.when(
            total.equals(0.0) | (small.get().equals(1) & (longest.get() < ENOUGH)), leaves=True
        ):
            c.give(0)
        flag = f.solve()
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        f.measure(longest)
        f.keep()
        small.set(vanish)
        done.set(c.constant(0, INT))
        with c.when(longest.get() > LONGEST):
            f.go(1.0)
            with c.when(f.squares() < total * (STRAIGHT * STRAIGHT)):
                done.set(c.constant(1, INT))
            with c.when(done.get().equals(0)):
                shorter = LONGEST / longest.get()
                with c.loop(m) as j:
                    f.change.store(f.change.load(REAL, j) * shorter, j)
        part.set(1.0)
        tries.set(c.select(vanish.equals(1), c.constant(1, INT), c.constant(MOST_HALVINGS, INT)))
        with c.loop(tries.get()), c.when(done.get().equals(0)):
            f.go(part.get())
            less = 1.0 - part.get() * (1.0 - LESS)
            with c.when(f.squares() < total * less * less):
                done.set(c.constant(1, INT))
            part.set(part.get() * 0.5)
        with c.when(done.get().equals(0), leaves=True):
            f.go(0.0)
            c.give(c.select(vanish.equals(1), c.constant(0, FLAG), c.constant(1, FLAG)))
    c.give(1)
