"""Bodies of crowds that are near each other, and where they would touch, in LLVM.

    px_lie(block)                                where all bodies and touches are
    px_meet(block, first, second, end) -> gap    one meeting, in `Area.FOUND`
    px_contacts(block, h, fill) -> count         what is closed, or may close within a step
    px_apart(block) -> flag                      whether no two bodies begin in each other

A pair is looked at from both sides: where its first member is a circle, or both are bars. So
contacts stand in the order of their keys.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import whole
from planarc.instance.crowd.layout import (
    Area,
    Count,
    Met,
    Of,
    Part,
    arrays,
    part,
    said,
)
from planarc.instance.plan import LETTERS, Jam, Own
from planarc.instance.relations import attempt, word
from planarc.instance.settling import ACTED
from planarc.solve.contact.impacts import DEEP
from planarc.solve.stepping.angles import COSINE, PARTS, QUARTERS, ROUNDER, SINE
from planarc.solve.stepping.moreau import FAR

#: More than what may be rounding, in what is only looked at first.
_SLACK = 1.0 + 1e-9


def meeting_functions() -> tuple[str, ...]:
    return _lie(), _meet(), _is_pair(), _contacts(), _touching(), _among(), _closes(), _apart()


def root(c: Code, x: Value) -> Value:
    return c.call(REAL, "llvm.sqrt.f64", x)


def _of(c: Code, m: Value, *which: Of) -> list[Value]:
    """Arrays of what members read."""
    (bodies,) = arrays(m, Area.BODIES)
    return [bodies.at(said(c, Count.MEMBERS) * int(w)) for w in which]


@function("void px_lie(ptr m)")
def _lie(c: Code, m: Value) -> None:
    bodies, gaps, ends, middle, bound, bar = arrays(
        m, Area.BODIES, Area.GAPS, Area.ENDS, Area.MIDDLE, Area.BOUND, Area.BAR
    )
    n = said(c, Count.MEMBERS)
    c.run("px_collect", m, part(c, Part.MEMBERS), n * len(Of), bodies)
    c.run("px_collect", m, part(c, Part.OF_TOUCHES), said(c, Count.TOUCHES) * 3, gaps)
    x, y, phi, *lines, radius, _, _ = _of(c, m, *Of)
    with c.loop(n) as i:
        u, v, to_u, to_v = (line.load(REAL, i) for line in lines)
        sine, cosine = _turned(c, phi.load(REAL, i))
        place = ends.at(i * 4)
        for k, (p, q) in enumerate(((u, v), (to_u, to_v))):
            place.store(x.load(REAL, i) + cosine * p - sine * q, 2 * k)
            place.store(y.load(REAL, i) + sine * p + cosine * q, 2 * k + 1)
        for k in (0, 1):
            middle.store((place.load(REAL, k) + place.load(REAL, k + 2)) * 0.5, i * 2 + k)
        along, across = to_u - u, to_v - v
        length = root(c, along * along + across * across)
        bound.store(length * 0.5 + radius.load(REAL, i), i)
        bar.store(word(c, length > 0.0), i)
    c.give()


def _turned(c: Code, angle: Value) -> tuple[Value, Value]:
    """Sine and cosine, as of `solve.stepping.angles`."""
    k = angle * QUARTERS + ROUNDER - ROUNDER
    x = angle
    for share in PARTS:
        x = x - k * share
    z = x * x

    def series(coefficients: tuple[float, ...]) -> Value:
        total = c.constant(coefficients[-1], REAL)
        for coefficient in reversed(coefficients[:-1]):
            total = total * z + coefficient
        return total

    sine, cosine = x + x * z * series(SINE), 1.0 - (z * 0.5 - z * z * series(COSINE))
    number = c.whole(k)
    quarter = c.emit(INT, f"and i64 {number.text}, 3")
    odd = c.emit(INT, f"and i64 {number.text}, 1").equals(1)
    back = c.select(quarter >= 2, c.constant(-1.0, REAL), 1.0)
    return c.select(odd, cosine, sine) * back, c.select(odd, 0 - sine, cosine) * back


@function("double px_meet(ptr m, i64 first, i64 second, i64 end)")
def _meet(c: Code, m: Value, first: Value, second: Value, end: Value) -> None:
    """The end of the first member, and the nearest point of the second one's middle line. Where
    both are one point there is no meeting: the gap is beyond all."""
    found, ends = arrays(m, Area.FOUND, Area.ENDS)
    x, y, radius = _of(c, m, Of.X, Of.Y, Of.RADIUS)
    point, line = ends.at(first * 4 + end * 2), ends.at(second * 4)
    px, py = (point.load(REAL, k) for k in (0, 1))
    ax, ay = (line.load(REAL, k) for k in (0, 1))
    lx, ly = line.load(REAL, 2) - ax, line.load(REAL, 3) - ay
    square = lx * lx + ly * ly
    part_ = ((px - ax) * lx + (py - ay) * ly) / c.select(square > 0.0, square, 1.0)
    part_ = c.select(part_ > 0.0, part_, 0.0)
    part_ = c.select(part_ < 1.0, part_, 1.0)
    off_x, off_y = px - (ax + part_ * lx), py - (ay + part_ * ly)
    distance = root(c, off_x * off_x + off_y * off_y)
    with c.when(~(distance > 0.0), leaves=True):
        c.give(c.constant(1e300, REAL), REAL)
    own = radius.load(REAL, first)
    gap = distance - own - radius.load(REAL, second)
    normal = off_x / distance, off_y / distance
    at = px - own * normal[0], py - own * normal[1]
    found.store(gap, Met.GAP)
    for k in (0, 1):
        found.store(normal[k], Met.X + k)
        found.store(at[k] - (x, y)[k].load(REAL, first), Met.ARM_X + k)
        found.store(at[k] - (x, y)[k].load(REAL, second), Met.OTHER_X + k)
    c.give(gap, REAL)


@function("i64 px_is_pair(ptr m, i64 first, i64 second, double reach)")
def _is_pair(c: Code, m: Value, first: Value, second: Value, reach: Value) -> None:
    """How many ends of the first member are looked at."""
    middle, bound, bar = arrays(m, Area.MIDDLE, Area.BOUND, Area.BAR)
    x, y = (middle.load(REAL, first * 2 + k) - middle.load(REAL, second * 2 + k) for k in (0, 1))
    apart = bound.load(REAL, first) + bound.load(REAL, second) + reach
    with c.when(~(x * x + y * y < apart * apart), leaves=True):
        c.give(0, INT)
    port, still = part(c, Part.PORT), part(c, Part.STILL)
    one, two = port.load(INT, first), port.load(INT, second)
    none = one.equals(two) | (still.load(INT, one).equals(1) & still.load(INT, two).equals(1))
    own, other = (bar.load(INT, i).equals(1) for i in (first, second))
    looks = (own & other) | (~own & (other | (first < second)))
    count = c.select(own, whole(c, 2), whole(c, 1))
    c.give(c.select(looks & ~none, count, whole(c, 0)), INT)


@function("i64 px_contacts(ptr m, double h, i64 fill)")
def _contacts(c: Code, m: Value, h: Value, fill: Value) -> None:
    """In the arrays of the step, where these are to be filled."""
    count = c.variable(c.call(INT, "px_touching", m, h, fill), INT)
    with c.loop(said(c, Count.CROWDS)) as crowd:
        count.set(c.call(INT, "px_among", m, h, fill, crowd, count.get()))
    c.give(count.get(), INT)


@function("i64 px_touching(ptr m, double h, i64 fill)")
def _touching(c: Code, m: Value, h: Value, fill: Value) -> None:
    before, after, gaps = arrays(m, Area.VELOCITIES, Area.AFTER, Area.GAPS)
    touches, count, most = said(c, Count.TOUCHES), c.variable(0, INT), c.variable(0.0)
    with c.loop(touches * 2) as i:
        for speeds in (before, after):
            speed = c.absolute(speeds.load(REAL, i))
            most.set(c.select(speed > most.get(), speed, most.get()))
    with c.loop(touches) as i:
        one, two = before.load(REAL, i * 2), after.load(REAL, i * 2)
        speed = c.select(one < two, one, two)
        speed = c.select(speed < 0.0, speed, 0.0)
        gap = gaps.load(REAL, i)
        with c.when(gap + h * speed < c.constant(FAR, REAL) * h * most.get()):
            with c.when(fill.equals(1)):
                k = count.get()
                key, places, values, gap_, e, mu = arrays(
                    m, Area.KEY, Area.J_COLUMNS, Area.J_VALUES, Area.GAP, Area.E, Area.MU
                )
                key.store(i, k)
                with c.loop(whole(c, 12)) as j:
                    places.store(i * 2, k * 12 + j)
                    values.store(0.0, k * 12 + j)
                for row in (0, 6):
                    places.store(i * 2 + 1, k * 12 + (row + 1))
                values.store(1.0, k * 12)
                values.store(1.0, k * 12 + 7)
                gap_.store(gap, k)
                e.store(gaps.load(REAL, touches + i), k)
                mu.store(gaps.load(REAL, touches * 2 + i), k)
            count.set(count.get() + 1)
    c.give(count.get(), INT)


@function("i64 px_among(ptr m, double h, i64 fill, i64 crowd, i64 count)")
def _among(c: Code, m: Value, h: Value, fill: Value, crowd: Value, count: Value) -> None:
    """Those of one crowd, behind the others."""
    before, after, bound = arrays(m, Area.VELOCITIES, Area.AFTER, Area.BOUND)
    (radius,) = _of(c, m, Of.RADIUS)
    members, port = part(c, Part.FIRST_MEMBERS), part(c, Part.PORT)
    begin, end = members.load(INT, crowd), members.load(INT, crowd + 1)
    speeds, largest, least = [c.variable(0.0) for _ in range(3)], c.variable(0.0), c.variable(1e300)
    number = c.variable(count, INT)
    with c.loop(end, begin) as i:
        for k, fastest in enumerate(speeds):
            for v in (before, after):
                speed = c.absolute(v.load(REAL, port.load(INT, i) + k))
                fastest.set(c.select(speed > fastest.get(), speed, fastest.get()))
        size, thick = bound.load(REAL, i), radius.load(REAL, i)
        largest.set(c.select(size > largest.get(), size, largest.get()))
        least.set(c.select((thick > 0.0) & (thick < least.get()), thick, least.get()))
    far = least.get() * FAR
    vx, vy, w = (v.get() for v in speeds)
    reach = far + h * 2.0 * (root(c, vx * vx + vy * vy) + w * largest.get())
    n, first_key = end - begin, part(c, Part.FIRST_KEYS).load(INT, crowd)
    with _meetings(c, m, begin, end, reach) as (first, second, side, gap), c.when(gap < reach):
        closes = c.call(INT, "px_closes", m, h, far, first, second).equals(1)
        with c.when(closes & fill.equals(1)):
            key = ((first - begin) * n + (second - begin)) * 2 + side
            _fill(c, m, number.get(), first, second, first_key + key)
        number.set(number.get() + c.select(closes, whole(c, 1), whole(c, 0)))
    c.give(number.get(), INT)


@contextmanager
def _meetings(
    c: Code, m: Value, begin: Value, end: Value, reach: Value
) -> Iterator[tuple[Value, Value, Value, Value]]:
    """All of members that are nearer than `reach`, with the end of the first one and the gap."""
    middle, bound = arrays(m, Area.MIDDLE, Area.BOUND)
    with c.loop(end, begin) as first:
        x, y = (middle.load(REAL, first * 2 + k) for k in (0, 1))
        far = bound.load(REAL, first) + reach
        with c.loop(end, begin) as second:
            apart = (far + bound.load(REAL, second)) * _SLACK
            beside = c.absolute(x - middle.load(REAL, second * 2)) < apart
            over = c.absolute(y - middle.load(REAL, second * 2 + 1)) < apart
            with c.when(beside & over):
                count = c.call(INT, "px_is_pair", m, first, second, reach)
                with c.loop(count) as side:
                    yield first, second, side, c.call(REAL, "px_meet", m, first, second, side)


def _row(c: Code, m: Value, slip: bool) -> list[Value]:
    """Entries of what was found, along its normal or its slip."""
    (found,) = arrays(m, Area.FOUND)
    x, y = found.load(REAL, Met.X), found.load(REAL, Met.Y)
    row: list[Value] = []
    for arm, sign in ((Met.ARM_X, 1), (Met.OTHER_X, -1)):
        px, py = found.load(REAL, arm), found.load(REAL, arm + 1)
        entries = (y, 0 - x, (0 - px) * x - py * y) if slip else (x, y, px * y - py * x)
        row += [e if sign > 0 else 0 - e for e in entries]
    return row


@function("i64 px_closes(ptr m, double h, double far, i64 first, i64 second)")
def _closes(c: Code, m: Value, h: Value, far: Value, first: Value, second: Value) -> None:
    """1 where what was found may close within the step."""
    before, after, found = arrays(m, Area.VELOCITIES, Area.AFTER, Area.FOUND)
    port, along = part(c, Part.PORT), _row(c, m, False)
    slowest = c.variable(0.0)
    for v in (before, after):
        total = c.constant(0.0, REAL)
        for k, entry in enumerate(along):
            own = port.load(INT, first if k < 3 else second)
            total = total + entry * v.load(REAL, own + k % 3)
        slowest.set(c.select(total < slowest.get(), total, slowest.get()))
    c.give(word(c, found.load(REAL, Met.GAP) + h * slowest.get() < far), INT)


def _fill(c: Code, m: Value, k: Value, first: Value, second: Value, key: Value) -> None:
    """Contact k is what was found."""
    keys, places, values, gap, e, mu, found = arrays(
        m, Area.KEY, Area.J_COLUMNS, Area.J_VALUES, Area.GAP, Area.E, Area.MU, Area.FOUND
    )
    keys.store(key, k)
    port, own = part(c, Part.PORT), _of(c, m, Of.E, Of.MU)
    for slip in (False, True):
        for j, entry in enumerate(_row(c, m, slip)):
            at = k * 12 + (6 * slip + j)
            places.store(port.load(INT, first if j < 3 else second) + j % 3, at)
            values.store(entry, at)
    gap.store(found.load(REAL, Met.GAP), k)
    for to, read in zip((e, mu), own, strict=True):
        to.store(read.load(REAL, first), k)


@function("i32 px_apart(ptr m)", seldom=True)
def _apart(c: Code, m: Value) -> None:
    """The run ends where some do, as `solve.stepping` refuses it."""
    w, _, _, _ = open_frame(m)
    attempt(c, "px_see", m, w.load(REAL), m.load(POINTER, Own.Y))
    c.run("px_lie", m)
    (gaps,) = arrays(m, Area.GAPS)
    touches, jam = said(c, Count.TOUCHES), said(c, Count.JAM)
    deepest, worst, pair = c.variable(-DEEP), c.variable(-1, INT), c.variable(0, INT)

    def end(number: Value) -> None:
        m.store(number, Own.ENDED)
        c.give(ACTED)

    with c.loop(touches) as i, c.when(gaps.load(REAL, i) < deepest.get()):
        deepest.set(gaps.load(REAL, i))
        worst.set(i)
    with c.when(worst.get() >= 0, leaves=True):
        number = jam + worst.get() * len(Jam) + int(Jam.OVERLAP)
        c.run("px_values", m, number)
        end(number)
    members = part(c, Part.FIRST_MEMBERS)
    none = c.constant(0.0, REAL)
    with c.loop(said(c, Count.CROWDS)) as crowd:
        begin, behind = members.load(INT, crowd), members.load(INT, crowd + 1)
        found = _meetings(c, m, begin, behind, none)
        with found as (first, second, _, gap), c.when(gap < deepest.get()):
            deepest.set(gap)
            worst.set(first)
            pair.set(second)
        with c.when(worst.get() >= 0, leaves=True):
            values = m.load(POINTER, Own.TEXT).at(LETTERS // 8)
            for k, body in enumerate((worst.get(), pair.get())):
                values.store(c.call(POINTER, "px_member", body), k)
            values.store(0 - deepest.get(), 2)
            end(jam + touches * len(Jam) + crowd)
    c.give(c.constant(0, FLAG))
