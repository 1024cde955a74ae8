"""The start of a run in its ordinary case, in LLVM.

    pc_begin(frame, table, given, plan, room) -> flag

puts a mechanism together with its start values held, and chooses its states: what
`solve.start.solve` and `solve.states.selector` do, in the same order and by the same rules, where
each of their questions has a plain answer. The flag is 1, with other values in the workspace, where
one has none, where Newton's method needs help, or where anything is to be told: then they do it.

    hold     which start values are held: where motions are free, and again where loops are closed
    close    one level of conditions (`root`), where it ends beside what was meant (`start.branch`)
    judge    dead centres (`start.singular`), dependent rows (`start.redundancy`)
    choose   which candidates are determined (`choice`)

Plan and room are those of `planarc.ir.begin`; `table` has all conditions by all candidates, `given`
the conditions alone, with everything else evaluated (`differences`).
"""

from __future__ import annotations

from math import pi
from sys import float_info

from planarc.codegen.native.assembly import BIT, FLAG, INT, REAL, Code, Value, function
from planarc.codegen.native.differences import HEAD, counts
from planarc.codegen.native.newton import open_frame
from planarc.ir.begin import (
    CLOSED,
    GUIDE,
    INDEPENDENT,
    LEVEL,
    NEAR,
    OPEN,
    OTHER,
    ROUNDING,
    SUSPECT,
    TOLD,
    WRITTEN,
    Below,
    Own,
    Plan,
)
from planarc.ir.newton import SMALL, SMALLEST_ROW

#: What Newton's method leaves of residuals without unknowns.
_NOTHING = SMALL * SMALLEST_ROW
#: What is larger must be so beyond what the order of additions changes.
_SURELY = 1 + 1e-9


def begin_functions() -> tuple[str, ...]:
    closing = _hold(), _close(), _meant(), _still()
    return _begin(), *closing, _judge(), _independent()


class Start:
    """The plan and the room of a start by names."""

    def __init__(self, frame: Value, table: Value, plan: Value, room: Value) -> None:
        self.w, _, _, self.area = open_frame(frame)
        self.n, self.first, _, self.fixed = counts(table)
        self.rows = self.first + self.fixed
        self.slots, self.plan = table.at(HEAD), plan
        n = self.n
        self.held, self.solved, self.scales, self.starts, self.values = (
            room.at(n * k) for k in range(TOLD)
        )
        rest = room.at(n * TOLD)
        self.columns, self.numbers, self.kinds, self.wanted, self.row = (
            rest.at(n * k) for k in range(5)
        )
        self.table = rest.at(n * 5)  # of a level
        self.motions = self.table.at(n * 2 + HEAD)
        self.units = self.motions.at(n * n)
        self.out = self.units.at(n * n)

    def number(self, name: int) -> Value:
        return self.plan.load(INT, name)

    def own(self, candidate: Value, name: int) -> Value:
        kind = REAL if name == Own.WEIGHT else INT
        return self.plan.at(self.number(Plan.OWN) + candidate * Own.COUNT).load(kind, name)

    def block(self, number: Value, name: int) -> Value:
        return self.plan.at(self.number(Plan.BELOW) + number * Below.COUNT).load(INT, name)

    def value(self, candidate: Value) -> Value:
        return self.w.load(REAL, self.slots.load(INT, candidate))

    def start(self, candidate: Value) -> Value:
        return self.w.load(REAL, self.own(candidate, Own.START))

    def is_held(self, candidate: Value) -> Value:
        return self.held.load(INT, candidate).equals(1)


def whole(c: Code, number: int) -> Value:
    return c.constant(number, INT)


def refuse(c: Code, condition: Value) -> None:
    with c.when(condition, leaves=True):
        c.give(1)


def attempt(c: Code, name: str, *arguments: Value) -> None:
    refuse(c, ~c.call(FLAG, name, *arguments).equals(0))


def _product(c: Code, a: Value, b: Value, n: Value) -> Value:
    total = c.variable(0.0)
    with c.loop(n) as i:
        total.set(total.get() + a.load(REAL, i) * b.load(REAL, i))
    return total.get()


def _is_above(c: Code, s: Start, row: Value, limit: float) -> Value:
    """Whether a residual is larger, or no number."""
    return ~(c.absolute(s.row.load(REAL, row) - s.wanted.load(REAL, row)) <= limit)


