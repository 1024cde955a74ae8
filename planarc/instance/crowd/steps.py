"""Steps of one length with crowds, in LLVM; they stand in the place of those of `instance.steps`.

    px_begin(block) -> flag            what happens where the last step ended
    px_try(block, most) -> flag        a step that ends at `most` at the latest
    px_moment(block, t, h) -> flag     the states at its end
    px_between(block, t, out)          the states within it
    px_unstruck(block)                 nothing has touched yet

Steps end at multiples of their length, reckoned from where the run began, or from the last event or
input, as in a run of planarc; the states where the host looks lie within a step. Inputs count from
where they are set: the step begins anew there, and the next one ends with the host's.

Reference: `solve.stepping.moreau`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import hold, is_null, plan, whole
from planarc.instance.crowd.layout import (
    OF_CONTACTS,
    Area,
    Count,
    Kept,
    Part,
    arrays,
    kept,
    part,
    said,
)
from planarc.instance.instants import due
from planarc.instance.plan import Own, Relation, Table
from planarc.instance.relations import attempt, numbers_of
from planarc.instance.steps import BEGIN, END, vector
from planarc.solve.contact.touches import NEVER
from planarc.solve.solvers.fixed import REST
from planarc.solve.stepping.moreau import SAME

#: Vectors of a step: its middle, 1.0 where contacts changed a state; then what is no state.
HALF, STRUCK, FREE, NEW, MEAN, WAY, SPEEDS, RATES = range(8)
#: Where memory begins that a step asks for, the last first.
_APART = (Area.A_COLUMNS, Area.M_COLUMNS, Area.KEY)


def step_functions(delayed: bool) -> tuple[str, ...]:
    """`delayed`: steps become past."""
    return (_unstruck(), _begin(delayed), *moment_functions(), _try(delayed), _between())


def moment_functions(doubts: bool = False) -> tuple[str, ...]:
    """Those of one step. `doubts`: it is not finished where a contact finds no room."""
    return _bring(), _arrays(), _strike(), _answer(), _mean(), _finish(doubts), _moment()


@function("void px_unstruck(ptr m)", seldom=True)
def _unstruck(c: Code, m: Value) -> None:
    """No touch makes an event: none is ever low enough."""
    w, _, _, _ = open_frame(m)
    with c.loop(said(c, Count.TOUCHES) * 2) as i:
        w.store(NEVER, part(c, Part.LOWS).load(INT, i))
    for word in (Kept.COUNT, Kept.INDEX):
        kept(m).store(whole(c, 0), word)
    for word in (Kept.ORIGIN, Kept.BEGIN, Kept.MIDDLE):
        kept(m).store(0.0, word)
    c.give()


@function("i32 px_begin(ptr m)")
def _begin(c: Code, m: Value, delayed: bool) -> None:
    y, (begin, end, slopes) = m.load(POINTER, Own.Y), _vectors(c, m, BEGIN, END, FREE)
    n, (w, _, _, _) = plan(c, Table.STATES), open_frame(m)
    exact, reach = m.load(INT, Own.EXACT).equals(1), m.load(REAL, Own.REACH)
    now = c.select(exact, reach, w.load(REAL))
    known = c.call(REAL, "px_next", m) <= due(c, now)
    with c.when(known | (exact & m.load(INT, Own.CROSSED).equals(1))):
        with c.when(exact):
            c.run("px_copy", y, end, n)
            w.store(reach)
        attempt(c, "px_happen", m)
    with c.when(m.load(INT, Own.EXACT).equals(1) & m.load(INT, Own.WAITING).equals(1)):
        attempt(c, "pc_rhs", m, reach, end, slopes)
        c.call(FLAG, "px_exchange", m)
    with c.when(m.load(INT, Own.EXACT).equals(1), leaves=True):
        c.run("px_copy", begin, end, n)
        c.give(0)
    t = w.load(REAL)
    m.store(t, Own.REACH)
    c.run("px_copy", begin, y, n)
    kept(m).store(t, Kept.ORIGIN)
    kept(m).store(whole(c, 0), Kept.INDEX)
    if delayed:
        attempt(c, "px_see", m, t, y)
        c.run("px_resume", m, t)
    c.give(0)


@function("i32 px_half_way(ptr m, double t, ptr y, ptr from, ptr to, double h)")
def _bring(c: Code, m: Value, t: Value, y: Value, start: Value, to: Value, h: Value) -> None:
    """Half a step of the places, with the velocities in y."""
    (is_place,), speeds = arrays(m, Area.IS_PLACE), vector(c, m, SPEEDS)
    attempt(c, "px_speeds", m, t, y, speeds)
    with c.loop(plan(c, Table.STATES)) as i, c.when(is_place.load(INT, i).equals(1)):
        to.store(start.load(REAL, i) + h * 0.5 * speeds.load(REAL, i), i)
    c.give(0)


@function("i32 px_arrays(ptr m, i64 count)")
def _arrays(c: Code, m: Value, count: Value) -> None:
    """Memory for the contacts of a step; 1 where there is none."""
    at, words = m.load(POINTER, Own.CONTACT), sum(OF_CONTACTS.values())
    memory = c.call(POINTER, "calloc", count * words + 2, whole(c, 8))
    with c.when(is_null(c, memory), leaves=True):
        c.give(1)
    place, more = 0, 0
    for which, number in OF_CONTACTS.items():
        at.store(memory.at(count * place + more), which)
        place, more = place + number, more + (which in (Area.J_STARTS, Area.A_STARTS))
    c.give(0)


@function("i32 px_strike(ptr m, double t, double h)")
def _strike(c: Code, m: Value, t: Value, h: Value) -> None:
    """All contacts of the step and how they answer; their number, or -1 where that is not found."""
    (active,), y = arrays(m, Area.ACTIVE), vector(c, m, FREE)
    ports, still = said(c, Count.PORTS), part(c, Part.STILL)
    c.run("px_lie", m)
    count = c.call(INT, "px_contacts", m, h, whole(c, 0))
    with c.when(count.equals(0), leaves=True):
        c.give(0)
    with c.when(~c.call(FLAG, "px_arrays", m, count).equals(0), leaves=True):
        c.give(-1)
    c.call(INT, "px_contacts", m, h, whole(c, 1))
    (places,) = arrays(m, Area.J_COLUMNS)
    with c.loop(ports) as i:
        active.store(whole(c, 0), i)
    with c.loop(count * 12) as k:
        port = places.load(INT, k)
        with c.when(still.load(INT, port).equals(0)):
            active.store(whole(c, 1), port)
    for call, given in (("px_respond", (t, y)), ("px_couple", (count,))):
        with c.when(~c.call(FLAG, call, m, *given).equals(0), leaves=True):
            c.give(-1)
    c.run("px_recall", m, count)
    c.give(c.flag(count))


@function("void px_answer(ptr m, double h, i64 count)")
def _answer(c: Code, m: Value, h: Value, count: Value) -> None:
    """The states behind the impulses."""
    free, new = _vectors(c, m, FREE, NEW)
    c.run("px_copy", new, free, plan(c, Table.STATES))
    with c.when(count > 0):
        c.run("px_impulses", m, h, count)
        c.run("px_moved_by", m, count, new)
    c.give()


@function("i32 px_mean_forces(ptr m, double t, double h, i64 count)")
def _mean(c: Code, m: Value, t: Value, h: Value, count: Value) -> None:
    """The states behind impulses and forces, which are those of the mean velocities."""
    n, (is_place, after, others) = (
        plan(c, Table.STATES),
        arrays(m, Area.IS_PLACE, Area.AFTER, Area.OTHERS),
    )
    y, half, free, new, mean, rates = _vectors(c, m, BEGIN, HALF, FREE, NEW, MEAN, RATES)
    c.run("px_answer", m, h, count)
    c.run("px_copy", mean, half, n)
    with _moving(c, n, is_place) as i:
        mean.store((y.load(REAL, i) + new.load(REAL, i)) * 0.5, i)
    attempt(c, "px_see", m, t, mean)
    c.run("px_rates", m, others)
    most, change = c.variable(0.0), c.variable(0.0)
    with _moving(c, n, is_place) as i:
        size = c.absolute(rates.load(REAL, i))
        most.set(c.select(size > most.get(), size, most.get()))
        size = c.absolute(others.load(REAL, i) - rates.load(REAL, i))
        change.set(c.select(size > change.get(), size, change.get()))
    with c.when(change.get() > most.get() * SAME):
        with _moving(c, n, is_place) as i:
            free.store(y.load(REAL, i) + h * others.load(REAL, i), i)
        attempt(c, "px_see", m, t, free)
        c.run("px_collect", m, part(c, Part.RATES), said(c, Count.PORTS), after)
        c.run("px_answer", m, h, count)
    c.give(0)


@function("i32 px_finish_step(ptr m, double t, double h, i64 count)")
def _finish(c: Code, m: Value, t: Value, h: Value, count: Value, doubts: bool) -> None:
    """The second half of the places' way; what pressed is shown."""
    n, ports = plan(c, Table.STATES), said(c, Count.PORTS)
    half, struck, free, new, way, end = _vectors(c, m, HALF, STRUCK, FREE, NEW, WAY, END)
    if doubts:
        attempt(c, "px_doubt", m, h, count)
    forces, impulse = arrays(m, Area.FORCES, Area.IMPULSE)
    for to in (end, way):
        c.run("px_copy", to, new, n)
    with c.loop(n) as i:
        same = new.load(REAL, i).equals(free.load(REAL, i))
        struck.store(c.select(same, c.constant(0.0, REAL), 1.0), i)
    with c.when(count > 0):
        with c.loop(ports) as i:
            forces.store(impulse.load(REAL, i) / h, i)
        c.run("px_push", m, forces)
        c.run("px_keep_impulses", m, count)
        with c.when(c.call(FLAG, "px_clear_gaps", m, h, count).equals(1)):
            c.run("px_moved_by", m, count, way)
    c.give(c.call(FLAG, "px_half_way", m, t, way, half, end, h))


