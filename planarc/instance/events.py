"""Events of an exported model: what switches at an instant, and what follows from it.

    px_event(block, ahead) -> flag   the iteration at the present time and states
    px_update(block) -> flag         the same where something happens here, else nothing
    px_prepare(block) -> flag           everything discrete before a start is solved for
    px_settled(block) -> flag        one pass there; -1 where it changed nothing
    px_first(block) -> flag          the events of the start itself
    px_finish(block)                 those of the end: what asks `terminal()`
    px_waits(block) -> truth         whether an event is due at the present point

Flags: 0, or what stands in the way: `UNSOLVED`, `ENDLESS`; `ACTED` where an action of the model
ended the run, `Own.ENDED` and `Own.OVER` say how.

Of the model's own are `px_lefts(block, t)`, which looks back before anything acts,
`px_branches(block, initial)`, which finds the actions, `px_assign(block, t)` and
`px_act(block, t)`, which do them (`instance.actions`). The rules are those of
`solve.events.iteration`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import constant, hold, image, larger, plan, whole
from planarc.instance.instants import due, samples, switches, tick
from planarc.instance.plan import PASSES, Own, Phase, Relation, Row, Sample, Stale, Table
from planarc.instance.relations import (
    attempt,
    numbers_of,
    set_truth,
    sign,
    told,
    truth,
)
from planarc.instance.settling import ACTED, DENSE, ENDLESS, UNSOLVED, discrete
from planarc.ir.frame import Frame, Number
from planarc.solve.events.crossings import NOISE
from planarc.solve.events.settling import NEAR

#: What changed nothing.
SETTLED = -1


def event_functions(delayed: bool, tells: bool, apart: bool, crowded: bool) -> tuple[str, ...]:
    """`tells`: `px_notice(block, behind)` of the interface is told before and behind each event;
    `crowded`: there is a crowd."""
    return (_reinit(False), _keep(), _event(tells, delayed), _crossing(), _update(delayed),
            _prepare(delayed, apart), _settled(delayed), _first(delayed, crowded), _finish(),
            _waits())  # fmt: skip


def reaction_functions() -> tuple[str, ...]:
    """The iteration for a run in Python, which finds events by itself."""
    return _reinit(True), _keep(), _react()


def _zeros_of(c: Code, m: Value, *which: Relation) -> list[Value]:
    return [numbers_of(c, m, k) for k in which]


def set_flag(c: Code, m: Value, which: Table, value: float) -> None:
    """`initial()` or `terminal()`, where the model asks it."""
    slot = plan(c, which)
    with c.when(slot >= 0):
        m.load(POINTER, Frame.W).store(value, slot)


@function("i64 px_reinit(ptr m, i64 slot, double value)", seldom=True)
def _reinit(c: Code, m: Value, slot: Value, value: Value, asks: bool) -> None:
    """A state set anew; 1 where it is one at present."""
    _, numbers, _, _ = open_frame(m)
    first, y = numbers.at(Number.FIRST_STATE), m.load(POINTER, Own.Y)
    found = c.variable(0, INT)
    with c.loop(plan(c, Table.STATES)) as i, c.when(first.load(INT, i).equals(slot)):
        y.store(value, i)
        found.set(whole(c, 1))
        m.store(whole(c, 1), Own.RESET)
        if asks:  # which ones, in what is room for their derivatives elsewhere
            m.load(POINTER, Own.RATES).store(1.0, i)
    c.give(found.get())


@function("void px_keep(ptr m)")
def _keep(c: Code, m: Value) -> None:
    """Left limits become the present values."""
    w, _, _, _ = open_frame(m)
    with c.loop(plan(c, Table.DISCRETES)) as i:
        w.store(w.load(REAL, discrete(m, i, 0)), discrete(m, i, 1))
    c.give()


@function("i32 px_event(ptr m, i64 ahead)", seldom=True)
def _event(c: Code, m: Value, ahead: Value, tells: bool, delayed: bool) -> None:
    """What crosses and fires here stands in `Relation.CROSSING` and `Sample.FIRED`."""

    def tell(behind: int) -> None:
        if tells:
            c.run("px_notice", m, whole(c, behind))

    tell(0)
    t = open_frame(m)[0].load(REAL)
    if delayed:
        c.run("px_cross", m, t)
    done = _iterate(c, m, t, ahead)
    hold(c, m)
    with c.when(done.equals(2), leaves=True):
        m.store(whole(c, Stale.NOTHING), Own.STALE)
        tell(1)
        c.give(ACTED)
    with c.when(~c.call(FLAG, "px_widen", m, t).equals(0), leaves=True):
        c.give(UNSOLVED)
    with c.when(~c.call(FLAG, "pc_outputs", m, t, m.load(POINTER, Own.Y)).equals(0), leaves=True):
        c.give(UNSOLVED)
    if delayed:
        c.run("px_resume", m, t)
    c.run("px_measure", m)
    c.call(FLAG, "px_indicate", m)
    m.store(whole(c, Stale.NOTHING), Own.STALE)
    tell(1)
    c.give(0)


@function("i32 px_react(ptr m, i64 ahead)", seldom=True)
def _react(c: Code, m: Value, ahead: Value) -> None:
    """The iteration alone."""
    done = _iterate(c, m, open_frame(m)[0].load(REAL), ahead)
    c.give(c.select(done.equals(2), c.constant(ACTED, FLAG), 0))


def _iterate(c: Code, m: Value, t: Value, ahead: Value) -> Value:
    """Until everything rests: 1, or 2 where an action ended the run; the workspace is filled."""
    w, _, _, _ = open_frame(m)
    now, before, largest, bound, at = _zeros_of(
        c, m, Relation.NOW, Relation.BEFORE, Relation.LARGEST, Relation.BOUND, Relation.HELD_AT
    )
    crossing, held, late, turned, left = _zeros_of(
        c, m, Relation.CROSSING, Relation.HELD, Relation.LATE, Relation.TURNED, Relation.BEYOND
    )
    count, firing = plan(c, Table.RELATIONS), plan(c, Table.SAMPLES)
    fired, sampled = samples(c, m, Sample.FIRED), constant(c, "px_sampled")
    m.store(whole(c, 0), Own.TOUCHED)
    m.store(whole(c, 0), Own.EXACT)
    m.store(whole(c, Stale.ALL), Own.STALE)
    c.run("px_lefts", m, t)
    flag = c.variable(c.call(FLAG, "px_zeros", m, t), FLAG)
    some, more = c.variable(0, INT), c.variable(0, INT)
    with c.loop(firing) as k, c.when(fired.load(INT, k).equals(1)):
        w.store(1.0, sampled.load(INT, k))
        some.set(whole(c, 1))
        more.set(whole(c, 1))
    with c.loop(count) as i:
        before.store(now.load(REAL, i), i)
        with c.when(crossing.load(INT, i).equals(1)):
            set_truth(c, m, i, ~truth(c, m, i))
            some.set(whole(c, 1))
    with c.when(some.get().equals(1)):
        flag.set(c.call(FLAG, "px_zeros", m, t))
    with c.when(~flag.get().equals(0), leaves=True):
        c.give(UNSOLVED)
    with c.loop(count) as i:
        size, noise = c.absolute(now.load(REAL, i)), largest.load(REAL, i) * NOISE
        here = crossing.load(INT, i)
        held.store(here, i)
        at.store(now.load(REAL, i), i)
        bound.store(c.select(here.equals(1), size * 2.0 + noise, -1.0), i)
        late.store(c.emit(INT, f"zext i1 {(size > noise * 1e3).text} to i64"), i)
        turned.store(whole(c, 0), i)
        left.store(whole(c, 0), i)
        crossing.store(whole(c, 0), i)
    moved, done = c.variable(0, INT), c.variable(0, INT)
    with c.loop(plan(c, Table.DISCRETES) + PASSES), c.when(done.get().equals(0)):
        c.run("px_snapshot", m, whole(c, 2))
        attempt(c, "px_settle", m, t, moved.get())
        c.run("px_branches", m, whole(c, 0))
        moved.set(c.call(INT, "px_act", m, t))
        c.run("px_keep", m)
        with c.loop(firing) as k:
            w.store(0.0, sampled.load(INT, k))
            fired.store(whole(c, 0), k)
        c.run("px_snapshot", m, whole(c, 1))
        rests = c.call(INT, "px_same", m, whole(c, 1), whole(c, 2)).equals(1)
        rests = rests & moved.get().equals(0) & more.get().equals(0)
        more.set(whole(c, 0))
        with c.when(rests):
            done.set(whole(c, 1))
            with c.when(ahead.equals(1)):
                turns = c.call(FLAG, "px_turn", m, t)
                with c.when(turns.equals(1)):
                    done.set(whole(c, 0))
        over = (m.load(INT, Own.ENDED) > 0) | m.load(INT, Own.OVER).equals(1)
        with c.when(over):
            done.set(whole(c, 2))
    with c.when(done.get().equals(0), leaves=True):
        c.give(ENDLESS)
    y = m.load(POINTER, Own.Y)
    with c.when(~c.call(FLAG, "pc_outputs", m, t, y).equals(0), leaves=True):
        c.give(UNSOLVED)
    return done.get()


@function("i64 px_crossing(ptr m, double t)", seldom=True)
def _crossing(c: Code, m: Value, t: Value) -> None:
    """What crosses and fires here; 1 where anything does."""
    now, largest, width, crossing, rises, instant = _zeros_of(
        c, m, Relation.NOW, Relation.LARGEST, Relation.WIDTH, Relation.CROSSING, Relation.RISES,
        Relation.INSTANT,
    )  # fmt: skip
    count, found, limit = plan(c, Table.RELATIONS), c.variable(0, INT), due(c, t)
    with c.when(~c.call(FLAG, "px_zeros", m, t).equals(0), leaves=True):
        c.give(0, INT)
    ticks, fired = samples(c, m, Sample.TICKS), samples(c, m, Sample.FIRED)
    with c.loop(plan(c, Table.SAMPLES)) as k:
        fired.store(whole(c, 0), k)
        with c.when(tick(c, m, k) <= limit):
            fired.store(whole(c, 1), k)
            ticks.store(ticks.load(REAL, k) + 1.0, k)
            found.set(whole(c, 1))
    with c.loop(count) as i:
        g, far = now.load(REAL, i), width.load(REAL, i)
        way = c.select(truth(c, m, i), -g, g)
        state = told(c, i, Row.TIMED).equals(0) & (way + far * 0.5 <= 0.0)
        here = state | (switches(c, m, i) & (instant.load(REAL, i) <= limit))
        crossing.store(c.emit(INT, f"zext i1 {here.text} to i64"), i)
        with c.when(here):
            found.set(whole(c, 1))
    near = c.variable(0, INT)
    with c.when(found.get().equals(0)), c.loop(count) as i:
        beside = c.absolute(now.load(REAL, i)) <= largest.load(REAL, i) * NEAR
        with c.when(told(c, i, Row.TIMED).equals(0) & beside):
            near.set(whole(c, 1))
    with c.when(near.get().equals(1)):  # hosts may stop just before they cross
        flag = c.call(FLAG, "px_rises", m, t, whole(c, 0))
        with c.when(flag.equals(0)), c.loop(count) as i:
            beside = c.absolute(now.load(REAL, i)) <= largest.load(REAL, i) * NEAR
            rise = rises.load(REAL, i)
            ahead = c.select(truth(c, m, i), rise, -rise)
            touch = told(c, i, Row.TOUCH).equals(1)
            quiet = c.select(touch, c.constant(0.0, REAL), c.call(REAL, "px_quiet", m))
            moves = ahead > larger(c, largest.load(REAL, i) * NEAR, quiet)
            with c.when(told(c, i, Row.TIMED).equals(0) & beside & moves):
                crossing.store(whole(c, 1), i)
                found.set(whole(c, 1))
        c.call(FLAG, "px_zeros", m, t)  # back from the later time
    c.give(found.get())


@function("i32 px_update(ptr m)", seldom=True)
def _update(c: Code, m: Value, delayed: bool) -> None:
    """What comes back from the past is an event as well; it jumps anew where it, a truth or a
    discrete value does."""
    w, _, _, _ = open_frame(m)
    t = w.load(REAL)
    m.store(whole(c, 0), Own.RESET)
    m.store(whole(c, 0), Own.MOVED)
    found = c.call(INT, "px_crossing", m, t)
    nothing = found.equals(0) & m.load(INT, Own.TOUCHED).equals(0)
    if delayed:
        ordinary, back = ~nothing, c.call(INT, "px_back", m, t)
        nothing = nothing & back.equals(0)
    with c.when(nothing, leaves=True):
        flag = c.call(FLAG, "pc_outputs", m, t, m.load(POINTER, Own.Y))
        with c.when(flag.equals(0)):
            m.store(whole(c, Stale.NOTHING), Own.STALE)
        c.give(0)
    hold(c, m)
    if not delayed:
        c.give(c.call(FLAG, "px_event", m, whole(c, 1)))
        return
    c.run("px_snapshot", m, whole(c, 0))
    before = c.call(INT, "px_hash", m, whole(c, 0))
    c.run("px_left", m, t)
    attempt(c, "px_event", m, whole(c, 1))
    c.run("px_snapshot", m, whole(c, 0))
    same = before.equals(c.call(INT, "px_hash", m, whole(c, 0)))
    anew = ordinary | ~same | c.call(INT, "px_jumps", m, t).equals(1)
    generation = c.emit(INT, f"select i1 {anew.text}, i64 0, i64 {back.text}")
    attempt(c, "px_kink", m, t, generation, c.call(INT, "px_jumped", m))
    c.run("px_cross", m, t)
    c.give(0)


@function("i32 px_prepare(ptr m)", seldom=True)
def _prepare(c: Code, m: Value, delayed: bool, apart: bool) -> None:
    w, _, _, _ = open_frame(m)
    t, count = w.load(REAL), plan(c, Table.DISCRETES)
    m.store(whole(c, 0), Own.ENDED)
    m.store(whole(c, 0), Own.OVER)
    attempt(c, "pc_parameters", m, t)
    before = image(c, m, apart).at(plan(c, Table.WORKSPACE))
    now, largest = _zeros_of(c, m, Relation.NOW, Relation.LARGEST)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        slot = told(c, i, Row.SLOT)
        w.store(before.load(REAL, slot), slot)
        largest.store(0.0, i)
    with c.loop(count) as i:
        start = w.load(REAL, discrete(m, i, 2))
        w.store(start, discrete(m, i, 0))
        w.store(start, discrete(m, i, 1))
    set_flag(c, m, Table.INITIAL, 1.0)
    c.run("px_unstruck", m)
    if delayed:
        attempt(c, "px_begin_past", m, t)
    c.run("px_instants", m, t)
    interval, least = samples(c, m, Sample.INTERVAL), (due(c, t) - t) * 2.0
    with c.loop(plan(c, Table.SAMPLES)) as k:
        length = interval.load(REAL, k)
        with c.when((length > 0.0) & (length < least), leaves=True):
            c.give(DENSE)
    w.store(t)
    c.call(FLAG, "pc_zeros", m, t, now)
    with c.loop(plan(c, Table.RELATIONS)) as i, c.when(told(c, i, Row.OF_TIME).equals(1)):
        set_truth(c, m, i, sign(c, i, now.load(REAL, i)))
    good = c.variable(1, INT)
    with c.loop(count), c.when(good.get().equals(1)):
        flag = c.call(FLAG, "pc_discrete", m, t)
        with c.when(~flag.equals(0)):
            good.set(whole(c, 0))
    with c.when(good.get().equals(0)), c.loop(count) as i:  # no value before the unknowns have one
        w.store(w.load(REAL, discrete(m, i, 2)), discrete(m, i, 0))
    c.give(0)


@function("i32 px_settled(ptr m)", seldom=True)
def _settled(c: Code, m: Value, delayed: bool) -> None:
    w, _, _, _ = open_frame(m)
    t, now = w.load(REAL), numbers_of(c, m, Relation.NOW)
    c.run("px_snapshot", m, whole(c, 0))
    with c.when(~c.call(FLAG, "px_zeros", m, t).equals(0), leaves=True):
        c.give(UNSOLVED)
    quiet = c.call(REAL, "px_quiet", m)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        g, exact = now.load(REAL, i), told(c, i, Row.OF_TIME).equals(1)
        small = (c.absolute(g) <= quiet) & ~exact
        set_truth(c, m, i, sign(c, i, c.select(small, c.constant(0.0, REAL), g)))
    c.call(FLAG, "pc_outputs", m, t, m.load(POINTER, Own.Y))
    c.call(FLAG, "pc_discrete", m, t)
    c.run("px_branches", m, whole(c, 1))
    attempt(c, "px_assign", m, t)
    c.run("px_snapshot", m, whole(c, 1))
    same = c.call(INT, "px_same", m, whole(c, 0), whole(c, 1)).equals(1)
    if delayed:
        same = same & c.call(INT, "px_known", m).equals(1)
    c.give(c.select(same, c.constant(SETTLED, FLAG), c.constant(0, FLAG)))


@function("i32 px_first(ptr m)", seldom=True)
def _first(c: Code, m: Value, delayed: bool, crowded: bool) -> None:
    w, _, _, _ = open_frame(m)
    t, y = w.load(REAL), m.load(POINTER, Own.Y)
    count, limit = plan(c, Table.RELATIONS), due(c, t)
    largest, crossing = _zeros_of(c, m, Relation.LARGEST, Relation.CROSSING)
    attempt(c, "pc_outputs", m, t, y)
    for act in (False, True):
        c.run("px_branches", m, whole(c, 1))
        if act:
            c.call(INT, "px_act", m, t)
        else:
            attempt(c, "px_assign", m, t)
    c.run("px_keep", m)
    set_flag(c, m, Table.INITIAL, 0.0)
    with c.loop(count) as i:
        largest.store(0.0, i)
        crossing.store(whole(c, 0), i)
    ticks, fired = samples(c, m, Sample.TICKS), samples(c, m, Sample.FIRED)
    with c.loop(plan(c, Table.SAMPLES)) as k:
        here = tick(c, m, k) <= limit
        fired.store(c.emit(INT, f"zext i1 {here.text} to i64"), k)
        ticks.store(ticks.load(REAL, k) + c.select(here, c.constant(1.0, REAL), 0.0), k)
    for ahead in (0, 1):
        attempt(c, "px_event", m, whole(c, ahead))
    if crowded:
        attempt(c, "px_apart", m)
    if delayed:
        attempt(c, "px_kink", m, t, whole(c, 0), whole(c, 1))
        c.run("px_cross", m, t)
    c.give(0)


@function("void px_finish(ptr m)", seldom=True)
def _finish(c: Code, m: Value) -> None:
    phase = m.load(INT, Own.PHASE)
    runs = (phase >= Phase.EVENT) & (phase <= Phase.PAUSE)
    with c.when(runs & (plan(c, Table.TERMINAL) >= 0)):
        set_flag(c, m, Table.TERMINAL, 1.0)
        c.call(FLAG, "px_event", m, whole(c, 0))
    c.give()


@function("i64 px_waits(ptr m)", seldom=True)
def _waits(c: Code, m: Value) -> None:
    """Known instants, and what the host has set."""
    w, _, _, _ = open_frame(m)
    t, found = w.load(REAL), c.variable(0, INT)
    with c.when(c.call(REAL, "px_next", m) <= due(c, t), leaves=True):
        c.give(1, INT)
    with c.when(m.load(INT, Own.TOUCHED).equals(1) & c.call(FLAG, "px_zeros", m, t).equals(0)):
        gone = c.call(REAL, "px_crossed", m, numbers_of(c, m, Relation.NOW)) <= 0.0
        found.set(c.select(gone, whole(c, 1), whole(c, 0)))
    c.give(found.get())
