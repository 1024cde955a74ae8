"""Steps become past, in LLVM.

    px_take(block, t, h) -> flag     a step of the own integrator; 1: it must be shorter
    px_record(block) -> flag         a step of a host, which ends at the present point
    px_mark(block)                   a host's next step begins here

Signals are taken at six points of a step, from states in between: those of the own integrator's
polynomial, or, where only both ends are known, of a cubic one. That is bent by the slopes at two
points more, twice, so that it is of order 6; not where the second time does not come nearer, as
where the model is stiff. What a host gives as inputs is a line between both ends.

Steps that a host gives up leave no trace: only those that it calls completed are recorded, and
what an event begins with.

Reference: W. H. Enright, K. R. Jackson, S. P. Norsett, P. G. Thomsen, ACM Trans. Math. Softw.
12(3), 1986, 193-218, for polynomials that are made better by more slopes.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import plan, whole
from planarc.instance.past.layout import Each, Head, Past
from planarc.instance.past.pieces import NODES
from planarc.instance.plan import Own, Stale, Table
from planarc.instance.steps import BEGIN, END, vector
from planarc.ir.frame import Number
from planarc.runtime.history import DEGREE, TERMS

#: Where slopes are looked at once more: near the ends, where the cubic polynomial is best.
_NEAR = 0.15
#: Places in `Past.vector`, and the part by which a second look must come nearer.
Y1, F1, TRIAL, SLOPE, FIRST, EVEN, ODD, EVEN_BEFORE, ODD_BEFORE = range(9)
_NEARER = 0.5
#: Where the states of a step come from: its own polynomial, its ends, a host.
_OWN, _ENDS, _HOST = range(3)


def record_functions(crowded: bool) -> tuple[str, ...]:
    """`crowded`: steps have one length, and are not shortened for what jumps within them."""
    return (_hermite(), _inputs(), _gather_at(), _gather(), _take(crowded), _straighten(),
            _bend_at(), _bend(), _record(), _mark())  # fmt: skip


@function("void px_hermite(ptr m, ptr y0, ptr f0, ptr y1, ptr f1, double h, double s, ptr out)")
def _hermite(
    c: Code, m: Value, y0: Value, f0: Value, y1: Value, f1: Value, h: Value, s: Value, out: Value
) -> None:
    past = Past(c, m)
    even, odd = past.vector(EVEN), past.vector(ODD)
    rest = 1.0 - s
    bump = s * rest * s * rest
    with c.loop(past.states) as i:
        change = y1.load(REAL, i) - y0.load(REAL, i)
        inner = change * (rest - s) - h * f0.load(REAL, i) * rest + h * f1.load(REAL, i) * s
        more = bump * (even.load(REAL, i) + odd.load(REAL, i) * (s - 0.5))
        out.store(y0.load(REAL, i) + s * change - s * rest * inner + more, i)
    c.give()


@function("void px_inputs(ptr m, double s)")
def _inputs(c: Code, m: Value, s: Value) -> None:
    """Those of a part of a host's step."""
    past = Past(c, m)
    w, _, _, _ = open_frame(m)
    before, after = past.mark(2), past.ends
    with c.loop(past.inputs) as i:
        one, two = before.load(REAL, i), after.load(REAL, i)
        w.store(c.select(s >= 1.0, two, one + s * (two - one)), past.input(i))
    c.give()


@function(
    "i32 px_gather_at(ptr m, i64 place, double t, double h, double s, i64 way, ptr y0, ptr f0, "
    "ptr y1, ptr f1)"
)
def _gather_at(
    c: Code, m: Value, place: Value, t: Value, h: Value, s: Value, way: Value, *ends: Value
) -> None:
    """The signals at an inner point of a step."""
    past = Past(c, m)
    trial, there = past.vector(TRIAL), t + s * h
    with c.when(way.equals(_OWN)):
        c.run("px_between", m, there, trial)
    with c.when(way > _OWN):
        c.run("px_hermite", m, *ends, h, s, trial)
    with c.when(way.equals(_HOST)):
        c.run("px_inputs", m, s)
    flag = c.call(FLAG, "pc_outputs", m, there, trial)
    past.times.store(there, place)
    c.run("px_signals", m, past.values.at(place * past.count))
    c.give(flag)


