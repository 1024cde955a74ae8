"""Lemke's method for a linear complementarity problem, in LLVM.

    px_lemke(block, n) -> flag          from `Area.SPARSE`, `COVERED` (q) and `COVER`; 1: none found
    px_unknowns(block, k) -> n          the problem of k touches for it
    px_read(block, k, lets)             the case in which its unknowns in the basis are not zero;
                                        what has this for its `Area.SLACK` slides

    z = (n - floor of each; t forward, t backward, speed of each that may stick)

What the method does, and its source, stand in `solve.contact.lemke`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.instance.block import larger, whole
from planarc.instance.contact.access import arrays, zero
from planarc.instance.contact.area import Area
from planarc.instance.contact.cases import FREE, fill, largest_of, slides
from planarc.solve.contact.lemke import LEAST, MOST_PIVOTS
from planarc.solve.contact.problem import IDLE, STICKS


def lemke_functions() -> tuple[str, ...]:
    return _unknowns(), _first(), _lemke(), _read()


@function("i64 px_unknowns(ptr m, i64 k)")
def _unknowns(c: Code, m: Value, k: Value) -> None:
    a, b, mu, ways, floor, frees, matrix, right = arrays(
        m, Area.MATRIX, Area.GIVEN, Area.MU, Area.WAY, Area.FLOOR, Area.RUBBING, Area.SPARSE,
        Area.COVERED,
    )  # fmt: skip
    count, wide = c.variable(0, INT), k * 2
    with c.loop(k) as i, c.when(ways.load(INT, i).equals(FREE)):
        frees.store(i, count.get())
        count.set(count.get() + 1)
    f = count.get()
    size, backward, speed = k + f * 3, k + f, k + f * 2
    fill(c, matrix, zero(c), size * size)

    def motions(row: Value, source: Value, sign: float) -> None:
        """A row of the unknowns' effects on the motion `source`."""
        own, to = a.at(source * wide), matrix.at(row * size)
        total = c.variable(b.load(REAL, source))
        with c.loop(k) as i:
            way, part = ways.load(INT, i), c.variable(own.load(REAL, i))
            with c.when(slides(way)):
                across = c.real(way) * mu.load(REAL, i) * own.load(REAL, k + i)
                part.set(part.get() - across)
            to.store(part.get() * sign, i)
            total.set(total.get() + part.get() * floor.load(REAL, i))
        with c.loop(f) as j:
            across = own.load(REAL, k + frees.load(INT, j)) * sign
            to.store(across, k + j)
            to.store(zero(c) - across, backward + j)
        right.store(total.get() * sign, row)

    with c.loop(k) as i:
        motions(i, i, 1.0)
    with c.loop(f) as j:
        i = frees.load(INT, j)
        motions(k + j, k + i, 1.0)
        motions(backward + j, k + i, -1.0)
        for row in (k + j, backward + j):
            matrix.store(1.0, row * size + speed + j)
            matrix.store(-1.0, (speed + j) * size + row)
        matrix.store(mu.load(REAL, i), (speed + j) * size + i)
        right.store(mu.load(REAL, i) * floor.load(REAL, i), speed + j)
    c.give(size)


@function("i64 px_leaves(ptr m, i64 n, i64 entering)")
def _first(c: Code, m: Value, n: Value, entering: Value) -> None:
    """The row that reaches zero first; the cover's where it is among them; -1: none does."""
    table, basis = arrays(m, Area.TABLE, Area.BASIS)
    wide = n * 2 + 2

    def entry(row: Value, column: Value) -> Value:
        return table.load(REAL, row * wide + column)

    most, least = c.variable(1.0), c.variable(1e300)
    with c.loop(n) as i:
        most.set(larger(c, most.get(), c.absolute(entry(i, entering))))
    counts = most.get() * LEAST
    with c.loop(n) as i, c.when(entry(i, entering) > counts):
        ratio = entry(i, wide - 1) / entry(i, entering)
        least.set(c.select(ratio < least.get(), ratio, least.get()))
    limit = least.get() + larger(c, c.absolute(least.get()), 1.0) * LEAST
    found, done = c.variable(-1, INT), c.variable(0, INT)
    with c.loop(n) as i, c.when((entry(i, entering) > counts) & done.get().equals(0)):
        tied = entry(i, wide - 1) / entry(i, entering) <= limit
        before, lower = found.get(), c.variable(0, INT)
        with c.when(before.equals(-1)):
            lower.set(whole(c, 1))
        with c.when(tied & ~before.equals(-1)), c.loop(n) as j, c.when(lower.get().equals(0)):
            one = entry(i, j) / entry(i, entering)
            two = entry(before, j) / entry(before, entering)
            lower.set(c.select(one < two, whole(c, 1), whole(c, 0)))
            with c.when(one > two):
                lower.set(whole(c, -1))
        with c.when(tied & basis.load(INT, i).equals(n * 2)):
            lower.set(whole(c, 1))
            done.set(whole(c, 1))
        with c.when(tied & lower.get().equals(1)):
            found.set(i)
    c.give(found.get())