@function("i32 pc_begin(ptr frame, ptr table, ptr given, ptr plan, ptr room)", seldom=True)
def _begin(c: Code, frame: Value, table: Value, given: Value, plan: Value, room: Value) -> None:
    s = Start(frame, table, plan, room)
    free = s.number(Plan.FREE)
    with c.loop(s.n) as i:
        s.held.store(free, i)
        s.wanted.store(0.0, i)
        start = s.start(i)
        s.starts.store(start, i)
        s.w.store(start, s.slots.load(INT, i))
    starts = plan.at(s.number(Plan.WANTED))
    with c.loop(s.fixed) as k:
        s.wanted.store(s.w.load(REAL, starts.load(INT, k)), s.first + k)
    with c.when(free.equals(0)):
        attempt(c, "pc_hold", frame, table, plan, room, whole(c, 0))
        at = c.variable(s.number(Plan.LEVEL), INT)
        with c.loop(s.number(Plan.LEVELS)):
            level = plan.at(at.get())
            attempt(c, "pc_close", frame, table, given, plan, level, room)
            at.set(at.get() + level.load(INT))
        with c.when(s.number(Plan.TOGETHER).equals(1)):
            attempt(c, "pc_point", frame, given, s.row)
            with c.loop(s.rows) as i:
                refuse(c, _is_above(c, s, i, _NOTHING))
        attempt(c, "pc_hold", frame, table, plan, room, whole(c, 1))
    attempt(c, "pc_point", frame, given, s.row)
    attempt(c, "pc_judge", frame, table, plan, room)
    c.give(c.call(FLAG, "pc_choose", frame, table, plan, room))


@function("i32 pc_hold(ptr frame, ptr table, ptr plan, ptr room, i64 again)", seldom=True)
def _hold(c: Code, frame: Value, table: Value, plan: Value, room: Value, again: Value) -> None:
    """The first that ask to be held must be independent, as many as there are free motions."""
    s = Start(frame, table, plan, room)
    part = c.constant(CLOSED, REAL)
    rank = c.wide(c.call(FLAG, "pc_motions", frame, table, s.out, s.motions, part))
    count, known = s.n - rank, c.variable(0, INT)
    with c.loop(s.n) as i:
        known.set(known.get() + s.held.load(INT, i))
    refuse(c, (rank < 0) | (again.equals(1) & ~known.get().equals(count)))
    refuse(c, (count > s.number(Plan.ASKED)) | (s.number(Plan.FIXED) > count))
    asking, motions = plan.at(s.number(Plan.ASKING)), s.motions.at(rank * s.n)
    row = s.out  # nobody reads any more what stood there
    with c.loop(count) as k:
        item, unit = asking.load(INT, k), s.units.at(k * s.n)
        refuse(c, item < 0)
        with c.loop(count) as j:
            row.store(motions.load(REAL, j * s.n + item), j)
            unit.store(row.load(REAL, j), j)
        with c.loop(k) as i:
            other = s.units.at(i * s.n)
            c.subtract(unit, other, _product(c, row, other, count), count)
        length = c.call(REAL, "llvm.sqrt.f64", _product(c, unit, unit, count))
        refuse(c, ~(length > INDEPENDENT * _SURELY))
        with c.loop(count) as j:
            unit.store(unit.load(REAL, j) / length, j)
        s.held.store(whole(c, 1), item)
    c.give(0)


