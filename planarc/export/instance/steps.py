"""An integrator of the model's own, in LLVM: an explicit pair of order 5 and 4.

    px_advance(block, end) -> flag     to a time; 1 where no step leads on

A step ends at `end` exactly. What is accepted becomes the point that nonlinear blocks start
from; where the states go bad there, others are taken.

Reference: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6(1), 1980, 19-26.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.export.instance.block import hold, plan, whole
from planarc.export.plan import Own, Stale, Table
from planarc.ir.frame import Number

_NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_ROWS = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
#: The result of order 5 minus that of order 4.
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
_SAFETY, _LEAST, _MOST, _FAILED = 0.9, 0.2, 5.0, 0.25
#: First step of all, and steps below this part of the time are none.
_FIRST, _NONE = 1e-4, 1e-14


def step_functions() -> tuple[str, ...]:
    return _combine(), _stages(), _error(), _advance()


@function("void px_combine(ptr m, double h, ptr weights, i64 count, ptr out)")
def _combine(c: Code, m: Value, h: Value, weights: Value, count: Value, out: Value) -> None:
    """out = y + h*(sum of weighted slopes)"""
    n, y, slopes = plan(c, Table.STATES), m.load(POINTER, Own.Y), m.load(POINTER, Own.STAGES)
    with c.loop(n) as i:
        total = c.variable(0.0)
        with c.loop(count) as k:
            total.set(total.get() + weights.load(REAL, k) * slopes.load(REAL, k * n + i))
        out.store(y.load(REAL, i) + h * total.get(), i)
    c.give()


def _weights(c: Code, row: tuple[float, ...]) -> Value:
    place = c.place(REAL, len(row))
    for k, value in enumerate(row):
        place.store(value, k)
    return place


@function("i32 px_stages(ptr m, double t, double h)")
def _stages(c: Code, m: Value, t: Value, h: Value) -> None:
    """All slopes of a step; the trial values stand behind them."""
    n, slopes = plan(c, Table.STATES), m.load(POINTER, Own.STAGES)
    trial = slopes.at(n * 7)
    for k in range(1, 7):
        weights = _weights(c, _ROWS[k])
        c.run("px_combine", m, h, weights, whole(c, k), trial)
        flag = c.call(FLAG, "pc_rhs", m, t + h * _NODES[k], trial, slopes.at(n * k))
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
    c.give(0)


@function("double px_error(ptr m, double h)")
def _error(c: Code, m: Value, h: Value) -> None:
    """The largest error of a step beside what is allowed."""
    n, y, slopes = plan(c, Table.STATES), m.load(POINTER, Own.Y), m.load(POINTER, Own.STAGES)
    trial, tolerance = slopes.at(n * 7), m.load(REAL, Own.TOLERANCE)
    worst = c.variable(0.0)
    with c.loop(n) as i:
        total = c.variable(0.0)
        for k, weight in enumerate(_ERROR):
            total.set(total.get() + slopes.load(REAL, n * k + i) * weight)
        size = c.largest(c.absolute(y.load(REAL, i)), c.absolute(trial.load(REAL, i)))
        allowed = tolerance * (size + nominal_of(c, m, i))
        worst.set(c.largest(c.absolute(total.get() * h) / allowed, worst.get()))
    c.give(worst.get(), REAL)


def nominal_of(c: Code, m: Value, i: Value) -> Value:
    """The size of a state: that of its candidate, which the model says, or 1."""
    w, numbers, _, _ = open_frame(m)
    slot = numbers.at(Number.FIRST_STATE).load(INT, i)
    table = Value(c, POINTER, "@px_nominals")
    found = c.variable(1.0)
    with c.loop(plan(c, Table.NOMINALS)) as k, c.when(table.load(INT, k * 2).equals(slot)):
        value = c.absolute(w.load(REAL, table.load(INT, k * 2 + 1)))
        found.set(c.select(value > 0.0, value, 1.0))
    return found.get()


@function("i32 px_advance(ptr m, double end)")
def _advance(c: Code, m: Value, end: Value) -> None:
    n, y, slopes = plan(c, Table.STATES), m.load(POINTER, Own.Y), m.load(POINTER, Own.STAGES)
    trial, last = slopes.at(n * 7), slopes.at(n * 6)
    w, _, _, _ = open_frame(m)
    step = c.variable(m.load(REAL, Own.STEP))
    again, work, behind = c.label(), c.label(), c.label()
    with c.when(n.equals(0), leaves=True):
        w.store(end)
        flag = c.call(FLAG, "pc_rhs", m, end, y, slopes)
        hold(c, m)
        m.store(whole(c, Stale.REST), Own.STALE)
        c.give(flag)
    t = c.variable(w.load(REAL))
    c.enter(again)
    c.branch(t.get() < end, work, behind)
    c.begin(work)
    with c.when(m.load(INT, Own.EXACT).equals(0)):
        flag = c.call(FLAG, "pc_rhs", m, t.get(), y, slopes)
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        m.store(whole(c, 1), Own.EXACT)
    with c.when(~(step.get() > 0.0)):
        step.set(c.constant(_FIRST, REAL))
    least = c.largest(c.absolute(t.get()), c.constant(1.0, REAL)) * _NONE
    rest = end - t.get()
    whole_way = step.get() * 1.05 >= rest
    h = c.select(whole_way, rest, step.get())
    ratio = c.variable(1e300)
    with c.when(c.call(FLAG, "px_stages", m, t.get(), h).equals(0)):
        ratio.set(c.call(REAL, "px_error", m, h))
    good = ratio.get() <= 1.0
    accepted, refused = c.label(), c.label()
    c.branch(good, accepted, refused)
    c.begin(refused)
    smaller = c.call(REAL, "pow", c.largest(ratio.get(), 1e-300), c.constant(-0.2, REAL))
    part = smaller * _SAFETY
    part = c.select((part > _FAILED) & (ratio.get() < 1e300), part, _FAILED)
    step.set(h * part)
    with c.when(step.get() < least, leaves=True):
        w.store(t.get())
        m.store(whole(c, Stale.ALL), Own.STALE)
        m.store(whole(c, 0), Own.EXACT)
        c.give(1)
    c.jump(again)
    c.begin(accepted)
    t.set(c.select(whole_way, end, t.get() + h))
    w.store(t.get())
    with c.loop(n) as i:
        y.store(trial.load(REAL, i), i)
        slopes.store(last.load(REAL, i), i)
    hold(c, m)
    m.store(whole(c, Stale.REST), Own.STALE)
    more = c.call(REAL, "pow", c.largest(ratio.get(), 1e-300), c.constant(-0.2, REAL)) * _SAFETY
    more = c.select(more < _MOST, more, _MOST)
    more = c.select(more > _LEAST, more, _LEAST)
    with c.when((~whole_way) | (h * more > step.get())):
        step.set(h * more)
    m.store(step.get(), Own.STEP)
    with c.when(c.call(REAL, "px_look", m) > m.load(REAL, Own.BOUND)):
        c.call(FLAG, "px_exchange", m)
    c.jump(again)
    c.begin(behind)
    c.give(0)
