"""An impact inside an exported model: touches that approach are struck until none does.

    px_gather(block, k, count, speeds)            the problem of the touches in `Area.LIST`
    px_together(block, count, noise) -> flag      those are struck together: `Area.SUM`
    px_strike(block, k) -> flag                   `Area.IMPULSES`, and `Area.SPEEDS` after them

The law, and how energy bounds restitution, stand in `solve.contact.strike`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.instance.block import larger, whole
from planarc.instance.contact.access import arrays, slot, zero
from planarc.instance.contact.area import Area, Reads
from planarc.instance.contact.cases import FREE, copy, fill
from planarc.instance.contact.touches import read_of
from planarc.instance.plan import Touch
from planarc.solve.contact.problem import IDLE
from planarc.solve.contact.strike import HALVINGS, MOST_BLOWS, STILL

#: Work below this part of what all impulses do is rounding.
_WORK = 1e-12


def blow_functions() -> tuple[str, ...]:
    return _gather(), _released(), _gained(), _together(), _strike()


@function("void px_gather(ptr m, i64 k, i64 count, ptr speeds)")
def _gather(c: Code, m: Value, k: Value, count: Value, speeds: Value) -> None:
    response, matrix, given, listed, floor, slack = arrays(
        m, Area.RESPONSE, Area.MATRIX, Area.GIVEN, Area.LIST, Area.FLOOR, Area.SLACK
    )
    wide = count * 2

    def home(p: Value) -> Value:
        along = p >= count
        j = listed.load(INT, p - c.select(along, count, whole(c, 0)))
        return j + c.select(along, k, whole(c, 0))

    with c.loop(wide) as p:
        row = home(p)
        given.store(speeds.load(REAL, row), p)
        with c.loop(wide) as q:
            matrix.store(response.load(REAL, row * k * 2 + home(q)), p * wide + q)
    fill(c, floor, zero(c), count)
    fill(c, slack, whole(c, 0), count)
    c.give()


@function("i32 px_released(ptr m, i64 count, double noise, double part)")
def _released(c: Code, m: Value, count: Value, noise: Value, part: Value) -> None:
    """The second phase, with a part of the restitution: both phases' impulses."""
    floor, restitution, pressed, speeds, given, total, x = arrays(
        m, Area.FLOOR, Area.RESTITUTION, Area.PRESSED, Area.PRESSED_SPEEDS, Area.GIVEN, Area.SUM,
        Area.FORCES,
    )  # fmt: skip
    with c.loop(count) as p:
        least = part * restitution.load(REAL, p) * pressed.load(REAL, p)
        floor.store(larger(c, least, zero(c)), p)
    copy(c, given, speeds, count * 2)
    with c.when(~c.call(FLAG, "px_forces", m, count, noise).equals(0), leaves=True):
        c.give(1)
    with c.loop(count * 2) as p:
        total.store(pressed.load(REAL, p) + x.load(REAL, p), p)
    c.give(0)


@function("i64 px_gained(ptr m, i64 count)")
def _gained(c: Code, m: Value, count: Value) -> None:
    """Whether the impulses leave more energy than there was."""
    matrix, total, before = arrays(m, Area.MATRIX, Area.SUM, Area.STRUCK_SPEEDS)
    wide, work, size = count * 2, c.variable(0.0), c.variable(0.0)
    with c.loop(wide) as p:
        speed = c.variable(before.load(REAL, p) * 2.0)
        with c.loop(wide) as q:
            change = matrix.load(REAL, p * wide + q) * total.load(REAL, q)
            speed.set(speed.get() + change)
        own = total.load(REAL, p) * speed.get()
        work.set(work.get() + own)
        size.set(size.get() + c.absolute(own))
    c.give(c.select(work.get() > size.get() * _WORK, whole(c, 1), whole(c, 0)))


