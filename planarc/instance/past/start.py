"""The past before the start: every signal had its value at the start for ever.

px_begin_past(block, t) -> flag   delay times from the parameters; an empty past
px_known(block) -> 1              where the signals are those that the past holds; else it holds
                                  them from here on, and the start is to be solved once more
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.instance.block import larger, whole
from planarc.instance.past.kinks import is_near
from planarc.instance.past.layout import Each, Head, Past
from planarc.instance.plan import Own
from planarc.instance.settling import ACTED
from planarc.solve.events.crossings import AHEAD
from planarc.solve.events.delays import LONGEST_STEP, SETTLED

#: What a sequence has not changed by any more.
_STILL = 1e-14


def start_functions() -> tuple[str, ...]:
    return _begin(), _known()


@function("i32 px_begin_past(ptr m, double t)", seldom=True)
def _begin(c: Code, m: Value, t: Value) -> None:
    past = Past(c, m)
    interval, most = past.each(Each.INTERVAL), past.each(Each.MOST)
    longest, limit = c.variable(0.0), c.variable(1e300)
    c.run("px_intervals", m, interval, most)
    bend = m.load(REAL, Own.AHEAD) * (LONGEST_STEP / AHEAD)
    with c.loop(past.count) as d:
        own = interval.load(REAL, d)
        fixed = past.is_fixed(d)
        good = (own > 0.0) & (own < 1e300)
        with c.when(fixed & ~good, leaves=True):
            m.store(past.message(d), Own.ENDED)
            c.give(ACTED)
        longest.set(larger(c, longest.get(), c.select(fixed, own, most.load(REAL, d))))
        step = c.select(fixed, own, bend)
        limit.set(c.select(step < limit.get(), step, limit.get()))
        past.each(Each.LARGEST).store(0.0, d)
        past.each(Each.CROSSED).store(whole(c, 0), d)
        past.bounds.store(-1e300, d * 2)
        past.bounds.store(1e300, d * 2 + 1)
    past.head.store(longest.get(), Head.LONGEST)
    past.head.store(limit.get(), Head.LIMIT)
    past.head.store(whole(c, 0), Head.KINKS)
    past.head.store(whole(c, 0), Head.ROUNDS)
    last = past.each(Each.LAST)
    c.run("px_signals", m, last)
    with c.loop(past.count) as d:
        value = last.load(REAL, d)
        last.store(c.select((value - value).equals(0.0), value, 0.0), d)
    c.run("px_restart", m, t)
    c.give(0)


@function("i64 px_known(ptr m)", seldom=True)
def _known(c: Code, m: Value) -> None:
    """In every third round the limit is guessed: at once where the signals depend on the past in a
    line (Aitken's extrapolation)."""
    past = Past(c, m)
    now, last = past.values, past.each(Each.LAST)
    one, two = past.each(Each.ONE), past.each(Each.TWO)
    c.run("px_signals", m, now)
    same = c.variable(1, INT)
    with c.loop(past.count) as d:
        near = is_near(c, now.load(REAL, d), last.load(REAL, d), SETTLED)
        with c.when(~near):
            same.set(whole(c, 0))
    with c.when(same.get().equals(1), leaves=True):
        c.give(1, INT)
    turn = past.head.load(INT, Head.ROUNDS)
    with c.loop(past.count) as d:
        value = now.load(REAL, d)
        last.store(value, d)
        with c.when(turn.equals(2)):
            a, b = one.load(REAL, d), two.load(REAL, d)
            bend = (value - b) - (b - a)
            still = bend.equals(0.0) | is_near(c, value, b, _STILL)
            last.store(c.select(still, value, value - (value - b) * (value - b) / bend), d)
        with c.when(turn.equals(1)):
            two.store(value, d)
        with c.when(turn.equals(0)):
            one.store(value, d)
    following = turn + 1
    turned = c.emit(INT, f"select i1 {turn.equals(2).text}, i64 0, i64 {following.text}")
    past.head.store(turned, Head.ROUNDS)
    c.run("px_restart", m, past.real(Head.UNTIL))
    c.give(0, INT)