@function("i32 px_lemke(ptr m, i64 n)")
def _lemke(c: Code, m: Value, n: Value) -> None:
    matrix, q, cover, table, basis, basic = arrays(
        m, Area.SPARSE, Area.COVERED, Area.COVER, Area.TABLE, Area.BASIS, Area.BASIC
    )
    wide, behind = n * 2 + 2, n * 2
    least = c.variable(0.0)
    row, lowest = c.variable(0, INT), c.variable(1e300)
    fill(c, basic, whole(c, 0), n)
    with c.loop(n) as i:
        x = q.load(REAL, i)
        least.set(c.select(x < least.get(), x, least.get()))
        part = x / cover.load(REAL, i)
        with c.when(part < lowest.get()):
            lowest.set(part)
            row.set(i)
    with c.when(least.get() >= 0.0, leaves=True):
        c.give(0)
    size = largest_of(c, q, n)
    with c.loop(n) as i:
        own = table.at(i * wide)
        with c.loop(n) as j:
            own.store(c.select(i.equals(j), c.constant(1.0, REAL), 0.0), j)
            own.store(zero(c) - matrix.load(REAL, i * n + j), n + j)
        own.store(zero(c) - cover.load(REAL, i), behind)
        own.store(q.load(REAL, i) / size, behind + 1)
        basis.store(i, i)
    entering = c.variable(behind, INT)
    with c.loop(n * MOST_PIVOTS):
        pivot, column = table.at(row.get() * wide), entering.get()
        scale = pivot.load(REAL, column)
        with c.loop(wide) as j:
            pivot.store(pivot.load(REAL, j) / scale, j)
        with c.loop(n) as i, c.when(~i.equals(row.get())):
            own = table.at(i * wide)
            part = own.load(REAL, column)
            with c.when(~part.equals(0.0)), c.loop(wide) as j:
                own.store(own.load(REAL, j) - part * pivot.load(REAL, j), j)
        leaving = basis.load(INT, row.get())
        basis.store(column, row.get())
        with c.when(leaving.equals(behind), leaves=True):
            with c.loop(n) as i:
                b = basis.load(INT, i)
                with c.when(b >= n):
                    basic.store(whole(c, 1), b - n)
            c.give(0)
        entering.set(c.select(leaving < n, leaving + n, leaving - n))
        row.set(c.call(INT, "px_leaves", m, n, entering.get()))
        with c.when(row.get() < 0, leaves=True):
            c.give(1)
    c.give(1)


@function("void px_read(ptr m, i64 k, i64 lets)")
def _read(c: Code, m: Value, k: Value, lets: Value) -> None:
    ways, slack, basic, cases = arrays(m, Area.WAY, Area.SLACK, Area.BASIC, Area.CASES)
    f, j = c.variable(0, INT), c.variable(0, INT)
    with c.loop(k) as i, c.when(ways.load(INT, i).equals(FREE)):
        f.set(f.get() + 1)
    with c.loop(k) as i:
        cases.store(basic.load(INT, i), i)
        cases.store(ways.load(INT, i), k + i)
        with c.when(ways.load(INT, i).equals(FREE)):
            place = k + j.get()
            forward = basic.load(INT, place).equals(1)
            backward = basic.load(INT, place + f.get()).equals(1)
            moves = basic.load(INT, place + f.get() * 2).equals(1)
            j.set(j.get() + 1)
            one = c.select(forward, whole(c, -1), whole(c, 1))
            sticks = (forward & backward) | ~(moves | slack.load(INT, i).equals(lets))
            way = c.select(sticks, whole(c, STICKS), one)
            cases.store(c.select(forward | backward, way, whole(c, IDLE)), k + i)
    c.give()
