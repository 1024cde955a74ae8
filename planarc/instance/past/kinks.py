"""Instants at which signals may jump: they come back when each delay has passed.

px_come_back(block) -> time       the next one, or the time up to which the past is known; hosts
                                  must not step beyond it
px_back(block, t) -> generation   of those that come back now, counted from 1; 0: none does
px_cross(block, t)                the past right behind an instant counts from here on
px_kink(block, t, generation, jumped) -> flag
                                  signals have jumped here, or may have lost their smoothness
px_left(block, t)                 note what comes back from before an event, and the signals
px_jumps(block, t) -> 1           where something else comes back behind it
px_jumped(block) -> 1             where signals are others behind it

Kinks where no signal jumped take up half of the room; others are left out. They set no bounds: the
past is interpolated across them, and the integrator meets them itself. There is room for as many
jumps as there are pieces of the past (`instance.past.pieces`), for each begins one.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.instance.block import larger, whole
from planarc.instance.instants import due
from planarc.instance.past.layout import Each, Head, Past
from planarc.instance.plan import Own, Told
from planarc.instance.relations import room
from planarc.instance.settling import ACTED
from planarc.solve.events.delays import GENERATIONS, JUMP


def kink_functions() -> tuple[str, ...]:
    return _come_back(), _back(), _cross(), _kink(), _left(), _jumps(), _jumped()


def _place(past: Past, number: Value) -> Value:
    """Where a kink stands, of as many as there is room for."""
    room = past.table.load(INT, Told.KINKS)
    return number - number / room * room


def _returns(c: Code, past: Past, d: Value) -> Value:
    """When the next kink of a delay comes back; 1e300 where none does."""
    number = past.each(Each.CROSSED).load(INT, d)
    some = past.is_fixed(d) & (number < past.head.load(INT, Head.KINKS))
    then = past.kinks.load(REAL, _place(past, number)) + past.each(Each.INTERVAL).load(REAL, d)
    return c.select(some, then, 1e300)


@function("double px_come_back(ptr m)")
def _come_back(c: Code, m: Value) -> None:
    past = Past(c, m)
    found = c.variable(past.real(Head.UNTIL) + past.real(Head.LIMIT))
    with c.loop(past.count) as d:
        then = _returns(c, past, d)
        found.set(c.select(then < found.get(), then, found.get()))
    c.give(found.get(), REAL)


@function("i64 px_back(ptr m, double t)")
def _back(c: Code, m: Value, t: Value) -> None:
    past = Past(c, m)
    crossed, limit, found = past.each(Each.CROSSED), due(c, t), c.variable(0, INT)
    with c.loop(past.count) as d:
        following, behind = c.label(), c.label()
        c.enter(following)
        number = crossed.load(INT, d)
        some = number < past.head.load(INT, Head.KINKS)  # at an endless time, too
        c.leave(~(some & (_returns(c, past, d) <= limit)), behind)
        age = past.generations().load(INT, _place(past, number)) + 1
        younger = found.get().equals(0) | (age < found.get())
        with c.when(younger):
            found.set(age)
        crossed.store(number + 1, d)
        c.jump(following)
        c.begin(behind)
    c.give(found.get())


@function("void px_cross(ptr m, double t)")
def _cross(c: Code, m: Value, t: Value) -> None:
    past = Past(c, m)
    c.call(INT, "px_back", m, t)
    crossed, within = past.each(Each.CROSSED), room(c, t) * 2.0
    with c.loop(past.count) as d, c.when(past.is_fixed(d)):
        number = crossed.load(INT, d)
        least = c.variable(t - past.each(Each.INTERVAL).load(REAL, d))
        with c.when(number > 0):
            last = past.kinks.load(REAL, _place(past, number - 1))
            least.set(larger(c, least.get(), last))
        past.bounds.store(least.get() + within, d * 2)
        some = number < past.head.load(INT, Head.KINKS)
        following = past.kinks.load(REAL, _place(past, number)) - within
        past.bounds.store(c.select(some, following, 1e300), d * 2 + 1)
    c.give()


@function("i32 px_kink(ptr m, double t, i64 generation, i64 jumped)")
def _kink(c: Code, m: Value, t: Value, generation: Value, jumped: Value) -> None:
    past = Past(c, m)
    count, room = past.head.load(INT, Head.KINKS), past.table.load(INT, Told.KINKS)
    crossed, oldest = past.each(Each.CROSSED), c.variable(count, INT)
    with c.loop(past.count) as d, c.when(past.is_fixed(d)):
        first = crossed.load(INT, d)
        oldest.set(c.emit(INT, f"select i1 {(first < oldest.get()).text}, i64 {first.text}, "
                               f"i64 {oldest.get().text}"))  # fmt: skip
    waiting = count - oldest.get()
    left_out = (generation >= GENERATIONS) | (jumped.equals(0) & (waiting * 2 >= room))
    full = waiting + 1 >= room  # the place of the last one that came back stays its own
    with c.when(~left_out & full, leaves=True):
        m.store(past.message(past.count), Own.ENDED)
        c.give(ACTED)
    with c.when(~left_out):
        past.kinks.store(t, _place(past, count))
        past.generations().store(generation, _place(past, count))
        past.head.store(count + 1, Head.KINKS)
    c.give(0)


@function("void px_left(ptr m, double t)")
def _left(c: Code, m: Value, t: Value) -> None:
    past = Past(c, m)
    with c.loop(past.count) as d, c.when(past.is_fixed(d)):
        then = t - past.each(Each.INTERVAL).load(REAL, d)
        past.each(Each.ONE).store(c.call(REAL, "pc_past", m, d, whole(c, 0), then), d)
    c.run("px_copy", past.each(Each.TWO), past.each(Each.LAST), past.count)
    c.give()


@function("i64 px_jumps(ptr m, double t)")
def _jumps(c: Code, m: Value, t: Value) -> None:
    past = Past(c, m)
    found = c.variable(0, INT)
    with c.loop(past.count) as d, c.when(past.is_fixed(d)):
        then = t - past.each(Each.INTERVAL).load(REAL, d)
        now = c.call(REAL, "pc_past", m, d, whole(c, 0), then)
        near = is_near(c, past.each(Each.ONE).load(REAL, d), now, JUMP)
        with c.when(~near):
            found.set(whole(c, 1))
    c.give(found.get())


@function("i64 px_jumped(ptr m)")
def _jumped(c: Code, m: Value) -> None:
    past = Past(c, m)
    before, now, found = past.each(Each.TWO), past.each(Each.LAST), c.variable(0, INT)
    with c.loop(past.count) as d, c.when(past.is_fixed(d)):
        near = is_near(c, before.load(REAL, d), now.load(REAL, d), JUMP)
        with c.when(~near):
            found.set(whole(c, 1))
    c.give(found.get())


def is_near(c: Code, a: Value, b: Value, part: float) -> Value:
    """Whether two values are the same but for a part of their size."""
    size = larger(c, larger(c, c.absolute(a), c.absolute(b)), 1.0)
    return c.absolute(a - b) <= size * part
