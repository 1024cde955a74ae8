"""Forces and cases of touches, by complementarity, in LLVM.

    px_forces(block, k, noise) -> flag    a problem solved; 1 where it has no solution

What the problem is, in which order cases are tried, and when one is as good as a solution stands
in `solve.contact.problem`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.instance.block import larger, whole
from planarc.instance.contact.access import arrays, zero
from planarc.instance.contact.area import Area
from planarc.instance.contact.cases import FREE, copy, largest_of, word_of
from planarc.solve.contact.problem import (
    ATTEMPTS,
    IDLE,
    LOOSELY,
    MOST_AFTER,
    MOST_TRIED,
    ROUNDING,
    STICKS,
    UNEVEN,
)

#: The order in which ways are tried; those at the end of their sticking begin with the third.
_ORDER = (STICKS, IDLE, 1, -1, STICKS, IDLE)


def force_functions() -> tuple[str, ...]:
    return _consider(), _count(), _take(), _forces()


@function("double px_consider(ptr m, i64 k, double noise, double least)")
def _consider(c: Code, m: Value, k: Value, noise: Value, least: Value) -> None:
    """Keep the case that stands in `Area.CASES` where it is better than the best; how good the
    best is."""
    with c.when(~c.call(FLAG, "px_case", m, k).equals(0), leaves=True):
        c.give(least)
    off = c.call(REAL, "px_misfit", m, k, noise)
    with c.when(~(off < least), leaves=True):
        c.give(least)
    pairs = arrays(m, Area.BEST_FORCES, Area.FORCES, Area.BEST_MOTION, Area.MOTION,
                   Area.BEST_CASES, Area.CASES)  # fmt: skip
    for to, source in zip(pairs[::2], pairs[1::2], strict=True):
        copy(c, to, source, k * 2)
    c.give(off)


@function("i64 px_cases(ptr m, i64 i)")
def _count(c: Code, m: Value, i: Value) -> None:
    """How many cases a touch has."""
    ways, floor = arrays(m, Area.WAY, Area.FLOOR)
    own = c.select(ways.load(INT, i).equals(FREE), whole(c, 4), whole(c, 1))
    c.give(own + c.select(floor.load(REAL, i) > 0.0, own, whole(c, 1)))


@function("void px_take(ptr m, i64 k, i64 i, i64 number)")
def _take(c: Code, m: Value, k: Value, i: Value, number: Value) -> None:
    """One of the cases of a touch, in the order in which they are tried."""
    ways, floor, slack, cases = arrays(m, Area.WAY, Area.FLOOR, Area.SLACK, Area.CASES)
    order = c.place(INT, len(_ORDER))
    for turn, tried in enumerate(_ORDER):
        order.store(whole(c, tried), turn)
    fixed = ways.load(INT, i)
    free, bears = fixed.equals(FREE), floor.load(REAL, i) > 0.0
    own = c.select(free, whole(c, 4), whole(c, 1))
    opened = c.select(bears, own, whole(c, 1))
    closed = number >= opened
    at = number - c.select(closed, opened, whole(c, 0))
    at = c.select(free, at, whole(c, 0))
    at = c.select(closed | bears, at, whole(c, 0))
    way = c.select(free, order.load(INT, at + slack.load(INT, i) * 2), fixed)
    cases.store(word_of(c, closed), i)
    cases.store(c.select(closed | bears, way, whole(c, IDLE)), k + i)
    c.give()


@function("i32 px_forces(ptr m, i64 k, double noise)")
def _forces(c: Code, m: Value, k: Value, noise: Value) -> None:
    a, b, ways, floor, x, u, cases, cover = arrays(
        m, Area.MATRIX, Area.GIVEN, Area.WAY, Area.FLOOR, Area.FORCES, Area.MOTION, Area.CASES,
        Area.COVER,
    )  # fmt: skip
    with c.when(k.equals(0), leaves=True):
        c.give(0)
    alone = k.equals(1) & ways.load(INT).equals(IDLE) & (a.load(REAL) > 0.0)
    with c.when(alone, leaves=True):
        low = floor.load(REAL)
        rounding = larger(c, largest_of(c, b, whole(c, 2)) * ROUNDING, noise)
        closed = a.load(REAL) * low + b.load(REAL) < zero(c) - rounding
        x.store(c.select(closed, zero(c) - b.load(REAL) / a.load(REAL), low))
        x.store(0.0, 1)
        for row in (0, 1):
            u.store(a.load(REAL, 2 * row) * x.load(REAL) + b.load(REAL, row), row)
        cases.store(word_of(c, closed))
        cases.store(whole(c, IDLE), 1)
        c.give(0)
    least, done = c.variable(LOOSELY), c.variable(0, INT)

    def consider() -> None:
        least.set(c.call(REAL, "px_consider", m, k, noise, least.get()))
        with c.when(least.get() <= 1.0):
            done.set(whole(c, 1))

    with c.when(k > MOST_TRIED):
        size = c.call(INT, "px_unknowns", m, k)
        with c.loop(ATTEMPTS) as attempt, c.when(done.get().equals(0)):
            with c.loop(size) as i:
                turn = c.real(attempt) * UNEVEN * c.real(i)
                cover.store(turn - c.real(c.whole(turn)) + 1.0, i)
            with c.when(c.call(FLAG, "px_lemke", m, size).equals(0)), c.loop(whole(c, 2)) as again:
                c.run("px_read", m, k, again + 1)
                with c.when(done.get().equals(0)):
                    consider()
        with c.when((least.get() < LOOSELY) | (k > MOST_AFTER)):
            done.set(whole(c, 1))
    total = c.variable(1, INT)
    with c.when(done.get().equals(1)):
        total.set(whole(c, 0))
    with c.when(done.get().equals(0)), c.loop(k) as i:
        total.set(total.get() * c.call(INT, "px_cases", m, i))
    with c.loop(total.get()) as number, c.when(done.get().equals(0)):
        rest = c.variable(number, INT)
        with c.loop(k) as back:
            i = k - back - 1
            own = c.call(INT, "px_cases", m, i)
            later = rest.get() / own
            c.run("px_take", m, k, i, rest.get() - later * own)
            rest.set(later)
        consider()
    with c.when(~(least.get() < LOOSELY), leaves=True):
        c.give(1)
    pairs = arrays(m, Area.BEST_FORCES, Area.FORCES, Area.BEST_MOTION, Area.MOTION,
                   Area.BEST_CASES, Area.CASES)  # fmt: skip
    for source, to in zip(pairs[::2], pairs[1::2], strict=True):
        copy(c, to, source, k * 2)
    c.give(0)
