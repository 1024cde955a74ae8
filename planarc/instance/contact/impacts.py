"""The operator `impact` inside an exported model, in LLVM.

    px_impact(block, t)             states and modes of all touches after an event; `Own.ENDED` is
                                    set where the run cannot go on
    px_modes(block, t, k) -> flag   which of k touches hold, stick, slide and open: `Area.MODES`
    px_stop(block, k)               speeds that are held at zero are zero

What each does, and why, stands in `solve.contact.impacts`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.instance.block import larger, plan, whole
from planarc.instance.contact.access import arrays, kept, seen, slot, touches, zero
from planarc.instance.contact.area import Area, Kept, Reads, Seen
from planarc.instance.contact.asked import asked_functions
from planarc.instance.contact.cases import FREE, copy, fill, largest_of, slides
from planarc.instance.contact.touches import before_of, put
from planarc.instance.plan import Jam, Own, Table, Touch
from planarc.ir.frame import Frame
from planarc.solve.contact.impacts import (
    CLEAR,
    CREEP,
    DEEP,
    DRIFT,
    ERRS,
    EXACT,
    LIMIT,
    MORE,
    MOVED,
    MOVES,
    NEAR,
    NEGLIGIBLE,
    NOISE,
    OPEN,
    SHORT,
    SLOW,
    STEADY,
)
from planarc.solve.contact.problem import IDLE, STICKS
from planarc.solve.contact.strike import STILL
from planarc.solve.events.crossings import AHEAD


def impact_functions(asks: bool) -> tuple[str, ...]:
    """`asks`: a run in Python asks for them."""
    return (_begin(), _jam(), _spots(), _solved(), _modes(), _stop(), _set(),
            *(asked_functions() if asks else ()), _impact(asks))  # fmt: skip


@function("void px_unstruck(ptr m)", seldom=True)
def _begin(c: Code, m: Value) -> None:
    """Nothing is remembered of touches."""
    n = touches(c)
    fill(c, kept(c, m, Kept.FIRST), zero(c), n)
    fill(c, kept(c, m, Kept.FALLS), zero(c), n)
    fill(c, kept(c, m, Kept.FORCE), c.constant(1.0, REAL), n * 2)
    for which, value in ((Seen.FASTEST, 0.0), (Seen.STRONGEST, 0.0), (Seen.MOST, 0.0)):
        seen(c, m, which).store(value)
    seen(c, m, Seen.BEGINS).store(whole(c, 1))
    c.give()


@function("void px_jam(ptr m, i64 i, i64 kind)", seldom=True)
def _jam(c: Code, m: Value, i: Value, kind: Value) -> None:
    with c.when(m.load(INT, Own.ENDED).equals(0)):
        number = plan(c, Table.JAMS) + i * len(Jam) + kind
        m.store(number, Own.ENDED)
        c.run("px_values", m, number)
    c.give()


@function("void px_spots(ptr m, i64 k, i64 count)")
def _spots(c: Code, m: Value, k: Value, count: Value) -> None:
    """What is known of the touches in `Area.LIST`, as a problem."""
    here, before, listed, speeds, mu, way, slack, loose = arrays(
        m, Area.HERE, Area.BEFORE, Area.LIST, Area.SPEEDS, Area.MU, Area.WAY, Area.SLACK,
        Area.LOOSE,
    )  # fmt: skip
    fastest = seen(c, m, Seen.FASTEST).load(REAL)
    with c.loop(count) as p:
        j = listed.load(INT, p)
        i, slip = here.load(INT, j), speeds.load(REAL, k + j)
        old, rubs = before_of(c, before, Touch.WAY).load(REAL, i), before_of(c, before, Reads.MU)
        mu.store(rubs.load(REAL, i), p)
        turns = c.absolute(old).equals(1.0) & (old * slip <= 0.0)
        slow = c.select(turns | old.equals(float(STICKS)), c.constant(DRIFT, REAL), SLOW)
        still = c.absolute(slip) <= larger(c, slow * fastest, CREEP)
        moving = c.select(slip > 0.0, whole(c, 1), whole(c, -1))
        found = c.select(still, whole(c, FREE), moving)
        smooth = rubs.load(REAL, i).equals(0.0)
        way.store(c.select(smooth, whole(c, IDLE), found), p)
        own = c.select(still & ~smooth, loose.load(INT, j), whole(c, 0))
        slack.store(own, p)
    c.give()


@function("i32 px_solved(ptr m, double t, i64 k)")
def _solved(c: Code, m: Value, t: Value, k: Value) -> None:
    """The cases of the touches that may be held, all others open; accelerations in `Area.SUM`."""
    here, rests, listed, free, modes, cases, x, response, found = arrays(
        m, Area.HERE, Area.RESTS, Area.LIST, Area.FREE_HERE, Area.MODES, Area.CASES, Area.FORCES,
        Area.RESPONSE, Area.SUM,
    )  # fmt: skip
    count, wide = c.variable(0, INT), k * 2
    with c.loop(k) as j:
        modes.store(whole(c, 0), j)
        modes.store(whole(c, IDLE), k + j)
        with c.when(rests.load(INT, j).equals(1)):
            listed.store(j, count.get())
            count.set(count.get() + 1)
    n = count.get()
    c.run("px_gather", m, k, n, free)
    c.run("px_spots", m, k, n)
    noise = seen(c, m, Seen.STRONGEST).load(REAL) * NOISE
    flag = c.call(FLAG, "px_pressed", m, t, n, noise)
    with c.when(~flag.equals(0), leaves=True):
        c.give(1)
    copy(c, found, free, wide)
    with c.loop(n) as p:
        j = listed.load(INT, p)
        joint = slot(c, here.load(INT, j), Touch.JOINT)
        held = c.select(joint.equals(1), joint, cases.load(INT, p))
        modes.store(held, j)
        modes.store(cases.load(INT, n + p), k + j)
        for to, force in ((j, x.load(REAL, p)), (k + j, x.load(REAL, n + p))):
            with c.loop(wide) as r:
                change = response.load(REAL, r * wide + to) * force
                found.store(found.load(REAL, r) + change, r)
    c.give(0)


@function("i32 px_modes(ptr m, double t, i64 k)")
def _modes(c: Code, m: Value, t: Value, k: Value) -> None:
    """For how long each touch that begins to rest still bounces stands in `Area.TIMES`."""
    here, before, speeds, still, rests, times, found = arrays(
        m, Area.HERE, Area.BEFORE, Area.SPEEDS, Area.STILL, Area.RESTS, Area.TIMES, Area.SUM
    )
    first, falling = kept(c, m, Kept.FIRST), kept(c, m, Kept.FALLS)
    tolerance = m.load(REAL, Own.TOLERANCE)
    lowest = c.call(REAL, "pow", tolerance, c.constant(1 / 3, REAL))
    short = m.load(REAL, Own.AHEAD) * (SHORT / AHEAD)
    with c.loop(k) as j:
        may = speeds.load(REAL, j) <= still.load(REAL, j)
        rests.store(c.select(may, whole(c, 1), whole(c, 0)), j)
        times.store(-1.0, j)
    done = c.variable(0, INT)
    with c.loop(k + 1), c.when(done.get().equals(0)):
        with c.when(~c.call(FLAG, "px_solved", m, t, k).equals(0), leaves=True):
            c.give(1)
        done.set(whole(c, 1))
        with c.loop(k) as j:
            i, v = here.load(INT, j), speeds.load(REAL, j)
            e = before_of(c, before, Reads.E).load(REAL, i)
            falls = zero(c) - found.load(REAL, j)
            comes = rests.load(INT, j).equals(0) & (e < 1.0) & (falls > 0.0)
            with c.when(comes):
                lasts = v * 2.0 / (falls * (1.0 - e))
                greatest, last = first.load(REAL, i), falling.load(REAL, i)
                steady = c.absolute(falls - last) <= falls * STEADY
                low = lowest * greatest
                least = c.select(steady, greatest * EXACT, low)
                clear = c.call(REAL, "llvm.sqrt.f64", falls * (2 * CLEAR))
                limit = larger(c, e * larger(c, least, low), clear)
                falling.store(falls, i)
                with c.when((v < limit) | (lasts < short)):
                    times.store(lasts, j)
                    rests.store(whole(c, 1), j)
                    done.set(whole(c, 0))
    c.give(0)


@function("void px_stop(ptr m, i64 k)")
def _stop(c: Code, m: Value, k: Value) -> None:
    here, before, speeds, still, modes, listed = arrays(
        m, Area.HERE, Area.BEFORE, Area.SPEEDS, Area.STILL, Area.MODES, Area.LIST
    )
    mu, way, cases, x, u, response = arrays(
        m, Area.MU, Area.WAY, Area.CASES, Area.FORCES, Area.MOTION, Area.RESPONSE
    )
    wide = k * 2
    with c.loop(k) as j:
        listed.store(j, j)
    c.run("px_gather", m, k, k, speeds)
    with c.loop(k) as j:
        mu.store(before_of(c, before, Reads.MU).load(REAL, here.load(INT, j)), j)
        own = modes.load(INT, k + j)
        own = c.select(slides(own), whole(c, IDLE), own)
        way.store(own, j)
        cases.store(modes.load(INT, j), j)
        cases.store(own, k + j)
    with c.when(c.call(FLAG, "px_case", m, k).equals(0)):
        c.call(FLAG, "px_shift", m, k, k, x)
        copy(c, speeds, u, wide)
    count, some = c.variable(0, INT), c.variable(0, INT)
    with c.loop(k) as j:
        v, limit = speeds.load(REAL, j), still.load(REAL, j)
        joint = slot(c, here.load(INT, j), Touch.JOINT).equals(1)
        with c.when((v <= limit) & ~joint):  # it is not held, and must not go on approaching
            listed.store(j, count.get())
            mu.store(0.0, count.get())
            way.store(whole(c, IDLE), count.get())
            count.set(count.get() + 1)
            with c.when(v < limit * (-STILL)):
                some.set(whole(c, 1))
    with c.when(some.get().equals(1)):
        n = count.get()
        c.run("px_gather", m, k, n, speeds)
        flag = c.call(FLAG, "px_forces", m, n, zero(c))
        with c.when(flag.equals(0)):
            c.call(FLAG, "px_shift", m, k, n, x)
            with c.loop(n) as p, c.loop(wide) as r:
                j = listed.load(INT, p)
                change = response.load(REAL, r * wide + j) * x.load(REAL, p)
                speeds.store(speeds.load(REAL, r) + change, r)
    c.give()


@function("void px_set_modes(ptr m, double t, i64 k, i64 struck)", seldom=True)
def _set(c: Code, m: Value, t: Value, k: Value, struck: Value) -> None:
    here, before, speeds, still, modes, times, impulses, response = arrays(
        m, Area.HERE, Area.BEFORE, Area.SPEEDS, Area.STILL, Area.MODES, Area.TIMES, Area.IMPULSES,
        Area.RESPONSE,
    )  # fmt: skip
    w = m.load(POINTER, Frame.W)
    for name, value in OPEN.items():
        put(c, m, Touch[name.upper()], value)
    tolerance = m.load(REAL, Own.TOLERANCE)
    wide, errors = larger(c, tolerance, CLEAR), larger(c, tolerance, CREEP)
    with c.loop(k) as j:
        i = here.load(INT, j)
        gap, low = before_of(c, before, Reads.GAP).load(REAL, i), before_of(c, before, Touch.LOW)
        held = ~before_of(c, before, Touch.HELD).load(REAL, i).equals(0.0)
        closed = modes.load(INT, j).equals(1)
        rests = speeds.load(REAL, j) <= still.load(REAL, j)
        after = c.select(rests, c.constant(CLEAR, REAL), 0.0)
        clear = c.select(struck.equals(1), after, wide)
        x = impulses.load(REAL, j)
        felt = response.load(REAL, j * k * 2 + j) * x > errors
        w.store(c.select(felt, x, zero(c)), slot(c, i, Touch.IMPULSE))
        w.store(c.select(gap < 0.0, gap, 0.0) - clear, slot(c, i, Touch.LOW))
        with c.when(closed):
            w.store(1.0, slot(c, i, Touch.HELD))
            w.store(c.real(modes.load(INT, k + j)), slot(c, i, Touch.WAY))
            w.store(c.select(held, low.load(REAL, i), gap), slot(c, i, Touch.LOW))
            with c.when(~held):
                w.store(t + larger(c, times.load(REAL, j), zero(c)), slot(c, i, Touch.REST))
    c.give()


@function("void px_impact(ptr m, double t)", seldom=True)
def _impact(c: Code, m: Value, t: Value, asks: bool) -> None:
    n, tolerance = touches(c), m.load(REAL, Own.TOLERANCE)
    w = m.load(POINTER, Frame.W)
    now, before, here, free, response, speeds, still, loose = arrays(
        m, Area.NOW, Area.BEFORE, Area.HERE, Area.FREE, Area.RESPONSE, Area.SPEEDS, Area.STILL,
        Area.LOOSE,
    )  # fmt: skip
    impulses, fastest, own_free, listed, total = arrays(
        m, Area.IMPULSES, Area.FASTEST, Area.FREE_HERE, Area.LIST, Area.SUM
    )

    def end(i: Value | int, kind: Jam) -> None:
        place = whole(c, i) if isinstance(i, int) else i
        c.run("px_jam", m, place, whole(c, kind))
        c.give()

    def see() -> None:
        with c.when(~c.call(FLAG, "px_see", m, t).equals(0), leaves=True):
            end(0, Jam.UNSOLVED)

    see()
    copy(c, before, now, n * len(Reads))
    with c.loop(n) as i:
        for place in Touch:
            if place is not Touch.JOINT:
                before_of(c, before, place).store(w.load(REAL, slot(c, i, place)), i)
    gap, v, slip, held, low = (
        before_of(c, before, which)
        for which in (Reads.GAP, Reads.V, Reads.SLIP, Touch.HELD, Touch.LOW)
    )
    if asks:
        copy(c, arrays(m, Area.HELD)[0], held, n)
    begins = seen(c, m, Seen.BEGINS)
    least = c.select(begins.load(INT).equals(1), c.constant(DEEP, REAL), larger(c, tolerance, DEEP))
    begins.store(whole(c, 0))
    most = seen(c, m, Seen.FASTEST)
    largest = larger(c, largest_of(c, v, n), largest_of(c, slip, n))
    errors = larger(c, tolerance * ERRS, MOVES)
    moves = larger(c, most.load(REAL), largest) * MOVED + errors
    with c.loop(n) as i:
        deepest = c.select(low.load(REAL, i) < 0.0, low.load(REAL, i), 0.0) * MORE - least
        parted = gap.load(REAL, i) - low.load(REAL, i)
        with c.when(held.load(REAL, i).equals(0.0) & (parted < deepest), leaves=True):
            end(i, Jam.OVERLAP)
    count = c.variable(0, INT)
    with c.loop(n) as i:
        with c.when(c.absolute(v.load(REAL, i)) > moves):
            held.store(0.0, i)
        with c.when(~held.load(REAL, i).equals(0.0) | (gap.load(REAL, i) <= NEAR)):
            here.store(i, count.get())
            count.set(count.get() + 1)
    k = count.get()
    if asks:
        seen(c, m, Seen.SHARP).store(1.0)
    with c.when(k.equals(0), leaves=True):
        for name, value in OPEN.items():
            put(c, m, Touch[name.upper()], value)
        c.give()
    way, f_n, f_t, mu = (
        before_of(c, before, which) for which in (Touch.WAY, Reads.F_N, Reads.F_T, Reads.MU)
    )

    def is_held(i: Value) -> Value:
        return ~held.load(REAL, i).equals(0.0)

    def is_stuck(i: Value) -> Value:
        return is_held(i) & way.load(REAL, i).equals(float(STICKS))

    with c.loop(k) as j:
        i = here.load(INT, j)
        for speed in (v, slip):
            most.store(larger(c, most.load(REAL), c.absolute(speed.load(REAL, i))))
        limit = mu.load(REAL, i) * f_n.load(REAL, i) * (1 - LIMIT)
        rubs = is_held(i) & ~way.load(REAL, i).equals(float(IDLE))
        slack = rubs & (c.absolute(f_t.load(REAL, i)) >= limit)
        loose.store(c.select(slack, whole(c, 1), whole(c, 0)), j)
    with c.when(~c.call(FLAG, "px_respond", m, t, k).equals(0), leaves=True):
        end(0, Jam.UNSOLVED)
    wide, first = k * 2, kept(c, m, Kept.FIRST)
    pressing, strongest = largest_of(c, f_n, n), largest_of(c, free, n * 2, 1.0)
    pressing = c.select(pressing.equals(0.0), c.constant(1.0, REAL), pressing)
    effect = seen(c, m, Seen.MOST).load(REAL)
    scale = c.select(effect * pressing > strongest * NEGLIGIBLE, effect, strongest / pressing)
    with c.loop(k) as j:
        i = here.load(INT, j)
        with c.when(slot(c, i, Touch.JOINT).equals(1)):  # as if a force of its own met a limit
            response.store(scale, j * wide + j)
        speeds.store(c.select(is_held(i), zero(c), v.load(REAL, i)), j)
        speeds.store(slip.load(REAL, i), k + j)
        errors = tolerance * first.load(REAL, i)  # of a run make such speeds
        still.store(larger(c, errors, largest * STILL), j)
        size = c.variable(0.0)
        with c.loop(wide) as r:
            size.set(larger(c, size.get(), c.absolute(response.load(REAL, r * wide + j))))
        with c.when(size.get().equals(0.0), leaves=True):
            end(i, Jam.ONE_BODY)
    with c.when(~c.call(FLAG, "px_strike", m, k).equals(0), leaves=True):
        end(here.load(INT), Jam.NO_IMPACT)
    struck = c.variable(0, INT)
    with c.loop(k) as j:
        i = here.load(INT, j)
        listed.store(j, j)
        first.store(larger(c, first.load(REAL, i), fastest.load(REAL, j)), i)
        for row in (j, k + j):
            with c.when(~impulses.load(REAL, row).equals(0.0)):
                struck.set(whole(c, 1))
    with c.when(~c.call(FLAG, "px_shift", m, k, k, impulses).equals(0), leaves=True):
        end(here.load(INT), Jam.NO_IMPACT)
    strongest = seen(c, m, Seen.STRONGEST)
    strongest.store(larger(c, strongest.load(REAL), largest_of(c, free, n * 2)))
    copy(c, total, free, n * 2)
    with c.when(struck.get().equals(1)):
        see()
        if asks:
            c.run("px_refine", m, k)
        c.run("px_motion", m, total)
    with c.loop(k) as j:
        i = here.load(INT, j)
        # What is held and not struck does not rest, but makes good its errors.
        kept_so = struck.get().equals(0)
        for row, at, which, stays in (
            (j, i, Reads.A, is_held(i)),
            (k + j, n + i, Reads.A_SLIP, is_stuck(i)),
        ):
            error = c.select(kept_so & stays, before_of(c, before, which).load(REAL, i), zero(c))
            own_free.store(total.load(REAL, at) - error, row)
    with c.when(~c.call(FLAG, "px_modes", m, t, k).equals(0), leaves=True):
        end(here.load(INT), Jam.NO_FORCES)
    c.run("px_stop", m, k)
    c.run("px_set_modes", m, t, k, struck.get())
    if asks:
        seen(c, m, Seen.SHARP).store(c.call(REAL, "px_height", m, k))
        c.run("px_note_strike", m)
    c.give()