@function(
    "i32 pc_close(ptr frame, ptr table, ptr given, ptr plan, ptr level, ptr room)", seldom=True
)
def _close(
    c: Code, frame: Value, table: Value, given: Value, plan: Value, level: Value, room: Value
) -> None:
    s = Start(frame, table, plan, room)
    columns, rows, last = c.variable(0, INT), c.variable(0, INT), c.variable(-1, INT)
    written = c.variable(0, INT)
    single = c.variable(1, INT)  # speeds: there is one root
    with c.loop(level.load(INT, 1)) as k:
        block, before = level.load(INT, k + LEVEL), columns.get()
        first, row, count = (s.block(block, x) for x in (Below.FIRST, Below.ROW, Below.ROWS))
        end, known = first + s.block(block, Below.TEARS), written.get()
        with c.loop(end, first) as i, c.when(~s.is_held(i)):
            s.columns.store(i, columns.get())
            s.table.store(s.slots.load(INT, i), columns.get() + HEAD)
            columns.set(columns.get() + 1)
            with c.when(s.own(i, Own.WEIGHT).equals(WRITTEN)):
                written.set(written.get() + 1)
        told = c.select(written.get() > known, whole(c, 1), whole(c, 0))
        with c.loop(end, first) as i:
            s.kinds.store(told, i)
        with c.loop(row + count, row) as i:
            s.numbers.store(i, rows.get())
            rows.set(rows.get() + 1)
            last.set(i)
        square = (columns.get() - before).equals(count)
        with c.when((count > 0) & ~(s.block(block, Below.LINEAR).equals(1) & square)):
            single.set(whole(c, 0))
    fixed = level.at(level.load(INT, 1) + LEVEL)
    with c.loop(level.load(INT, 2)) as k:
        s.numbers.store(fixed.load(INT, k), rows.get())
        rows.set(rows.get() + 1)
        single.set(whole(c, 0))
    m, done, open_ = columns.get(), c.label(), c.variable(0, INT)
    strong = level.load(INT, 4)
    agreeing = (written.get() + strong > 0) & (written.get() < m)
    refuse(c, agreeing | ~rows.get().equals(m))
    with c.when(last.get().equals(s.first - 1)):
        attempt(c, "pc_point", frame, given, s.row)
        with c.loop(m) as k, c.when(_is_above(c, s, s.numbers.load(INT, k), _NOTHING)):
            open_.set(whole(c, 1))
        c.leave((m > 0) & open_.get().equals(0), done)
    s.table.store(table.load(INT))
    s.table.store(m, 1)
    with c.loop(s.rows + 3) as i:  # the other counts, places of the residuals, slots of the fixed
        there = c.select(i < 3, i + 2, m + HEAD + i - 3)
        s.table.store(table.load(INT, c.select(i < 3, i + 2, s.n + HEAD + i - 3)), there)
    attempt(c, "pc_root", frame, s.table, s.numbers, s.wanted, s.out, m)
    attempt(c, "pc_point", frame, given, s.row)
    with c.when((m > 0) & single.get().equals(0)):
        attempt(c, "pc_meant", frame, table, plan, level, room, m)
    attempt(c, "pc_still", frame, table, plan, room)
    c.enter(done)
    c.give(0)


@function("i32 pc_meant(ptr frame, ptr table, ptr plan, ptr level, ptr room, i64 m)", seldom=True)
def _meant(
    c: Code, frame: Value, table: Value, plan: Value, level: Value, room: Value, m: Value
) -> None:
    """Written values, or defaults in loops without written ones, have stayed near, and no angle
    could be turned back."""
    s = Start(frame, table, plan, room)
    distance, least = c.variable(0.0), c.variable(1e300)

    def guide(value: Value, start: Value, weight: Value, counts: Value) -> None:
        way = value - start
        counts = weight.equals(WRITTEN) | (counts & level.load(INT, 4).equals(0))
        refuse(c, counts & ~weight.equals(OTHER) & ~(c.absolute(way) <= NEAR))
        distance.set(distance.get() + weight * (way * way))
        least.set(c.select(weight < least.get(), weight, least.get()))

    with c.loop(m) as k:
        i = s.columns.load(INT, k)
        guide(s.value(i), s.start(i), s.own(i, Own.WEIGHT), s.kinds.load(INT, i).equals(0))
    others = level.at(level.load(INT, 1) + level.load(INT, 2) + LEVEL)
    with c.loop(level.load(INT, 3)) as k:
        other = others.at(k * GUIDE)
        value, start = (s.w.load(REAL, other.load(INT, place)) for place in (0, 1))
        guide(value, start, other.load(REAL, 2), c.constant(1, BIT))
    refuse(c, ~(distance.get() < least.get() * pi**2))
    c.give(0)


@function("i32 pc_still(ptr frame, ptr table, ptr plan, ptr room)", seldom=True)
def _still(c: Code, frame: Value, table: Value, plan: Value, room: Value) -> None:
    """What has moved by rounding alone is at its start value (`solve.start.assembly`)."""
    s = Start(frame, table, plan, room)
    some = c.variable(0, INT)
    with c.loop(s.n) as j:
        now, before = s.value(j), s.start(j)
        rounding = c.largest(c.absolute(before), 1.0) * ROUNDING
        beside = ~now.equals(before) & (c.absolute(now - before) <= rounding)
        s.kinds.store(c.select(beside, whole(c, 1), whole(c, 0)), j)
        some.set(c.select(beside, whole(c, 1), some.get()))
    with c.when(some.get().equals(0), leaves=True):
        c.give(0)
    attempt(c, "pc_differences", frame, table, s.out)
    with c.loop(s.rows) as i:
        rest = s.out.load(REAL, i) - s.wanted.load(REAL, i)
        terms, largest = c.variable(0.0), c.variable(0.0)
        with c.loop(s.n) as j:
            size = c.absolute(s.out.load(REAL, (j + 1) * s.rows + i))
            terms.set(terms.get() + size * c.absolute(s.value(j)))
            largest.set(c.largest(size, largest.get()))
        least = c.largest(c.absolute(rest), terms.get() * (4 * float_info.epsilon))
        least = c.largest(least, largest.get() * SMALL**2)
        with c.loop(s.n) as j:
            slope = s.out.load(REAL, (j + 1) * s.rows + i)
            moved = c.absolute(rest + slope * (s.start(j) - s.value(j)))
            with c.when(~(moved <= least)):
                s.kinds.store(whole(c, 0), j)
    with c.loop(s.n) as j, c.when(s.kinds.load(INT, j).equals(1)):
        s.w.store(s.start(j), s.slots.load(INT, j))
    c.give(0)


