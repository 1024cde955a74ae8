"""Instants known beforehand: when `sample` fires, and when relations of time alone switch.

    px_instants(block, t) -> flag   all of them, from the parameters
    px_next(block) -> time          the next one; 1e300 where there is none

Which relations are linear in time was found at export; when they switch follows from two values.

Reference: `solve.events.instants`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import larger, plan
from planarc.instance.plan import Own, Relation, Row, Sample, Table
from planarc.instance.relations import differs, numbers_of, room, told, truth

#: What lies no further ahead than this part of the time happens now: hosts stop so exactly.
DUE = 1e-11


def instant_functions(delayed: bool) -> tuple[str, ...]:
    return _instants(), _next(delayed)


def samples(c: Code, m: Value, which: Sample) -> Value:
    return m.load(POINTER, Own.SAMPLES).at(plan(c, Table.SAMPLES) * int(which))


def due(c: Code, t: Value) -> Value:
    """The latest instant that is treated at a time."""
    return t + larger(c, larger(c, c.absolute(t), c.constant(1.0, REAL)) * DUE, room(c, t))


def tick(c: Code, m: Value, k: Value) -> Value:
    """When a sampler fires next; 1e300 where it never does."""
    start, interval, ticks = (
        samples(c, m, which).load(REAL, k)
        for which in (Sample.START, Sample.INTERVAL, Sample.TICKS)
    )
    return c.select(interval > 0.0, start + ticks * interval, 1e300)


def switches(c: Code, m: Value, i: Value) -> Value:
    """Whether the instant of relation `i` is still to come."""
    after = numbers_of(c, m, Relation.AFTER).load(REAL, i).equals(1.0)
    return told(c, i, Row.TIMED).equals(1) & differs(c, truth(c, m, i), after)


@function("void px_instants(ptr m, double t)", seldom=True)
def _instants(c: Code, m: Value, t: Value) -> None:
    """The workspace holds the parameters."""
    c.run("px_samples", m, m.load(POINTER, Own.SAMPLES))
    interval, start, ticks = (
        samples(c, m, k) for k in (Sample.INTERVAL, Sample.START, Sample.TICKS)
    )
    with c.loop(plan(c, Table.SAMPLES)) as k:
        passed = (t - start.load(REAL, k)) / interval.load(REAL, k)
        near = passed - room(c, passed)
        count = c.call(REAL, "llvm.ceil.f64", near)
        ticks.store(c.select((interval.load(REAL, k) > 0.0) & (count > 0.0), count, 0.0), k)
    count = plan(c, Table.RELATIONS)
    one, two = (numbers_of(c, m, k) for k in (Relation.TRIAL, Relation.RISES))
    instant, after = (numbers_of(c, m, k) for k in (Relation.INSTANT, Relation.AFTER))
    with c.loop(count) as i:
        instant.store(0.0, i)
    # Far from zero the slope is known to few digits: look again where it ends.
    with c.loop(4) as turn, c.loop(count) as i, c.when(told(c, i, Row.TIMED).equals(1)):
        _straight(c, m, i, instant, after, one, two, turn)
    c.give()


def _straight(
    c: Code, m: Value, i: Value, instant: Value, after: Value, one: Value, two: Value, turn: Value
) -> None:
    """The zero of a line through two of its values; then once more by what is left there."""
    at = instant.load(REAL, i)
    c.call("i32", "pc_zeros", m, at, one)
    c.call("i32", "pc_zeros", m, at + 1.0, two)
    slope = two.load(REAL, i) - one.load(REAL, i)
    with c.when(turn.equals(0)):
        after.store(c.select(slope < 0.0, c.constant(1.0, REAL), 0.0), i)
    move = one.load(REAL, i) / slope
    found = at - c.select(slope.equals(0.0), c.constant(0.0, REAL), move)
    instant.store(c.select(c.absolute(found) < 1e300, found, 1e300), i)


@function("double px_next(ptr m)")
def _next(c: Code, m: Value, delayed: bool) -> None:
    found = c.variable(c.call(REAL, "px_come_back", m) if delayed else 1e300)
    with c.loop(plan(c, Table.SAMPLES)) as k:
        t = tick(c, m, k)
        found.set(c.select(t < found.get(), t, found.get()))
    w, _, _, _ = open_frame(m)
    now = w.load(REAL)
    with c.loop(plan(c, Table.RELATIONS)) as i, c.when(switches(c, m, i)):
        t = numbers_of(c, m, Relation.INSTANT).load(REAL, i)
        t = c.select(t < now, now, t)
        found.set(c.select(t < found.get(), t, found.get()))
    c.give(found.get(), REAL)