@function("i32 px_moment(ptr m, double t, double h)")
def _moment(c: Code, m: Value, t: Value, h: Value) -> None:
    n, at = plan(c, Table.STATES), m.load(POINTER, Own.CONTACT)
    y, half, free, rates = _vectors(c, m, BEGIN, HALF, FREE, RATES)
    is_place, forces, before, after = arrays(
        m, Area.IS_PLACE, Area.FORCES, Area.VELOCITIES, Area.AFTER
    )
    ports, velocities, middle = said(c, Count.PORTS), part(c, Part.RATES), t + h * 0.5
    for which in _APART:
        at.store(Value(c, POINTER, "null"), which)
    c.run("px_kinds", m)
    with c.loop(ports) as i:
        forces.store(0.0, i)
    c.run("px_push", m, forces)
    c.run("px_copy", half, y, n)
    attempt(c, "px_half_way", m, t, y, y, half, h)
    attempt(c, "px_see", m, middle, half)
    c.run("px_collect", m, velocities, ports, before)
    c.run("px_rates", m, rates)
    c.run("px_copy", free, half, n)
    with _moving(c, n, is_place) as i:
        free.store(half.load(REAL, i) + h * rates.load(REAL, i), i)
    attempt(c, "px_see", m, middle, free)
    c.run("px_collect", m, velocities, ports, after)
    found = c.call(FLAG, "px_strike", m, middle, h)
    count = c.emit(INT, f"sext i32 {found.text} to i64")
    flag = c.variable(c.select(count < 0, c.constant(1, FLAG), c.constant(0, FLAG)), FLAG)
    for part_ in ("px_mean_forces", "px_finish_step"):
        with c.when(flag.get().equals(0)):
            flag.set(c.call(FLAG, part_, m, middle, h, count))
    for which in _APART:
        c.run("free", at.load(POINTER, which))
    c.give(flag.get())


