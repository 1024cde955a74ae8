"""What touches of an exported model read, and what forces at them do, in LLVM.

    px_see(block, t) -> flag               everything evaluated at the states; `Area.NOW`
    px_put(block, which, value)            the same value for all touches
    px_respond(block, t, k) -> flag        the effect of forces at closed touches, all being open
    px_press(block, t, count) -> flag      what presses while `Area.FORCES` act at `Area.LIST`
    px_shift(block, k, count, x) -> flag   states that impulses at `Area.LIST` change; 1: no numbers

Of the model's own is `px_feel(block, t, out)`, which reads (`instance.touches`).
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import larger, plan, whole
from planarc.instance.contact.access import arrays, kept, seen, slot, touches, zero
from planarc.instance.contact.area import Area, Kept, Reads, Seen
from planarc.instance.contact.cases import copy, fill, largest_of
from planarc.instance.plan import Own, Table, Touch
from planarc.instance.relations import attempt
from planarc.ir.frame import Frame, Number
from planarc.solve.contact.problem import IDLE
from planarc.solve.contact.touches import SEEN


def touch_functions() -> tuple[str, ...]:
    return _see(), _put(), _motion(), _respond(), _press(), _shift()


def read_of(c: Code, array: Value, which: Reads | int) -> Value:
    """One of the arrays in `Area.NOW` or `Area.BEFORE`."""
    return array.at(touches(c) * int(which))


def before_of(c: Code, array: Value, which: Touch | Reads) -> Value:
    """An array of `Area.BEFORE`."""
    behind = len(Reads) if isinstance(which, Touch) else 0
    return read_of(c, array, behind + int(which))


@function("i32 px_see(ptr m, double t)", seldom=True)
def _see(c: Code, m: Value, t: Value) -> None:
    attempt(c, "pc_outputs", m, t, m.load(POINTER, Own.Y))
    (now,) = arrays(m, Area.NOW)
    c.run("px_feel", m, t, now)
    c.give(0)


@function("void px_put(ptr m, i64 which, double value)", seldom=True)
def _put(c: Code, m: Value, which: Value, value: Value) -> None:
    w, table = m.load(POINTER, Frame.W), Value(c, POINTER, "@px_touches")
    with c.loop(touches(c)) as i:
        w.store(value, table.load(INT, i * len(Touch) + which))
    c.give()


def put(c: Code, m: Value, which: Touch, value: float) -> None:
    c.run("px_put", m, whole(c, which), c.constant(value, REAL))


@function("void px_motion(ptr m, ptr out)")
def _motion(c: Code, m: Value, out: Value) -> None:
    """Accelerations of all touches: normal, then slip."""
    n = touches(c)
    (now,) = arrays(m, Area.NOW)
    copy(c, out, read_of(c, now, Reads.A), n)
    copy(c, out.at(n), read_of(c, now, Reads.A_SLIP), n)
    c.give()


@function("i32 px_respond(ptr m, double t, i64 k)", seldom=True)
def _respond(c: Code, m: Value, t: Value, k: Value) -> None:
    n, states, wide = touches(c), plan(c, Table.STATES), k * 2
    now, free, here, rates, before, response, motion = arrays(
        m, Area.NOW, Area.FREE, Area.HERE, Area.RATES, Area.FREE_RATES, Area.RESPONSE, Area.SUM
    )
    w, numbers, _, _ = open_frame(m)
    slots = numbers.at(states + int(Number.FIRST_STATE))
    force, most = kept(c, m, Kept.FORCE), seen(c, m, Seen.MOST)
    put(c, m, Touch.HELD, 0.0)
    put(c, m, Touch.WAY, float(IDLE))
    attempt(c, "px_see", m, t)
    c.run("px_motion", m, free)
    with c.loop(states) as s:
        before.store(w.load(REAL, slots.load(INT, s)), s)
    largest = largest_of(c, free, n * 2, 1.0)
    fill(c, response, zero(c), wide * wide)
    fill(c, rates, zero(c), states * wide)
    with c.loop(wide) as column:
        along = column >= k
        j = column - c.select(along, k, whole(c, 0))
        i = here.load(INT, j)
        place = i + c.select(along, n, whole(c, 0))
        push = c.select(along, slot(c, i, Touch.PUSH_T), slot(c, i, Touch.PUSH_N))
        rubs = ~read_of(c, now, Reads.MU).load(REAL, i).equals(0.0)
        done, effect = c.variable(0, INT), c.variable(0.0)
        with c.when(~along | rubs), c.loop(2), c.when(done.get().equals(0)):
            size = force.load(REAL, place)
            w.store(size, push)
            flag = c.call(FLAG, "px_see", m, t)
            c.run("px_motion", m, motion)
            effect.set(c.constant(0.0, REAL))
            with c.loop(n * 2) as r:
                change = (motion.load(REAL, r) - free.load(REAL, r)) / size
                motion.store(change, r)
                effect.set(larger(c, c.absolute(change), effect.get()))
            with c.loop(k) as r:
                at = here.load(INT, r)
                response.store(motion.load(REAL, at), r * wide + column)
                response.store(motion.load(REAL, n + at), (k + r) * wide + column)
            with c.loop(states) as s:
                rate = w.load(REAL, slots.load(INT, s))
                rates.store((rate - before.load(REAL, s)) / size, s * wide + column)
            w.store(0.0, push)
            with c.when(~flag.equals(0), leaves=True):
                c.give(1)
            clear = effect.get().equals(0.0) | (effect.get() * size > largest * SEEN)
            with c.when(clear):
                done.set(whole(c, 1))
            with c.when(~clear):
                force.store(largest / effect.get(), place)
        most.store(larger(c, effect.get(), most.load(REAL)))
    c.give(0)


@function("i32 px_press(ptr m, double t, i64 count)", seldom=True)
def _press(c: Code, m: Value, t: Value, count: Value) -> None:
    w = m.load(POINTER, Frame.W)
    now, here, listed, x, presses = arrays(
        m, Area.NOW, Area.HERE, Area.LIST, Area.FORCES, Area.PRESSES
    )
    with c.loop(count) as p:
        i = here.load(INT, listed.load(INT, p))
        w.store(x.load(REAL, p), slot(c, i, Touch.PUSH_N))
        w.store(x.load(REAL, count + p), slot(c, i, Touch.PUSH_T))
    flag = c.call(FLAG, "px_see", m, t)
    with c.loop(count) as p:
        i = here.load(INT, listed.load(INT, p))
        presses.store(read_of(c, now, Reads.F_N).load(REAL, i), p)
    put(c, m, Touch.PUSH_N, 0.0)
    put(c, m, Touch.PUSH_T, 0.0)
    c.give(flag)


@function("i32 px_shift(ptr m, i64 k, i64 count, ptr x)")
def _shift(c: Code, m: Value, k: Value, count: Value, x: Value) -> None:
    rates, listed = arrays(m, Area.RATES, Area.LIST)
    y, total, wide = m.load(POINTER, Own.Y), c.variable(0.0), k * 2
    with c.loop(plan(c, Table.STATES)) as s:
        own, change = rates.at(s * wide), c.variable(0.0)
        with c.loop(count) as p:
            j = listed.load(INT, p)
            normal = own.load(REAL, j) * x.load(REAL, p)
            along = own.load(REAL, k + j) * x.load(REAL, count + p)
            change.set(change.get() + normal + along)
        with c.when(~change.get().equals(0.0)):
            m.store(whole(c, 1), Own.MOVED)
        y.store(y.load(REAL, s) + change.get(), s)
    with c.loop(count * 2) as p:
        total.set(total.get() + x.load(REAL, p) * 0.0)
    c.give(c.select(total.get().equals(0.0), c.constant(0, FLAG), c.constant(1, FLAG)))
