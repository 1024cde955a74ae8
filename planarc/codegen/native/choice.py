"""The choice of states at a start in machine code, in LLVM.

    pc_choose(frame, table, plan, room) -> flag     1 where too many candidates must be states

The rule is `solve.states.selector`, which says the same in Python: of each block that chooses its
states itself, the candidates that are determined are found by elimination with complete pivoting.
Plan and room are those of `planarc.ir.begin`; the Jacobians are those of the last evaluation.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.codegen.native.begin import Start, attempt, refuse, whole
from planarc.ir.begin import EQUAL, GIVE_WAY, MUST_STAY, Below, Own, Plan
from planarc.ir.newton import NEGLIGIBLE


def choice_functions() -> tuple[str, str]:
    return _choose(), _pivot()


@function("i32 pc_choose(ptr frame, ptr table, ptr plan, ptr room)", seldom=True)
def _choose(c: Code, frame: Value, table: Value, plan: Value, room: Value) -> None:
    s = Start(frame, table, plan, room)
    with c.loop(s.n) as i:
        s.kinds.store(whole(c, 0), i)
        s.solved.store(whole(c, 0), i)
    with c.loop(s.n) as k:  # a coordinate and its derivative are states together
        i = s.n - k - 1
        own, derivative = s.own(i, Own.KIND), s.own(i, Own.DERIVATIVE)
        kind = c.variable(c.select(own < MUST_STAY, own + s.held.load(INT, i), own), INT)
        with c.when(derivative >= 0):
            other = s.kinds.load(INT, derivative)
            kind.set(c.select(other > kind.get(), other, kind.get()))
        s.kinds.store(kind.get(), i)
    with c.loop(s.number(Plan.BLOCKS)) as k, c.when(s.block(k, Below.CHOOSES).equals(1)):
        first, m, n = (s.block(k, x) for x in (Below.FIRST, Below.ROWS, Below.TEARS))
        matrix = s.area.at(s.block(k, Below.JACOBIAN))
        most = c.variable(0.0)
        with c.loop(n) as j:
            total = c.variable(0.0)
            with c.loop(m) as i:
                entry = matrix.load(REAL, i * n + j)
                total.set(total.get() + entry * entry)
            size = c.call(REAL, "llvm.sqrt.f64", total.get())
            s.scales.store(size, first + j)
            most.set(c.largest(size, most.get()))
        with c.loop(n) as j:
            size = s.scales.load(REAL, first + j)
            part = c.select(size > most.get() * NEGLIGIBLE, 1.0 / size, 0.0)
            with c.loop(m) as i:
                s.units.store(matrix.load(REAL, i * n + j) * part, i * n + j)
        kinds, solved = s.kinds.at(first), s.solved.at(first)
        attempt(c, "pc_pivot", s.units, kinds, solved, s.numbers, s.row, m, n)
    c.give(0)


@function(
    "i32 pc_pivot(ptr a, ptr kinds, ptr solved, ptr done, ptr sizes, i64 m, i64 n)", seldom=True
)
def _pivot(
    c: Code, a: Value, kinds: Value, solved: Value, done: Value, sizes: Value, m: Value, n: Value
) -> None:
    """Columns to solve for, by elimination with complete pivoting."""
    with c.loop(m) as i:
        done.store(whole(c, 0), i)
    with c.loop(m):
        most, kind = c.variable(-1.0), c.variable(MUST_STAY, INT)
        with c.loop(n) as j:
            largest, left = c.variable(-1.0), solved.load(INT, j).equals(0)
            may = left & (kinds.load(INT, j) < MUST_STAY)
            with c.loop(m) as i, c.when(may & done.load(INT, i).equals(0)):
                largest.set(c.largest(c.absolute(a.load(REAL, i * n + j)), largest.get()))
            sizes.store(largest.get(), j)
            most.set(c.largest(largest.get(), most.get()))
        refuse(c, ~(most.get() >= 0.0))
        with c.loop(n) as j, c.when(sizes.load(REAL, j) >= most.get() * GIVE_WAY):
            own = kinds.load(INT, j)
            kind.set(c.select(own < kind.get(), own, kind.get()))
        most.set(-1.0)
        with c.loop(n) as j, c.when(kinds.load(INT, j).equals(kind.get())):
            most.set(c.largest(sizes.load(REAL, j), most.get()))
        column, pivot, best = c.variable(-1, INT), c.variable(0, INT), c.variable(-1.0)
        with c.loop(n) as j:
            enough = sizes.load(REAL, j) >= most.get() * (1 - EQUAL)
            with c.when(enough & kinds.load(INT, j).equals(kind.get()) & (column.get() < 0)):
                column.set(j)
        j = column.get()
        solved.store(whole(c, 1), j)
        with c.loop(m) as i, c.when(done.load(INT, i).equals(0)):
            size = c.absolute(a.load(REAL, i * n + j))
            with c.when(size > best.get()):
                pivot.set(i)
                best.set(size)
        row = a.at(pivot.get() * n)
        done.store(whole(c, 1), pivot.get())
        with c.loop(m) as i, c.when(done.load(INT, i).equals(0) & (best.get() > 0.0)):
            factor = a.load(REAL, i * n + j) / row.load(REAL, j)
            c.subtract(a.at(i * n), row, factor, n)
    c.give(0)