@function("i32 pc_judge(ptr frame, ptr table, ptr plan, ptr room)", seldom=True)
def _judge(c: Code, frame: Value, table: Value, plan: Value, room: Value) -> None:
    s = Start(frame, table, plan, room)
    total = c.variable(0.0)
    with c.loop(s.n) as i:
        rate = s.w.load(REAL, s.own(i, Own.RATE))
        s.values.store(s.value(i), i)
        total.set(total.get() + s.value(i) * 0.0 + rate * 0.0)
    refuse(c, ~total.get().equals(0.0))
    first = plan.at(s.number(Plan.LEVEL))
    second = first.at(first.load(INT))
    with c.when((s.number(Plan.LEVELS) > 1) & s.number(Plan.FREE).equals(0)):
        asked, others = c.variable(0.0), c.variable(0.0)
        with c.loop(second.load(INT, 1)) as k:
            block = second.load(INT, k + LEVEL)
            begin = s.block(block, Below.FIRST)
            with c.loop(begin + s.block(block, Below.TEARS), begin) as i:
                speed, held = c.absolute(s.value(i)), s.is_held(i)
                asked.set(c.select(held & (speed > asked.get()), speed, asked.get()))
                others.set(c.select(~held & (speed > others.get()), speed, others.get()))
        with c.when(asked.get() > 0):
            refuse(c, others.get() * INDEPENDENT > asked.get())
            with c.loop(first.load(INT, 1)) as k:
                block = first.load(INT, k + LEVEL)
                row = s.block(block, Below.ROW)
                with c.loop(row + s.block(block, Below.ROWS), row) as i:
                    refuse(c, _is_above(c, s, i, OPEN))
    with c.loop(s.number(Plan.BLOCKS)) as k, c.when(s.block(k, Below.JUDGED).equals(1)):
        matrix = s.area.at(s.block(k, Below.JACOBIAN))
        m, n = s.block(k, Below.ROWS), s.block(k, Below.TEARS)
        attempt(c, "pc_independent", matrix, s.units, m, n)
    c.give(0)


@function("i32 pc_independent(ptr rows, ptr units, i64 m, i64 n)", seldom=True)
def _independent(c: Code, rows: Value, units: Value, m: Value, n: Value) -> None:
    """Whether no singular value is suspect. Their product is that of the distances of each row from
    what those before it span; that of all but one is the largest where these are equal."""
    squares, volume = c.variable(0.0), c.variable(1.0)
    with c.loop(m) as k:
        row, unit = rows.at(k * n), units.at(k * n)
        squares.set(squares.get() + _product(c, row, row, n))
        with c.loop(n) as j:
            unit.store(row.load(REAL, j), j)
        with c.loop(k) as i:
            other = units.at(i * n)
            c.subtract(unit, other, _product(c, unit, other, n), n)
        length = c.call(REAL, "llvm.sqrt.f64", _product(c, unit, unit, n))
        refuse(c, ~(length > 0.0))
        with c.loop(n) as j:
            unit.store(unit.load(REAL, j) / length, j)
        volume.set(volume.get() * length)
    largest = c.largest(c.call(REAL, "llvm.sqrt.f64", squares.get()), 1.0)
    mean = c.call(REAL, "llvm.sqrt.f64", squares.get() / c.largest(c.real(m - 1), 1.0))
    least = c.variable(largest * SUSPECT * _SURELY)
    with c.loop(m, 1):
        least.set(least.get() * mean)
    c.give(c.select(volume.get() > least.get(), c.constant(0, FLAG), c.constant(1, FLAG)))