@function("i32 px_try(ptr m, double most)")
def _try(c: Code, m: Value, most: Value, delayed: bool) -> None:
    """At a multiple of the length, where that is not later; 0 where a step leads on."""
    t, length, memory = m.load(REAL, Own.REACH), m.load(REAL, Own.STIFF), kept(m)
    y, end = _vectors(c, m, BEGIN, END)
    index = memory.load(INT, Kept.INDEX)
    due_ = memory.load(REAL, Kept.ORIGIN) + c.real(index + 1) * length
    slack = length * REST
    goal = c.select(due_ > most - slack, most, due_)
    h = goal - t
    m.store(whole(c, 0), Own.CROSSED)
    with c.when(h > 0.0):
        attempt(c, "px_moment", m, t, h)
        with c.when(~(due_ > most + slack)):
            memory.store(index + 1, Kept.INDEX)
    with c.when(~(h > 0.0)):  # a host that is there already
        c.run("px_copy", end, y, plan(c, Table.STATES))
    with c.loop(plan(c, Table.STATES)) as i:
        value = end.load(REAL, i)
        with c.when(~((value - value).equals(0.0)), leaves=True):
            c.give(1)
    attempt(c, "px_see", m, goal, end)
    memory.store(t, Kept.BEGIN)
    memory.store(t + h * 0.5, Kept.MIDDLE)
    m.store(goal, Own.REACH)
    m.store(h, Own.SPAN)
    m.store(whole(c, 1), Own.EXACT)
    if delayed:
        with c.when(h > 0.0):
            attempt(c, "px_take", m, t, h)
    hold(c, m)
    with c.when(plan(c, Table.INDICATORS) > 0):
        zeros = numbers_of(c, m, Relation.TRIAL)
        attempt(c, "pc_zeros", m, goal, zeros)
        with c.when(c.call(REAL, "px_crossed", m, zeros) <= 0.0):
            m.store(whole(c, 1), Own.CROSSED)
        c.run("px_passed", m, goal)
    with c.when(c.call(REAL, "px_look", m) > m.load(REAL, Own.BOUND)):
        m.store(whole(c, 1), Own.WAITING)
    c.give(0)


