"""To a time, by steps that end where they will, in LLVM.

    px_advance(block, end) -> flag     1 where no step leads on
    px_tell(block, end) -> end         the host looks at what a step led to

The states at the time are looked up within the last step. Steps are those of `steps`, or, where
there is a crowd, those of `crowd`: by `px_begin`, `px_try` and `px_between` of both.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import BYTE, hold, is_null, larger, load_narrow, plan, whole
from planarc.instance.instants import due
from planarc.instance.plan import Own, Phase, Stale, Table
from planarc.instance.relations import attempt
from planarc.instance.steps import END, vector
from planarc.solve.solvers.fixed import REST


def advance_functions(delayed: bool, crowded: bool) -> tuple[str, ...]:
    """`delayed`: steps become past; `crowded`: they have one length."""
    return _tell(), _advance(delayed, crowded)


@function("double px_tell(ptr m, double end)", seldom=True)
def _tell(c: Code, m: Value, end: Value) -> None:
    """Show the host where a step ended; gives when it wants to go no further."""
    w, _, _, _ = open_frame(m)
    reach, host = m.load(REAL, Own.REACH), m.load(POINTER, Own.HOST)
    c.run("px_copy", m.load(POINTER, Own.Y), vector(c, m, END), plan(c, Table.STATES))
    w.store(reach)
    m.store(whole(c, Stale.ALL), Own.STALE)
    phase = m.load(INT, Own.PHASE)
    m.store(whole(c, Phase.MEANWHILE), Own.PHASE)
    place = c.place(INT, 2)  # whether to return early, and when
    wanted, until = place, place.at(1)
    wanted.store(whole(c, 0))
    until.store(reach)
    early = c.emit("i32", f"trunc i64 {m.load(INT, Own.EARLY).text} to i32")
    # Truths are passed as words of 4 bytes: so every processor's convention widens them.
    given = (f"ptr {host.text}", f"double {reach.text}", "i32 0", "i32 1", "i32 1",
             f"i32 {early.text}", f"ptr {wanted.text}", f"ptr {until.text}")  # fmt: skip
    c.line(f"call void {m.load(POINTER, Own.UPDATE).text}({', '.join(given)})")
    m.store(phase, Own.PHASE)
    asked = ~load_narrow(c, BYTE, wanted, whole(c, 0)).equals(0) & m.load(INT, Own.EARLY).equals(1)
    last = until.load(REAL)
    nearer = asked & (last < end)
    c.give(c.select(nearer, c.select(last > reach, last, reach), end), REAL)


@function("i32 px_advance(ptr m, double last)")
def _advance(c: Code, m: Value, last: Value, delayed: bool, crowded: bool) -> None:
    """Events end the way where the host wants to know of them."""
    n, y = plan(c, Table.STATES), m.load(POINTER, Own.Y)
    w, _, _, _ = open_frame(m)
    goal = c.variable(last)
    stops = m.load(INT, Own.EARLY).equals(1)
    calls = m.load(INT, Own.EVENTS).equals(1)
    looks = ~is_null(c, m.load(POINTER, Own.UPDATE))
    was_set = m.load(INT, Own.TOUCHED).equals(1)
    with c.when(calls & stops):
        with c.when(c.call(INT, "px_waits", m).equals(1), leaves=True):
            m.store(whole(c, 1), Own.CALLED)
            c.give(0)
        with c.when(m.load(INT, Own.TOUCHED).equals(1)):
            m.store(whole(c, 0), Own.TOUCHED)
            hold(c, m)
    with c.when(m.load(INT, Own.TOUCHED).equals(1)):
        attempt(c, "px_update", m)
    end = goal.get()
    still = n.equals(0) & plan(c, Table.INDICATORS).equals(0) & ~looks
    if not delayed:  # else there are steps to be remembered
        with c.when(still & (c.call(REAL, "px_next", m) > due(c, end)), leaves=True):
            w.store(end)
            alone = c.call(FLAG, "pc_rhs", m, end, y, y)
            hold(c, m)
            m.store(whole(c, Stale.REST), Own.STALE)
            c.give(alone)
    stop = m.load(REAL, Own.STOP)
    beyond = c.select(stop > end, stop, end)
    # After something was set a step ends with the host's: more may be set there.
    ends = was_set | looks if crowded else (m.load(REAL, Own.STIFF) > 0.0) | looks
    # Ends of steps of one length are rounded.
    slack = m.load(REAL, Own.STIFF) * REST if crowded else c.constant(0.0, REAL)
    begun = whole(c, 1) if crowded else m.load(INT, Own.EXACT)
    free = c.emit(INT, f"select i1 {ends.text}, i64 0, i64 {begun.text}")
    bounded = c.variable(free, INT)
    if crowded:  # no step shows yet what presses
        begins = ~m.load(INT, Own.EXACT).equals(1) & (w.load(REAL) >= end)
        with c.when(begins, leaves=True):
            c.give(0)
    there = c.variable(0, INT)  # 1 where the workspace is that of the end
    flag = c.variable(c.constant(0, FLAG), FLAG)
    again, work, behind, failed = c.label(), c.label(), c.label(), c.label()
    c.enter(again)
    reach, exact = m.load(REAL, Own.REACH), m.load(INT, Own.EXACT).equals(1)
    here = m.load(INT, Own.CROSSED).equals(1) | (c.call(REAL, "px_next", m) <= due(c, reach))
    with c.when(stops & exact & here & (reach < goal.get())):
        goal.set(reach)
    end = goal.get()
    c.branch(exact & (reach >= (end - slack if crowded else end)), behind, work)
    c.begin(work)
    flag.set(c.call(FLAG, "px_begin", m))
    c.leave(~flag.get().equals(0), failed)
    most = c.select(bounded.get().equals(0), end, beyond)
    following = c.call(REAL, "px_next", m)
    most = c.select(following < most, following, most)
    now = m.load(REAL, Own.REACH)
    c.leave((now >= most) & (now < end), again)  # another instant, within rounding
    most = larger(c, most, now)  # a host that is there already is given a step of no length
    flag.set(c.call(FLAG, "px_try", m, most))
    c.leave(~flag.get().equals(0), failed)
    there.set(whole(c, 1))
    reach = m.load(REAL, Own.REACH)
    with c.when(looks & (reach <= goal.get())):
        goal.set(c.call(REAL, "px_tell", m, goal.get()))
    c.jump(again)
    c.begin(failed)
    with c.when(m.load(INT, Own.EXACT).equals(1)):  # as far as steps led
        c.run("px_copy", y, vector(c, m, END), n)
        w.store(m.load(REAL, Own.REACH))
    m.store(whole(c, Stale.ALL), Own.STALE)
    m.store(whole(c, 0), Own.EXACT)
    c.give(flag.get())
    c.begin(behind)
    reach, end = m.load(REAL, Own.REACH), goal.get()
    known = (c.call(REAL, "px_next", m) <= due(c, end)) & (reach <= due(c, end))
    near = c.absolute(reach - end) <= slack if crowded else reach.equals(end)
    exactly = near | known
    with c.when(exactly):
        c.run("px_copy", y, vector(c, m, END), n)
    with c.when(~exactly):
        c.run("px_between", m, end, y)
    w.store(end)
    fresh = exactly & there.get().equals(1)
    stale = c.emit(INT, f"select i1 {fresh.text}, i64 {int(Stale.REST)}, i64 {int(Stale.ALL)}")
    m.store(stale, Own.STALE)
    happens = exactly & (known | m.load(INT, Own.CROSSED).equals(1))
    with c.when(happens & calls, leaves=True):
        attempt(c, "px_crowd", m)
        m.store(whole(c, 1), Own.CALLED)
        c.give(0)
    with c.when(happens):
        attempt(c, "px_happen", m)
    c.give(0)
