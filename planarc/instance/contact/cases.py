"""The forces of one case of k touches, and how far they break an inequality.

    px_case(block, k) -> flag                by equations; 1 where these say the same twice
    px_misfit(block, k, noise) -> size       at most 1 for rounding alone
    px_pivot(a, right, order, n) -> flag     a system of equations, by the largest pivots

A problem stands in `Area.MATRIX` to `Area.SLACK`, its case in `Area.CASES`: whether each touch
is closed, then the way of each.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.instance.block import larger, whole
from planarc.instance.contact.access import arrays, zero
from planarc.instance.contact.area import Area
from planarc.solve.contact.problem import ALIKE, IDLE, ROUNDING, STICKS

#: The way of a touch that may stick or slide: its slip is zero.
FREE = 3


def case_functions() -> tuple[str, ...]:
    return _pivot(), _case(), _misfit()


def slides(way: Value) -> Value:
    return ~(way.equals(STICKS) | way.equals(IDLE) | way.equals(FREE))


@function("i32 px_pivot(ptr a, ptr right, ptr order, i64 n)")
def _pivot(c: Code, a: Value, right: Value, order: Value, n: Value) -> None:
    """The solution stands in `right`, of unknown order[i] at i."""
    with c.loop(n) as i:
        order.store(i, i)
    largest = c.variable(0.0)
    with c.loop(n) as k:
        most, row, column = c.variable(-1.0), c.variable(k, INT), c.variable(k, INT)
        with c.loop(n, k) as i, c.loop(n, k) as j:
            size = c.absolute(a.load(REAL, i * n + j))
            with c.when(size > most.get()):
                most.set(size)
                row.set(i)
                column.set(j)
        largest.set(larger(c, largest.get(), most.get()))
        with c.when(~(most.get() * ALIKE > largest.get()), leaves=True):
            c.give(1)
        r, s = row.get(), column.get()
        with c.loop(n) as j:
            _exchange(a, k * n + j, r * n + j, REAL)
        _exchange(right, k, r, REAL)
        with c.loop(n) as i:
            _exchange(a, i * n + k, i * n + s, REAL)
        _exchange(order, k, s, INT)
        with c.loop(n, k + 1) as i:
            part = a.load(REAL, i * n + k) / a.load(REAL, k * n + k)
            with c.loop(n, k + 1) as j:
                rest = a.load(REAL, i * n + j) - part * a.load(REAL, k * n + j)
                a.store(rest, i * n + j)
            right.store(right.load(REAL, i) - part * right.load(REAL, k), i)
    with c.loop(n) as back:
        k = n - back - 1
        total = c.variable(right.load(REAL, k))
        with c.loop(n, k + 1) as j:
            total.set(total.get() - a.load(REAL, k * n + j) * right.load(REAL, j))
        right.store(total.get() / a.load(REAL, k * n + k), k)
    c.give(0)


def _exchange(array: Value, one: Value, two: Value, type: str) -> None:
    a, b = array.load(type, one), array.load(type, two)
    array.store(b, one)
    array.store(a, two)


@function("i32 px_case(ptr m, i64 k)")
def _case(c: Code, m: Value, k: Value) -> None:
    a, b, mu, floor, cases, x, u, rows, system, right, order = arrays(
        m, Area.MATRIX, Area.GIVEN, Area.MU, Area.FLOOR, Area.CASES, Area.FORCES, Area.MOTION,
        Area.ROWS, Area.SYSTEM, Area.RIGHT, Area.ORDER,
    )  # fmt: skip
    wide, count = k * 2, c.variable(0, INT)

    def unknown(place: Value) -> None:
        rows.store(place, count.get())
        count.set(count.get() + 1)

    with c.loop(k) as i:
        closed, way = cases.load(INT, i).equals(1), cases.load(INT, k + i)
        low = floor.load(REAL, i)
        x.store(c.select(closed, zero(c), low), i)
        with c.when(closed):
            unknown(i)
        moves = slides(way) & ~closed
        rubs = zero(c) - c.real(way) * mu.load(REAL, i) * low
        x.store(c.select(moves, rubs, zero(c)), k + i)
        with c.when(way.equals(STICKS)):
            unknown(k + i)
    n = count.get()
    with c.loop(n) as p:
        row, total = rows.load(INT, p), c.variable(0.0)
        with c.loop(wide) as j:
            total.set(total.get() + a.load(REAL, row * wide + j) * x.load(REAL, j))
        right.store(zero(c) - b.load(REAL, row) - total.get(), p)
        with c.loop(n) as q:
            column = rows.load(INT, q)
            entry = c.variable(a.load(REAL, row * wide + column))
            with c.when(column < k):
                way = cases.load(INT, k + column)
                with c.when(slides(way)):
                    part = c.real(way) * mu.load(REAL, column)
                    across = a.load(REAL, row * wide + k + column)
                    entry.set(entry.get() - part * across)
            system.store(entry.get(), p * n + q)
    with c.when(~c.call(FLAG, "px_pivot", system, right, order, n).equals(0), leaves=True):
        c.give(1)
    with c.loop(n) as p:
        x.store(right.load(REAL, p), rows.load(INT, order.load(INT, p)))
    with c.loop(k) as i:
        way = cases.load(INT, k + i)
        with c.when(cases.load(INT, i).equals(1) & slides(way)):
            x.store(zero(c) - c.real(way) * mu.load(REAL, i) * x.load(REAL, i), k + i)
    with c.loop(wide) as i:
        total = c.variable(b.load(REAL, i))
        with c.loop(wide) as j:
            total.set(total.get() + a.load(REAL, i * wide + j) * x.load(REAL, j))
        u.store(total.get(), i)
    c.give(0)


def largest_of(c: Code, values: Value, count: Value, least: float = 0.0) -> Value:
    found = c.variable(least)
    with c.loop(count) as i:
        found.set(larger(c, found.get(), c.absolute(values.load(REAL, i))))
    return found.get()


@function("double px_misfit(ptr m, i64 k, double noise)")
def _misfit(c: Code, m: Value, k: Value, noise: Value) -> None:
    a, b, mu, floor, ways, cases, x, u = arrays(
        m, Area.MATRIX, Area.GIVEN, Area.MU, Area.FLOOR, Area.WAY, Area.CASES, Area.FORCES,
        Area.MOTION,
    )  # fmt: skip
    wide = k * 2
    effect = largest_of(c, a, wide * wide, 1e-300)
    force = larger(c, largest_of(c, x, wide, 1e-300) * ROUNDING, noise / effect)
    motion = larger(c, largest_of(c, b, wide, 1e-300) * ROUNDING, noise)
    worst = c.variable(0.0)

    def breaks(by: Value) -> None:
        worst.set(larger(c, by, worst.get()))

    with c.loop(k) as i:
        n, t, slip = x.load(REAL, i), x.load(REAL, k + i), u.load(REAL, k + i)
        way = cases.load(INT, k + i)
        breaks((floor.load(REAL, i) - n) / force)
        with c.when(cases.load(INT, i).equals(0)):
            breaks(zero(c) - u.load(REAL, i) / motion)
        sticks, free = way.equals(STICKS), ways.load(INT, i).equals(FREE)
        with c.when(sticks):
            breaks((c.absolute(t) - mu.load(REAL, i) * n) / force)
        with c.when(~sticks & free):
            with c.when(~way.equals(IDLE)):
                breaks(zero(c) - c.real(way) * slip / motion)
            with c.when(way.equals(IDLE) & (n > force)):
                breaks(c.absolute(slip) / motion)
    c.give(worst.get(), REAL)


def copy(c: Code, to: Value, source: Value, count: Value) -> None:
    c.run("px_copy", to, source, count)


def fill(c: Code, to: Value, value: Value, count: Value) -> None:
    with c.loop(count) as i:
        to.store(value, i)


def word_of(c: Code, bit: Value) -> Value:
    return c.select(bit, whole(c, 1), whole(c, 0))