@function("void px_between(ptr m, double t, ptr out)")
def _between(c: Code, m: Value, t: Value, out: Value) -> None:
    """Straight ways with the old velocities, then with the new ones: what contacts change is
    changed between them."""
    begin, end, half, struck = _vectors(c, m, BEGIN, END, HALF, STRUCK)
    (is_place,) = arrays(m, Area.IS_PLACE)
    first, middle = (kept(m).load(REAL, k) for k in (Kept.BEGIN, Kept.MIDDLE))
    part_, early = (t - first) / (m.load(REAL, Own.REACH) - first), t < middle
    c.run("px_kinds", m)
    with c.loop(plan(c, Table.STATES)) as i:
        a, b, c_ = (v.load(REAL, i) for v in (begin, end, half))
        way = c.select(early, a + part_ * 2.0 * (c_ - a), c_ + (part_ * 2.0 - 1.0) * (b - c_))
        jump = c.select(early, a, b)
        line = c.select(struck.load(REAL, i).equals(1.0), jump, a + part_ * (b - a))
        out.store(c.select(is_place.load(INT, i).equals(1), way, line), i)
    c.give()


def _vectors(c: Code, m: Value, *which: int) -> list[Value]:
    return [vector(c, m, k) for k in which]


@contextmanager
def _moving(c: Code, n: Value, is_place: Value) -> Iterator[Value]:
    """For each state that is no place."""
    with c.loop(n) as i, c.when(is_place.load(INT, i).equals(0)):
        yield i
