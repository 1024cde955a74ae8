"""The impulses of all contacts at once, in LLVM.

    px_impulses(block, h, count)             so that no gap is negative at the end of the step
    px_moved_by(block, count, out)           out += what the impulses do to the states
    px_clear_gaps(block, h, count) -> flag   others, with which what came too far goes back; 0:
                                             nothing did
    px_recall(block, count)                  those of the step before, where contacts are the same
    px_keep_impulses(block, count)
    px_doubt(block, h, count) -> flag        whether a contact is deeper than it moves in the step,
                                             by more than `Own.TOLERANCE`

Reference: `solve.stepping.struck`, `solve.stepping.impulses`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.instance.block import plan, whole
from planarc.instance.crowd.layout import (
    Area,
    Count,
    Kept,
    Part,
    arrays,
    kept,
    part,
    said,
)
from planarc.instance.plan import Own, Table
from planarc.solve.contact.impacts import DEEP
from planarc.solve.stepping.impulses import MOST_SWEEPS
from planarc.solve.stepping.struck import LEFT, PARTS, ROUNDING, SLOW


def impulse_functions(doubts: bool = False) -> tuple[str, ...]:
    """`doubts`: Python decides where contacts find no room."""
    asked = (_doubt(),) if doubts else ()
    return (_product(), _sweep(), _impulses(), _moved_by(), _clear(), _recall(), _keep(),
            *asked)  # fmt: skip


@function("void px_product(i64 rows, ptr starts, ptr columns, ptr values, ptr x, ptr out)")
def _product(
    c: Code, rows: Value, starts: Value, columns: Value, values: Value, x: Value, out: Value
) -> None:
    """A sparse matrix times x."""
    with c.loop(rows) as i:
        total = c.variable(0.0)
        with c.loop(starts.load(INT, i + 1), starts.load(INT, i)) as k:
            total.set(total.get() + values.load(REAL, k) * x.load(REAL, columns.load(INT, k)))
        out.store(total.get(), i)
    c.give()


@function("void px_sweeps(ptr m, ptr mu, i64 count, double left)")
def _sweep(c: Code, m: Value, mu: Value, count: Value, left: Value) -> None:
    starts, columns, values, rest, inverse, x = arrays(
        m, Area.A_STARTS, Area.A_COLUMNS, Area.A_VALUES, Area.REST, Area.INVERSE, Area.X
    )
    c.call(FLAG, "pc_sweep", starts, columns, values, rest, mu, inverse, x, count,
           whole(c, MOST_SWEEPS), left)  # fmt: skip
    c.give()


def _all(c: Code, m: Value) -> tuple[Value, Value, Value]:
    """The matrix of all contacts."""
    starts, columns, values = arrays(m, Area.A_STARTS, Area.A_COLUMNS, Area.A_VALUES)
    return starts, columns, values


def _left(c: Code, m: Value, count: Value) -> tuple[Value, Value]:
    """What free motion adds in the step, and velocities that are none."""
    u, gained = arrays(m, Area.U, Area.GAINED)
    most, fastest = c.variable(0.0), c.variable(0.0)
    with c.loop(count * 2) as i:
        speed = gained.load(REAL, i)
        change = c.absolute(speed - u.load(REAL, i))
        most.set(c.select(change > most.get(), change, most.get()))
        size = c.absolute(speed)
        fastest.set(c.select(size > fastest.get(), size, fastest.get()))
    return most.get(), most.get() * LEFT + fastest.get() * 1e-12


@function("void px_impulses(ptr m, double h, i64 count)")
def _impulses(c: Code, m: Value, h: Value, count: Value) -> None:
    """In `Area.X`, from those there on, with the motion behind them and what pressed on ports."""
    u, free, x, way, rest, inverse, least, bounces, gap, e, mu = arrays(
        m, Area.U, Area.GAINED, Area.X, Area.WAY, Area.REST, Area.INVERSE, Area.LEAST,
        Area.BOUNCES, Area.GAP, Area.E, Area.MU,
    )  # fmt: skip
    before, after, impulse = arrays(m, Area.VELOCITIES, Area.AFTER, Area.IMPULSE)
    j = arrays(m, Area.J_STARTS, Area.J_COLUMNS, Area.J_VALUES)
    t = arrays(m, Area.T_STARTS, Area.T_COLUMNS, Area.T_VALUES)
    a, rows = _all(c, m), count * 2
    c.run("px_product", rows, *j, before, u)
    c.run("px_product", rows, *j, after, free)
    gained, left = _left(c, m, count)
    resting = c.variable(0.0)
    with c.loop(rows) as i:
        diagonal = c.variable(0.0)
        entries = c.loop(a[0].load(INT, i + 1), a[0].load(INT, i))
        with entries as k, c.when(a[1].load(INT, k).equals(i)):
            diagonal.set(a[2].load(REAL, k))
        own = diagonal.get()
        by = c.select(own > 0.0, 1.0 / c.select(own > 0.0, own, 1.0), 0.0)
        inverse.store(by, i)
        with c.when((i - i / 2 * 2).equals(0)):
            resting.set(resting.get() + by)
    with c.loop(count) as k:
        closing = (c.constant(-2.0, REAL) / h) * gap.load(REAL, k)
        least.store(c.select(closing < 0.0, closing, 0.0), k)
        meets = gap.load(REAL, k) + h * 0.5 * free.load(REAL, k * 2) < 0.0
        bounce = (u.load(REAL, k * 2) < gained * -SLOW) & meets
        bounces.store(c.emit(INT, f"zext i1 {bounce.text} to i64"), k)
    place = c.place(REAL, len(PARTS))
    for number, share in enumerate(PARTS):
        place.store(-share, number)
    done = c.variable(0, INT)
    with c.loop(len(PARTS)) as turn, c.when(done.get().equals(0)):
        back = place.load(REAL, turn)
        with c.loop(count) as k:
            own = least.load(REAL, k)
            speed = back * e.load(REAL, k) * u.load(REAL, k * 2)
            speed = c.select(speed > own, speed, own)
            speed = c.select(bounces.load(INT, k).equals(1), speed, own)
            rest.store(free.load(REAL, k * 2) - speed, k * 2)
            rest.store(free.load(REAL, k * 2 + 1), k * 2 + 1)
        c.run("px_sweeps", m, mu, count, left)
        c.run("px_product", rows, *a, x, way)
        work, size = c.variable(0.0), c.variable(0.0)
        with c.loop(rows) as i:
            way.store(way.load(REAL, i) + free.load(REAL, i), i)
            own = x.load(REAL, i) * (u.load(REAL, i) + way.load(REAL, i))
            work.set(work.get() + own)
            size.set(size.get() + c.absolute(own))
        lost = size.get() * ROUNDING + gained * gained * resting.get()
        with c.when(work.get() <= lost):  # none, but for what a step gains and loses
            done.set(whole(c, 1))
    c.run("px_product", said(c, Count.PORTS), *t, x, impulse)
    c.give()


@function("void px_moved_by(ptr m, i64 count, ptr out)")
def _moved_by(c: Code, m: Value, count: Value, out: Value) -> None:
    x, pressed, values, candidate = arrays(m, Area.X, Area.FORCES, Area.STATES, Area.CANDIDATE)
    t = arrays(m, Area.T_STARTS, Area.T_COLUMNS, Area.T_VALUES)
    starts, felt = part(c, Part.STATE_STARTS), part(c, Part.STATE_FELT)
    c.run("px_product", said(c, Count.PORTS), *t, x, pressed)
    with c.loop(plan(c, Table.STATES)) as i:
        row, total = candidate.load(INT, i), c.variable(0.0)
        with c.loop(starts.load(INT, row + 1), starts.load(INT, row)) as k:
            by = pressed.load(REAL, felt.load(INT, k))
            total.set(total.get() + values.load(REAL, k) * by)
        out.store(out.load(REAL, i) + total.get(), i)
    c.give()


@function("i32 px_clear_gaps(ptr m, double h, i64 count)")
def _clear(c: Code, m: Value, h: Value, count: Value) -> None:
    x, way, rest, gap, least = arrays(m, Area.X, Area.WAY, Area.REST, Area.GAP, Area.LEAST)
    _, left = _left(c, m, count)
    deepest = c.variable(0.0)
    with c.loop(count) as k:
        own = way.load(REAL, k * 2) + (c.constant(2.0, REAL) / h) * gap.load(REAL, k)
        deepest.set(c.select(own < deepest.get(), own, deepest.get()))
        rest.store(own, k * 2)
        rest.store(way.load(REAL, k * 2 + 1), k * 2 + 1)
    with c.when(deepest.get() >= left * -2.0, leaves=True):
        c.give(0)
    with c.loop(count) as k:
        least.store(0.0, k)  # friction
    with c.loop(count * 2) as i:
        x.store(0.0, i)
    c.run("px_sweeps", m, least, count, left)
    c.give(1)


@function("void px_recall(ptr m, i64 count)")
def _recall(c: Code, m: Value, count: Value) -> None:
    """Keys rise in both."""
    known, room = kept(m), said(c, Count.ROOM)
    key, x = arrays(m, Area.KEY, Area.X)
    keys, number, at = known.at(Kept.FIRST), known.load(INT, Kept.COUNT), c.variable(0, INT)
    with c.loop(count) as k:
        wanted = key.load(INT, k)
        again, looks, moves, behind = (c.label() for _ in range(4))
        c.enter(again)
        c.branch(at.get() < number, looks, behind)
        c.begin(looks)
        c.branch(keys.load(INT, at.get()) < wanted, moves, behind)
        c.begin(moves)
        at.set(at.get() + 1)
        c.jump(again)
        c.begin(behind)
        place = at.get()
        with c.when(place < number), c.when(keys.load(INT, place).equals(wanted)):
            for way in (0, 1):
                x.store(keys.load(REAL, room * (way + 1) + place), k * 2 + way)
    c.give()


@function("void px_keep_impulses(ptr m, i64 count)")
def _keep(c: Code, m: Value, count: Value) -> None:
    """Those that press, as far as there is room."""
    known, room = kept(m), said(c, Count.ROOM)
    key, x = arrays(m, Area.KEY, Area.X)
    keys, number = known.at(Kept.FIRST), c.variable(0, INT)
    with c.loop(count) as k:
        presses = ~(x.load(REAL, k * 2).equals(0.0) & x.load(REAL, k * 2 + 1).equals(0.0))
        with c.when(presses & (number.get() < room)):
            place = number.get()
            keys.store(key.load(INT, k), place)
            for way in (0, 1):
                keys.store(x.load(REAL, k * 2 + way), room * (way + 1) + place)
            number.set(place + 1)
    known.store(number.get(), Kept.COUNT)
    c.give()


@function("i32 px_doubt(ptr m, double h, i64 count)")
def _doubt(c: Code, m: Value, h: Value, count: Value) -> None:
    gap, before, after = arrays(m, Area.GAP, Area.U, Area.WAY)
    with c.loop(count) as k:
        fastest = c.variable(0.0)
        for speeds in (before, after):
            for row in (0, 1):
                speed = c.absolute(speeds.load(REAL, k * 2 + row))
                fastest.set(c.select(speed > fastest.get(), speed, fastest.get()))
        end = gap.load(REAL, k) + h * 0.5 * after.load(REAL, k * 2)
        depth = 0 - end - h * fastest.get() - DEEP
        with c.when(depth > m.load(REAL, Own.TOLERANCE), leaves=True):
            c.give(1)
    c.give(0)