@function("i32 px_together(ptr m, i64 count, double noise)")
def _together(c: Code, m: Value, count: Value, noise: Value) -> None:
    given, x, u, restitution, pressed, speeds, before, total, best = arrays(
        m, Area.GIVEN, Area.FORCES, Area.MOTION, Area.RESTITUTION, Area.PRESSED,
        Area.PRESSED_SPEEDS, Area.STRUCK_SPEEDS, Area.SUM, Area.BEST_SUM,
    )  # fmt: skip
    wide, some = count * 2, c.variable(0, INT)
    copy(c, before, given, wide)
    with c.when(~c.call(FLAG, "px_forces", m, count, noise).equals(0), leaves=True):
        c.give(1)
    copy(c, total, x, wide)
    with c.loop(count) as p, c.when(~restitution.load(REAL, p).equals(0.0)):
        some.set(whole(c, 1))
    with c.when(some.get().equals(0), leaves=True):
        c.give(0)
    copy(c, pressed, x, wide)
    copy(c, speeds, u, wide)
    one = c.constant(1.0, REAL)
    flag = c.call(FLAG, "px_released", m, count, noise, one)
    with c.when(~flag.equals(0), leaves=True):
        c.give(1)
    with c.when(c.call(INT, "px_gained", m, count).equals(0), leaves=True):
        c.give(0)
    low, high = c.variable(0.0), c.variable(1.0)
    copy(c, best, pressed, wide)
    with c.loop(HALVINGS):
        part = (low.get() + high.get()) * 0.5
        flag, fits = c.call(FLAG, "px_released", m, count, noise, part), c.variable(0, INT)
        with c.when(flag.equals(0)):
            fits.set(whole(c, 1) - c.call(INT, "px_gained", m, count))
        good = fits.get().equals(1)
        with c.when(good):
            copy(c, best, total, wide)
        low.set(c.select(good, part, low.get()))
        high.set(c.select(good, high.get(), part))
    copy(c, total, best, wide)
    c.give(0)


@function("i32 px_strike(ptr m, i64 k)")
def _strike(c: Code, m: Value, k: Value) -> None:
    """`Area.FASTEST` keeps the greatest speeds of approach."""
    here, speeds, still, response, impulses, fastest, listed, total = arrays(
        m, Area.HERE, Area.SPEEDS, Area.STILL, Area.RESPONSE, Area.IMPULSES, Area.FASTEST,
        Area.LIST, Area.SUM,
    )  # fmt: skip
    before, mu, way, restitution = arrays(m, Area.BEFORE, Area.MU, Area.WAY, Area.RESTITUTION)
    wide = k * 2
    fill(c, impulses, zero(c), wide)
    fill(c, fastest, zero(c), k)

    def own(j: Value) -> Value:  # joints do not rub in an impact
        return slot(c, here.load(INT, j), Touch.JOINT).equals(0)

    def coefficient(which: Reads, j: Value) -> Value:
        return read_of(c, before, which).load(REAL, here.load(INT, j))

    with c.loop(2 * MOST_BLOWS) as blows:
        last = blows >= MOST_BLOWS
        largest, noise = c.variable(0.0), c.variable(1e300)
        some, count = c.variable(0, INT), c.variable(0, INT)
        with c.loop(k) as j, c.when(own(j)):
            for place in (j, k + j):
                largest.set(larger(c, largest.get(), c.absolute(speeds.load(REAL, place))))
        rounding = largest.get() * STILL
        with c.loop(k) as j, c.when(own(j)):
            limit, v = larger(c, still.load(REAL, j), rounding), speeds.load(REAL, j)
            noise.set(c.select(limit < noise.get(), limit, noise.get()))
            with c.when(v < zero(c) - limit):
                some.set(whole(c, 1))
            e = coefficient(Reads.E, j)
            struck = (v < zero(c) - limit) | ((v <= limit) & e.equals(0.0))
            bears = (v <= limit) | (impulses.load(REAL, j) > 0.0)
            with c.when((struck & ~last) | (bears & last)):
                listed.store(j, count.get())
                restitution.store(c.select(last, zero(c), e), count.get())
                rubs = coefficient(Reads.MU, j)
                mu.store(rubs, count.get())
                free = c.select(rubs > 0.0, whole(c, FREE), whole(c, IDLE))
                way.store(free, count.get())
                count.set(count.get() + 1)
        with c.when(some.get().equals(0), leaves=True):
            c.give(0)
        with c.loop(k) as j, c.when(own(j)):
            approach = zero(c) - speeds.load(REAL, j)
            fastest.store(larger(c, fastest.load(REAL, j), approach), j)
        n = count.get()
        c.run("px_gather", m, k, n, speeds)
        flag = c.call(FLAG, "px_together", m, n, noise.get())
        with c.when(~flag.equals(0), leaves=True):
            c.give(1)
        with c.loop(n) as p:
            j = listed.load(INT, p)
            for to, x in ((j, total.load(REAL, p)), (k + j, total.load(REAL, n + p))):
                impulses.store(impulses.load(REAL, to) + x, to)
                with c.loop(wide) as r:
                    change = response.load(REAL, r * wide + to) * x
                    speeds.store(speeds.load(REAL, r) + change, r)
    c.give(1)
