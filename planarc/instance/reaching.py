"""Points that a host asks for far from the last accepted one, in LLVM.

    px_hold(block)            the present point becomes the one that nonlinear blocks start from
    px_far(block) -> flag     1 where a loop has moved far, and not as its motion leads
    px_derive(block) -> flag  derivatives at the present time and states

A host takes long steps, or tells of none within an interval of its own. From so far a loop may be
closed in another way, or in none. Then the way is gone in parts, along a straight line of time and
states: each begins where the one before ended, and turns no angle of a loop by more than `REACH`,
unless that is what velocity and acceleration there lead to.

Example: two coupled four-bars, of whose steps a host tells each 0.04 s. Rods turn by 0.4 rad in
that time, their accelerations change by half, and from the point before no loop can be closed.

Promises:  derivatives hang on time, states and the accepted point alone. Where the way is shorter
           than that, and a loop can be closed, they are those of `pc_rhs`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import constant, plan
from planarc.instance.plan import Own, Table
from planarc.ir.frame import Number, Record
from planarc.ir.march import REACH

#: The least part of the way that is gone at once.
SMALLEST = 2.0**-10
#: An angle (rad) is where its motion leads, however far that is.
CLOSE = 0.1


def reaching_functions() -> tuple[str, ...]:
    return _hold(), _far(), _derive(), _reach()


@function("void px_hold(ptr m)")
def _hold(c: Code, m: Value) -> None:
    w, numbers, _, _ = open_frame(m)
    c.call(FLAG, "pc_accept", m, w.load(REAL))
    with c.when(plan(c, Table.LOOPS) > 0):
        near, slots = m.load(POINTER, Own.NEAR), numbers.at(Number.FIRST_STATE)
        with c.loop(plan(c, Table.STATES)) as i:
            near.store(w.load(REAL, slots.load(INT, i)), i)
    c.give()


@function("i32 px_far(ptr m)")
def _far(c: Code, m: Value) -> None:
    w, _, accepted, _ = open_frame(m)
    angles, total = constant(c, "px_angles"), _tears(c)
    h = w.load(REAL) - accepted.load(REAL, total * 3)
    with c.loop(angles.load(INT)) as i:
        pair = angles.at(i * 2)
        now, before = w.load(REAL, pair.load(INT, 1)), accepted.at(pair.load(INT, 2))
        value, bend = before.load(REAL), before.load(REAL, total * 2) * 0.5
        led = value + h * (before.load(REAL, total) + h * bend)
        far = c.absolute(now - value) > REACH
        with c.when(far & ~(c.absolute(now - led) < CLOSE), leaves=True):
            c.give(1)
    c.give(0)


@function("i32 px_derive(ptr m)")
def _derive(c: Code, m: Value) -> None:
    w, _, _, _ = open_frame(m)
    y, rates = m.load(POINTER, Own.Y), m.load(POINTER, Own.RATES)
    flag = c.variable(c.call(FLAG, "pc_rhs", m, w.load(REAL), y, rates), FLAG)
    with c.when(plan(c, Table.LOOPS) > 0):
        far = c.call(FLAG, "px_far", m)
        with c.when(~(flag.get().equals(0) & far.equals(0))):
            flag.set(c.call(FLAG, "px_reach", m))
    c.give(flag.get())


def _tears(c: Code) -> Value:
    """How many the accepted point has."""
    return Value(c, POINTER, "@pc_blocks").at(1).load(INT, Record.TOTAL)


@function("i32 px_reach(ptr m)", seldom=True)
def _reach(c: Code, m: Value) -> None:
    """By way of points between; what was accepted stays so."""
    w, _, accepted, _ = open_frame(m)
    n, y, near = plan(c, Table.STATES), m.load(POINTER, Own.Y), m.load(POINTER, Own.NEAR)
    total = _tears(c) * 3
    end = m.load(POINTER, Own.ROUTE)
    kept = end.at(n)
    first, last = accepted.load(REAL, total), w.load(REAL)
    c.run("px_copy", end, y, n)
    c.run("px_copy", kept, accepted, total + 1)
    gone, step, flag = c.variable(0.0), c.variable(0.5), c.variable(c.constant(1, FLAG), FLAG)
    again, behind = c.label(), c.label()
    c.enter(again)
    part = gone.get() + step.get()
    with c.loop(n) as i:
        a = near.load(REAL, i)
        y.store(a + part * (end.load(REAL, i) - a), i)
    rates = m.load(POINTER, Own.RATES)
    flag.set(c.call(FLAG, "pc_rhs", m, first + part * (last - first), y, rates))
    bad = ~(flag.get().equals(0) & c.call(FLAG, "px_far", m).equals(0))
    with c.when(bad):
        step.set(step.get() * 0.5)
        flag.set(c.select(flag.get().equals(0), c.constant(1, FLAG), flag.get()))
        c.leave(step.get() < SMALLEST, behind)
        c.jump(again)
    gone.set(part)
    c.leave(part >= 1.0, behind)
    c.call(FLAG, "pc_accept", m, w.load(REAL))
    rest = 1.0 - part
    step.set(c.select(step.get() < rest, step.get(), rest))
    c.jump(again)
    c.begin(behind)
    c.run("px_copy", accepted, kept, total + 1)
    c.run("px_copy", y, end, n)
    c.run("pc_states", m, last, y)
    c.give(flag.get())