@function(
    "i32 px_gather(ptr m, double t, double h, double end, i64 way, ptr y0, ptr f0, ptr y1, ptr f1)"
)
def _gather(c: Code, m: Value, t: Value, h: Value, end: Value, way: Value, *ends: Value) -> None:
    """The signals of a step; the workspace is that of its end."""
    past = Past(c, m)
    flag = c.variable(c.constant(0, FLAG), FLAG)
    inner = [(k, NODES[k]) for k in range(1, DEGREE)]
    inner.insert(len(inner) // 2, (TERMS, 0.5))
    for place, s in inner:
        with c.when(flag.get().equals(0)):
            part = c.constant(s, REAL)
            flag.set(c.call(FLAG, "px_gather_at", m, whole(c, place), t, h, part, way, *ends))
    inner_flag = flag.get()
    with c.when(way.equals(_HOST)):
        c.run("px_inputs", m, c.constant(1.0, REAL))
    flag.set(c.call(FLAG, "pc_outputs", m, end, ends[2]))
    last = past.each(Each.LAST)
    c.run("px_copy", past.values, last, past.count)
    c.run("px_signals", m, past.values.at(past.count * DEGREE))
    past.times.store(t)
    past.times.store(end, DEGREE)
    with c.when(~inner_flag.equals(0), leaves=True):
        c.give(inner_flag)
    c.give(flag.get())


@function("i32 px_take(ptr m, double t, double h)")
def _take(c: Code, m: Value, t: Value, h: Value, crowded: bool) -> None:
    past = Past(c, m)
    room = c.call(FLAG, "px_make_room", m, t - past.real(Head.LONGEST))
    with c.when(~room.equals(0), leaves=True):
        c.give(room)
    way = whole(c, _OWN)
    if not crowded:
        way = c.select(m.load(REAL, Own.STIFF) > 0.0, whole(c, _ENDS), way)
    c.run("px_straighten", m)
    ends = (vector(c, m, BEGIN), vector(c, m, 0), vector(c, m, END), vector(c, m, 6))
    flag = c.call(FLAG, "px_gather", m, t, h, m.load(REAL, Own.REACH), way, *ends)
    with c.when(~flag.equals(0), leaves=True):
        c.give(1)
    c.give(c.call(FLAG, "px_append", m, whole(c, not crowded)))


@function("void px_straighten(ptr m)")
def _straighten(c: Code, m: Value) -> None:
    past = Past(c, m)
    even, odd = past.vector(EVEN), past.vector(ODD)
    with c.loop(past.states) as i:
        even.store(0.0, i)
        odd.store(0.0, i)
    c.give()


@function("i32 px_bend_at(ptr m, double t, double h, double s, ptr slope)")
def _bend_at(c: Code, m: Value, t: Value, h: Value, s: Value, slope: Value) -> None:
    """The slope at a part of a host's step, and what the cubic polynomial's is less than it."""
    past = Past(c, m)
    y0, f0, y1, f1 = past.mark(0), past.mark(1), past.vector(Y1), past.vector(F1)
    trial = past.vector(TRIAL)
    c.run("px_hermite", m, y0, f0, y1, f1, h, s, trial)
    c.run("px_inputs", m, s)
    flag = c.call(FLAG, "pc_rhs", m, t + s * h, trial, slope)
    rest = 1.0 - s
    with c.loop(past.states) as i:
        change = y1.load(REAL, i) - y0.load(REAL, i)
        one, two = h * f0.load(REAL, i), h * f1.load(REAL, i)
        inner = change * (rest - s) - one * rest + two * s
        own = change + inner * (s - rest) - s * rest * (one + two - 2.0 * change)
        slope.store(h * slope.load(REAL, i) - own, i)
    c.give(flag)


@function("void px_bend(ptr m, double t, double h)")
def _bend(c: Code, m: Value, t: Value, h: Value) -> None:
    """Two terms more of the polynomial of a host's step: s^2*(1 - s)^2*(even + odd*(s - 1/2))."""
    past = Past(c, m)
    even, odd = past.vector(EVEN), past.vector(ODD)
    even_before, odd_before = past.vector(EVEN_BEFORE), past.vector(ODD_BEFORE)
    slope, n = past.vector(SLOPE), past.states
    far = 1 - _NEAR
    bump, rise = (_NEAR * far) ** 2, 2 * _NEAR * far * (far - _NEAR)
    c.run("px_straighten", m)
    good = c.variable(1, INT)
    for _ in range(2):
        c.run("px_copy", even_before, even, n)
        c.run("px_copy", odd_before, odd, n)
        first = c.call(FLAG, "px_bend_at", m, t, h, c.constant(_NEAR, REAL), slope)
        c.run("px_copy", past.vector(FIRST), slope, n)
        second = c.call(FLAG, "px_bend_at", m, t, h, c.constant(far, REAL), slope)
        with c.when(~(first.equals(0) & second.equals(0))):
            good.set(whole(c, 0))
        one = past.vector(FIRST)
        with c.loop(n) as i:
            a, b = one.load(REAL, i), slope.load(REAL, i)
            even.store((a - b) / (2 * rise), i)
            odd.store((a + b) / (2 * (bump - rise * (0.5 - _NEAR))), i)
    with c.when(good.get().equals(0)):
        c.run("px_straighten", m)
    with c.loop(n) as i:
        size = c.absolute(even_before.load(REAL, i)) + c.absolute(odd_before.load(REAL, i))
        change = c.absolute(even.load(REAL, i) - even_before.load(REAL, i))
        change = change + c.absolute(odd.load(REAL, i) - odd_before.load(REAL, i))
        with c.when(~(change <= size * _NEARER)):
            even.store(0.0, i)
            odd.store(0.0, i)
    c.give()


@function("i32 px_record(ptr m)")
def _record(c: Code, m: Value) -> None:
    """Where inner points of a step have no solution, signals are lines between its ends."""
    past = Past(c, m)
    w, _, _, _ = open_frame(m)
    t, begin = w.load(REAL), past.real(Head.UNTIL)
    h = t - begin
    with c.when(h.equals(0.0), leaves=True):
        c.give(0)
    room = c.call(FLAG, "px_make_room", m, begin - past.real(Head.LONGEST))
    with c.when(~room.equals(0), leaves=True):
        c.give(room)
    m.store(whole(c, Stale.ALL), Own.STALE)
    y, f = past.vector(Y1), past.vector(F1)
    c.run("px_copy", y, m.load(POINTER, Own.Y), past.states)
    with c.loop(past.inputs) as i:
        past.ends.store(w.load(REAL, past.input(i)), i)
    c.call(FLAG, "pc_rhs", m, t, y, f)
    with c.when(h < 0.0, leaves=True):  # the host went back
        c.call(FLAG, "pc_rest", m, t)
        c.run("px_resume", m, t)
        c.give(0)
    c.run("px_bend", m, begin, h)
    ends = (past.mark(0), past.mark(1), y, f)
    flag = c.call(FLAG, "px_gather", m, begin, h, t, whole(c, _HOST), *ends)
    with c.when(~flag.equals(0)):
        for inner, node in enumerate(NODES[1:DEGREE], 1):
            past.times.store(begin + h * node, inner)
        with c.loop(DEGREE, 1) as k, c.loop(past.count) as d:
            part = (past.times.load(REAL, k) - begin) / h
            one, two = (past.values.load(REAL, past.count * e + d) for e in (0, DEGREE))
            past.values.store(one + part * (two - one), k * past.count + d)
    c.give(c.call(FLAG, "px_append", m, whole(c, 0)))


@function("void px_mark(ptr m)")
def _mark(c: Code, m: Value) -> None:
    """The workspace is that of the present point."""
    past = Past(c, m)
    w, numbers, _, _ = open_frame(m)
    n = plan(c, Table.STATES)
    c.run("px_copy", past.mark(0), m.load(POINTER, Own.Y), n)
    with c.loop(n) as i:
        slot = numbers.at(n + int(Number.FIRST_STATE)).load(INT, i)
        past.mark(1).store(w.load(REAL, slot), i)
    with c.loop(past.inputs) as i:
        past.mark(2).store(w.load(REAL, past.input(i)), i)
    c.give()
