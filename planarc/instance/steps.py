"""An integrator of the model's own, in LLVM: an explicit pair of order 5 and 4.

    px_begin(block) -> flag            what happens where the last step ended, and the first slopes
    px_try(block, most) -> flag        a step that ends at `most` at the latest
    px_between(block, t, states)       the states within the last step, of order 4; of order 3
                                       where it is one of `stiff`

Where the parameter `_stiff` says so, steps are those of `stiff`, and end where the host's do.

A step is as long as its errors allow, and the states at `end` are looked up within it: many
short steps of a host cost as much as few long ones. Where loops are to be closed no step is longer
than a hundredth of the run. After the host has set something the first step ends at `end` at the
latest. Every step ends at events (`ends`), right behind the first crossing of a relation on its
way: its stages and its end show that, and where a relation swings looks within it (`within`). They
happen before the next step, or where the host arrives there; a host that wants to handle them
itself (`Own.EVENTS`) is told by `Own.CALLED`, and where steps may end early (`Own.EARLY`) an event
ends them. What is accepted becomes the point that nonlinear blocks start from; where the states go
bad there, others are taken before the next step.

Reference: J. R. Dormand, P. J. Prince, J. Comput. Appl. Math. 6(1), 1980, 19-26; the states
within a step: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
2nd ed., Springer 1993, section II.6.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import (
    FLAG,
    INT,
    POINTER,
    REAL,
    Code,
    Value,
    Variable,
    function,
)
from planarc.codegen.native.newton import open_frame
from planarc.codegen.native.reaching import give_where_far
from planarc.instance.block import (
    constant,
    hold,
    larger,
    nominal_of,
    plan,
    whole,  # fmt: skip
)
from planarc.instance.instants import due
from planarc.instance.plan import Look, Own, Relation, Table
from planarc.instance.relations import attempt, looked, numbers_of

NODES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_ROWS = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
#: The stages whose zero functions are kept for a look at what lies between (`within`).
NOTED = {1: Look.EARLIEST, 2: Look.EARLIER, 3: Look.LATER, 4: Look.LATEST}
#: The result of order 5 minus that of order 4.
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
_SAFETY, _LEAST, _MOST, _FAILED, _HALF = 0.9, 0.2, 5.0, 0.25, 0.5
#: What the slopes add to a cubic polynomial through both ends.
_DENSE = (-12715105075 / 11282082432, 0.0, 87487479700 / 32700410799, -10690763975 / 1880347072,
          701980252875 / 199316789632, -1453857185 / 822651844, 69997945 / 29380423)  # fmt: skip
#: Behind the slopes: the states of a trial, at the begin and at the end of the last step.
TRIAL, BEGIN, END = 7, 8, 9
#: First step of all, and steps below this part of the time are none.
_FIRST, _NONE = 1e-4, 1e-14
#: Longest step behind a crossing of what swings, in lengths of the step to there.
_SOON = 4.0
#: Longest step of models with relations or loops, in units of `Own.AHEAD`.
_LONGEST = 1e5


def step_functions(delayed: bool) -> tuple[str, ...]:
    """`delayed`: steps become past."""
    return (_combine(), _stages(), _error(), _between(), _begin(delayed),
            _try(delayed))  # fmt: skip


def vector(c: Code, m: Value, place: int) -> Value:
    """One of the arrays of slopes and states."""
    return m.load(POINTER, Own.STAGES).at(plan(c, Table.STATES) * place)


@function("void px_combine(ptr m, double h, ptr weights, i64 count)")
def _combine(c: Code, m: Value, h: Value, weights: Value, count: Value) -> None:
    """trial = begin + h*(sum of weighted slopes)"""
    n, slopes = plan(c, Table.STATES), m.load(POINTER, Own.STAGES)
    begin, trial = vector(c, m, BEGIN), vector(c, m, TRIAL)
    with c.loop(n) as i:
        total = c.variable(0.0)
        with c.loop(count) as k:
            total.set(total.get() + weights.load(REAL, k) * slopes.load(REAL, k * n + i))
        trial.store(begin.load(REAL, i) + h * total.get(), i)
    c.give()


def _weights(c: Code, row: tuple[float, ...]) -> Value:
    place = c.place(REAL, len(row))
    for k, value in enumerate(row):
        place.store(value, k)
    return place


@function("i32 px_stages(ptr m, double t, double h)")
def _stages(c: Code, m: Value, t: Value, h: Value) -> None:
    """All slopes of a step but the first; the trial values stand behind them."""
    with c.when(m.load(REAL, Own.STIFF) > 0.0, leaves=True):
        flag = c.call(FLAG, "px_stiff", m, t, h)
        with c.when(flag.equals(0) & (plan(c, Table.INDICATORS) > 0)):
            c.run("px_watch", m, t + h, c.constant(1.0, REAL))
        c.give(flag)
    trial = vector(c, m, TRIAL)
    for k in range(1, 7):
        c.run("px_combine", m, h, _weights(c, _ROWS[k]), whole(c, k))
        flag = c.call(FLAG, "pc_rhs", m, t + h * NODES[k], trial, vector(c, m, k))
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
        with c.when(plan(c, Table.INDICATORS) > 0):
            c.run("px_watch", m, t + h * NODES[k], c.constant(NODES[k], REAL))
        if k in NOTED:
            with c.when(plan(c, Table.SWINGS) > 0):
                zeros = numbers_of(c, m, Relation.TRIAL)
                c.run("px_copy", looked(c, m, NOTED[k]), zeros, plan(c, Table.RELATIONS))
    c.give(0)


@function("double px_error(ptr m, double h)")
def _error(c: Code, m: Value, h: Value) -> None:
    """The largest error of a step beside what is allowed; beyond all where a loop moved too far."""
    give_where_far(c, m, constant(c, "px_angles"), c.constant(1e300, REAL), REAL)
    with c.when(m.load(REAL, Own.STIFF) > 0.0, leaves=True):
        c.give(c.call(REAL, "px_stiff_error", m), REAL)
    n, slopes = plan(c, Table.STATES), m.load(POINTER, Own.STAGES)
    begin, trial = vector(c, m, BEGIN), vector(c, m, TRIAL)
    tolerance = m.load(REAL, Own.TOLERANCE)
    worst = c.variable(0.0)
    with c.loop(n) as i:
        total = c.variable(0.0)
        for k, weight in enumerate(_ERROR):
            total.set(total.get() + slopes.load(REAL, n * k + i) * weight)
        size = larger(c, c.absolute(begin.load(REAL, i)), c.absolute(trial.load(REAL, i)))
        allowed = tolerance * (size + nominal_of(c, m, i))
        worst.set(larger(c, c.absolute(total.get() * h) / allowed, worst.get()))
    c.give(worst.get(), REAL)


@function("void px_between(ptr m, double t, ptr out)")
def _between(c: Code, m: Value, t: Value, out: Value) -> None:
    """The polynomial of the last step."""
    n, slopes = plan(c, Table.STATES), m.load(POINTER, Own.STAGES)
    begin, end = vector(c, m, BEGIN), vector(c, m, END)
    h = m.load(REAL, Own.SPAN)
    rest = (m.load(REAL, Own.REACH) - t) / h  # from 1 down to 0
    part = 1.0 - rest
    with c.loop(n) as i:
        more = c.variable(0.0)
        for k, weight in enumerate(_DENSE):
            if weight:
                more.set(more.get() + slopes.load(REAL, n * k + i) * weight)
        # Those of `stiff` are none, and nobody looks there but where something swings.
        with c.when((plan(c, Table.SWINGS) > 0) & (m.load(REAL, Own.STIFF) > 0.0)):
            more.set(0.0)
        change = end.load(REAL, i) - begin.load(REAL, i)
        bend = h * slopes.load(REAL, i) - change
        other = change - h * slopes.load(REAL, n * 6 + i) - bend
        inner = bend + part * (other + rest * (h * more.get()))
        out.store(begin.load(REAL, i) + part * (change + rest * inner), i)
    c.give()


@function("i32 px_begin(ptr m)")
def _begin(c: Code, m: Value, delayed: bool) -> None:
    """What happens where the last step ended; then the first slopes of a step: those at the end of
    the last one, or new ones."""
    n, y = plan(c, Table.STATES), m.load(POINTER, Own.Y)
    begin, end = vector(c, m, BEGIN), vector(c, m, END)
    slopes, last = vector(c, m, 0), vector(c, m, 6)
    w, _, _, _ = open_frame(m)
    exact = m.load(INT, Own.EXACT).equals(1)
    reach = m.load(REAL, Own.REACH)
    now = c.select(exact, reach, w.load(REAL))
    known = c.call(REAL, "px_next", m) <= due(c, now)
    with c.when(known | (exact & m.load(INT, Own.CROSSED).equals(1))):
        with c.when(exact):
            c.run("px_copy", y, end, n)
            w.store(reach)
        attempt(c, "px_happen", m)
    exact = m.load(INT, Own.EXACT).equals(1)
    with c.when(exact & m.load(INT, Own.WAITING).equals(1)):
        with c.when(~c.call(FLAG, "pc_rhs", m, reach, end, slopes).equals(0), leaves=True):
            c.give(1)
        c.call(FLAG, "px_exchange", m)
    with c.when(m.load(INT, Own.EXACT).equals(1), leaves=True):
        with c.loop(n) as i:
            begin.store(end.load(REAL, i), i)
            slopes.store(last.load(REAL, i), i)
        c.give(0)
    t = w.load(REAL)
    m.store(t, Own.REACH)
    with c.when(~c.call(FLAG, "pc_rhs", m, t, y, slopes).equals(0), leaves=True):
        c.give(1)
    with c.loop(n) as i:
        begin.store(y.load(REAL, i), i)
    if delayed:
        attempt(c, "pc_rest", m, t)
        c.run("px_resume", m, t)
    c.give(0)


@function("i32 px_try(ptr m, double most)")
def _try(c: Code, m: Value, most: Value, delayed: bool) -> None:
    """A step from `Own.REACH` on that ends at `most` at the latest: 0 where one is found."""
    t = m.load(REAL, Own.REACH)
    step = c.variable(m.load(REAL, Own.STEP))
    with c.when(~(step.get() > 0.0)):
        step.set(c.constant(_FIRST, REAL))
    least = larger(c, c.absolute(t), c.constant(1.0, REAL)) * _NONE
    watched, longest = plan(c, Table.INDICATORS) > 0, m.load(REAL, Own.AHEAD) * _LONGEST
    # Loops are closed from the end of the last step, wherever within this one the host looks.
    bounded = watched | (plan(c, Table.NONLINEAR) > 0)
    step.set(c.select(bounded & (step.get() > longest), longest, step.get()))
    again = c.label()
    c.enter(again)
    rest = most - t
    whole_way = step.get() * 1.05 >= rest
    h = c.select(whole_way, rest, step.get())
    ratio = c.variable(1e300)
    m.store(2.0, Own.NODE)
    m.store(whole(c, 0), Own.CROSSED)
    with c.when(c.call(FLAG, "px_stages", m, t, h).equals(0)):
        ratio.set(c.call(REAL, "px_error", m, h))
    accepted, refused = c.label(), c.label()
    c.branch(ratio.get() <= 1.0, accepted, refused)
    c.begin(refused)
    smaller = c.call(REAL, "pow", larger(c, ratio.get(), 1e-300), c.constant(-0.2, REAL))
    part = smaller * _SAFETY
    part = c.select((part > _FAILED) & (ratio.get() < 1e300), part, _FAILED)
    step.set(h * part)
    with c.when(step.get() < least, leaves=True):
        c.give(1)
    c.jump(again)
    c.begin(accepted)
    with c.when((plan(c, Table.SWINGS) > 0) & (h > 0.0)):
        c.run("px_within", m, t, h)
    node, length = m.load(REAL, Own.NODE), c.variable(h)
    with c.when(node <= 1.0):
        length.set(c.call(REAL, "px_locate", m, t, h * node))
    cut = length.get() < h
    trial, end = vector(c, m, TRIAL), vector(c, m, END)
    with c.loop(plan(c, Table.STATES)) as i:
        end.store(trial.load(REAL, i), i)
    m.store(c.select(whole_way & ~cut, most, t + length.get()), Own.REACH)
    m.store(length.get(), Own.SPAN)
    m.store(whole(c, 1), Own.EXACT)
    if delayed:
        _leave_behind(c, m, t, length.get(), step, least, again)
    with c.when(cut & (plan(c, Table.SWINGS) > 0)):  # what swings crosses again soon
        soon = length.get() * _SOON
        step.set(c.select(soon < step.get(), soon, step.get()))
    more = c.call(REAL, "pow", larger(c, ratio.get(), 1e-300), c.constant(-0.2, REAL)) * _SAFETY
    more = c.select(more < _MOST, more, _MOST)
    more = c.select(more > _LEAST, more, _LEAST)
    with c.when((~cut) & ((~whole_way) | (h * more > step.get()))):
        step.set(h * more)
    m.store(step.get(), Own.STEP)
    hold(c, m)
    with c.when(watched):
        c.run("px_passed", m, m.load(REAL, Own.REACH))
    with c.when(c.call(REAL, "px_look", m) > m.load(REAL, Own.BOUND)):
        m.store(whole(c, 1), Own.WAITING)
    c.give(0)


def _leave_behind(
    c: Code, m: Value, t: Value, length: Value, step: Variable, least: Value, again: str
) -> None:
    """The step becomes past, or is tried again where that needs shorter ones."""
    flag = c.call(FLAG, "px_take", m, t, length)
    with c.when(flag > 1, leaves=True):
        c.give(flag)
    shorter, behind = c.label(), c.label()
    c.branch(flag.equals(1), shorter, behind)
    c.begin(shorter)
    m.store(t, Own.REACH)
    c.run("px_copy", vector(c, m, END), vector(c, m, BEGIN), plan(c, Table.STATES))
    step.set(length * _HALF)
    with c.when(step.get() < least, leaves=True):
        c.give(1)
    c.jump(again)
    c.begin(behind)
