"""Pieces of the past: polynomials of delayed signals, as of `runtime.history`.

    px_signals(block, out)              the signals in the workspace
    px_fit(parts, values, by, terms)    a polynomial through values, each `by` numbers on
    px_make_room(block, before) -> flag for a piece; what lies before an instant is needed no more
    px_append(block, careful) -> flag   the piece of a step (`Past.times`, `Past.values`); 1 where a
                                        shorter step is needed
    px_resume(block, t)                 the past ends here, and signals may have jumped
    px_link(block)                      tell the kernel how many pieces there are

There is room for a certain number of pieces. Where it ends those are dropped that no delay reaches
any more, and neighbours become one where one polynomial says what both say, to within `MERGED` of
the signal's size in a pass; a piece takes part in one pass when the room is used up once more. When
that does not help either, the run ends with a message.
"""

from __future__ import annotations

import math

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import larger, whole
from planarc.instance.past.layout import Each, Head, Past, Row
from planarc.instance.plan import Own, Shelf
from planarc.instance.settling import ACTED
from planarc.ir.frame import Frame
from planarc.runtime.history import DEGREE, TERMS, Memory
from planarc.solve.events.crossings import AHEAD
from planarc.solve.events.delays import NEGLIGIBLE, ROUNDING

#: Chebyshev's points of a piece from 0 to 1.
NODES = tuple((1 - math.cos(math.pi * k / DEGREE)) / 2 for k in range(TERMS))
#: What a polynomial may miss of a signal within a step, as a part of its size; the least part of
#: the run to which steps are shortened for it.
_MISSED, _FLOOR = 1e-9, 1e-5
#: What it may miss of two pieces that become one, in passes that may follow each other.
MERGED, _PASSES = (1e-12, 1e-11, 1e-10), 8
#: Halvings of a search among pieces, at most.
_HALVINGS = 40


def piece_functions() -> tuple[str, ...]:
    return (_signals(), _fit(), _value(), _link(), _tail(), _restart(), _resume(), _append(),
            _within_range(), _forget(), _join(), _pair(), _make_room())  # fmt: skip


@function("void px_signals(ptr m, ptr out)")
def _signals(c: Code, m: Value, out: Value) -> None:
    past = Past(c, m)
    w, _, _, _ = open_frame(m)
    with c.loop(past.count) as d:
        sign = c.real(past.told(d, Row.SIGN))
        out.store(sign * w.load(REAL, past.told(d, Row.SLOT)), d)
    c.give()


@function("void px_fit(ptr parts, ptr values, i64 by, ptr terms)")
def _fit(c: Code, parts: Value, values: Value, by: Value, terms: Value) -> None:
    """By Newton's divided differences; a line where points coincide."""
    slopes = c.place(REAL, TERMS)
    apart = c.variable(1, INT)
    with c.loop(TERMS) as k:
        slopes.store(values.load(REAL, k * by), k)
        terms.store(0.0, k)
    with c.loop(TERMS, 1) as k, c.when(~(parts.load(REAL, k) > parts.load(REAL, k - 1))):
        apart.set(whole(c, 0))
    with c.when(apart.get().equals(0), leaves=True):
        terms.store(slopes.load(REAL, 0), 0)
        terms.store(slopes.load(REAL, DEGREE) - slopes.load(REAL, 0), 1)
        c.give()
    with c.loop(TERMS, 1) as order, c.loop(order.negative() + TERMS) as back:
        i = back.negative() + DEGREE
        rise = slopes.load(REAL, i) - slopes.load(REAL, i - 1)
        slopes.store(rise / (parts.load(REAL, i) - parts.load(REAL, i - order)), i)
    with c.loop(TERMS) as back:
        k = back.negative() + DEGREE
        with c.loop(DEGREE) as inner:
            j = inner.negative() + DEGREE
            before = terms.load(REAL, j - 1) - parts.load(REAL, k) * terms.load(REAL, j)
            terms.store(before, j)
        terms.store(slopes.load(REAL, k) - parts.load(REAL, k) * terms.load(REAL, 0), 0)
    c.give()


@function("double px_value(ptr terms, double x)")
def _value(c: Code, terms: Value, x: Value) -> None:
    found = c.variable(0.0)
    with c.loop(TERMS) as back:
        found.set(found.get() * x + terms.load(REAL, back.negative() + DEGREE))
    c.give(found.get(), REAL)


@function("void px_link(ptr m)")
def _link(c: Code, m: Value) -> None:
    memory = m.load(POINTER, Frame.PAST)
    pieces = memory.load(POINTER, Shelf.HEAD).load(INT, Head.PIECES)
    rest, halvings = c.variable(pieces - 1, INT), c.variable(0, INT)
    with c.loop(_HALVINGS), c.when(rest.get() > 0):
        rest.set(rest.get() / 2)
        halvings.set(halvings.get() + 1)
    memory.store(pieces, Memory.PIECES)
    memory.store(Past(c, m).count, Memory.DELAYS)
    memory.store(halvings.get(), Memory.HALVINGS)
    c.give()


@function("void px_tail(ptr m, i64 piece, double t, i64 sloped)")
def _tail(c: Code, m: Value, piece: Value, t: Value, sloped: Value) -> None:
    """What lies ahead of the past: a line from its end, from the piece before it or level."""
    past = Past(c, m)
    last, before = past.each(Each.LAST), piece - 1
    past.begins.store(t, piece)
    past.scales.store(1.0, piece)
    with c.loop(past.count) as d:
        terms, slope = past.first_term(piece, d), c.variable(0.0)
        with c.when(sloped.equals(1)):
            own = past.first_term(before, d)
            with c.loop(TERMS) as k:
                slope.set(slope.get() + c.real(k) * own.load(REAL, k))
            slope.set(slope.get() * past.scales.load(REAL, before))
        with c.loop(TERMS) as k:
            terms.store(0.0, k)
        terms.store(last.load(REAL, d), 0)
        terms.store(slope.get(), 1)
    past.head.store(piece + 1, Head.PIECES)
    past.head.store(t, Head.UNTIL)
    c.run("px_link", m)
    c.give()


@function("void px_restart(ptr m, double t)")
def _restart(c: Code, m: Value, t: Value) -> None:
    """The signals had their last values for ever."""
    past = Past(c, m)
    last = past.each(Each.LAST)
    past.begins.store(t)
    past.scales.store(0.0)
    with c.loop(past.count) as d:
        terms = past.first_term(whole(c, 0), d)
        with c.loop(TERMS) as k:
            terms.store(0.0, k)
        terms.store(last.load(REAL, d))
    past.head.store(t, Head.RESUMED)
    c.run("px_tail", m, whole(c, 1), t, whole(c, 0))
    c.give()


@function("void px_resume(ptr m, double t)")
def _resume(c: Code, m: Value, t: Value) -> None:
    """The workspace is that of this instant; what was ahead of it is forgotten."""
    past = Past(c, m)
    c.run("px_signals", m, past.each(Each.LAST))
    past.head.store(t, Head.RESUMED)
    with c.when(past.real(Head.UNTIL) > t):
        kept = c.variable(1, INT)
        with c.loop(past.pieces(), 1) as i, c.when(past.begins.load(REAL, i) < t):
            kept.set(i + 1)
        c.run("px_tail", m, kept.get(), t, whole(c, 0))
    c.give()


@function("i32 px_append(ptr m, i64 careful)")
def _append(c: Code, m: Value, careful: Value) -> None:
    past = Past(c, m)
    times, parts, values = past.times, past.parts, past.values
    begin, end = times.load(REAL, 0), times.load(REAL, DEGREE)
    first = begin - (end - begin) * NEGLIGIBLE
    resumed, last = past.real(Head.RESUMED), past.pieces() - 1
    first = c.select(resumed > first, resumed, first)
    place = c.variable(last, INT)
    on = c.variable(1, INT)
    with c.loop(last), c.when(on.get().equals(1)):  # short ones become part of this one
        before = place.get() - 1
        starts = past.begins.load(REAL, before)
        joins = (before > 0) & (starts >= first) & (starts < begin)
        with c.when(joins):
            place.set(before)
        with c.when(~joins):
            on.set(whole(c, 0))
    with c.when(place.get() < last):
        times.store(past.begins.load(REAL, place.get()))
        with c.loop(past.count) as d:
            values.store(past.first_term(place.get(), d).load(REAL), d)
    starts = times.load(REAL, 0)
    width = end - starts
    with c.loop(TERMS) as k:
        parts.store((times.load(REAL, k) - starts) / width, k)
    worst, largest = c.variable(0.0), past.each(Each.LARGEST)
    middle = ((begin + end) * 0.5 - starts) / width
    with c.loop(past.count) as d:
        terms = past.found.at(d * TERMS)
        c.run("px_fit", parts, values.at(d), past.count, terms)
        there = c.absolute(values.load(REAL, past.count * DEGREE + d))
        size = larger(c, largest.load(REAL, d), there)
        missed = c.absolute(c.call(REAL, "px_value", terms, middle)
                            - values.load(REAL, past.count * TERMS + d))  # fmt: skip
        worst.set(larger(c, worst.get(), missed - size * _MISSED))
    shorter = (worst.get() > 0.0) & (end - begin > m.load(REAL, Own.AHEAD) * (_FLOOR / AHEAD))
    with c.when(careful.equals(1) & shorter, leaves=True):
        c.give(1)
    piece = place.get()
    past.begins.store(starts, piece)
    past.scales.store(1.0 / width, piece)
    kept = past.first_term(piece, whole(c, 0))
    c.run("px_copy", kept, past.found, past.count * TERMS)
    ends = past.each(Each.LAST)
    with c.loop(past.count) as d:
        value = values.load(REAL, past.count * DEGREE + d)
        ends.store(value, d)
        largest.store(larger(c, largest.load(REAL, d), c.absolute(value)), d)
    c.run("px_tail", m, piece + 1, end, whole(c, 1))
    c.give(c.call(FLAG, "px_within_range", m))


@function("i32 px_within_range(ptr m)")
def _within_range(c: Code, m: Value) -> None:
    """Delay times that change must stay between 0 and their largest ones."""
    past = Past(c, m)
    w, _, _, _ = open_frame(m)
    most = past.each(Each.MOST)
    with c.loop(past.count) as d, c.when(~past.is_fixed(d)):
        interval = w.load(REAL, past.told(d, Row.INTERVAL))
        inside = (interval >= -ROUNDING) & (interval <= most.load(REAL, d) * (1 + ROUNDING))
        with c.when(~inside, leaves=True):
            m.store(past.message(d, 1), Own.ENDED)
            c.give(ACTED)
    c.give(0)


@function("void px_forget(ptr m, double before)")
def _forget(c: Code, m: Value, before: Value) -> None:
    """Drop the pieces that end before an instant."""
    past = Past(c, m)
    pieces, old = past.pieces(), c.variable(0, INT)
    with c.loop(pieces) as i, c.when(past.begins.load(REAL, i) <= before):
        old.set(i)
    first, left = old.get(), pieces - old.get()
    with c.when(first > 0):
        c.run("px_copy", past.begins, past.begins.at(first), left)
        c.run("px_copy", past.scales, past.scales.at(first), left)
        source = past.first_term(first, whole(c, 0))
        c.run("px_copy", past.terms, source, left * past.count * TERMS)
        past.head.store(left, Head.PIECES)
    c.give()


@function("i64 px_join(ptr m, i64 piece, double part)")
def _join(c: Code, m: Value, piece: Value, part: Value) -> None:
    """Whether one polynomial says what a piece and the next one say; it is found then."""
    past = Past(c, m)
    following = piece + 1
    begin, end = past.begins.load(REAL, piece), past.begins.load(REAL, piece + 2)
    width, largest = end - begin, past.each(Each.LARGEST)

    def said(d: Value, x: Value | float) -> Value:
        """By the pieces as they are."""
        t = begin + width * x
        late = t >= past.begins.load(REAL, following)
        which = c.emit(INT, f"select i1 {late.text}, i64 {following.text}, i64 {piece.text}")
        own = (t - past.begins.load(REAL, which)) * past.scales.load(REAL, which)
        return c.call(REAL, "px_value", past.first_term(which, d), own)

    for number, node in enumerate(NODES):
        past.parts.store(node, number)
    with c.when(past.scales.load(REAL, piece).equals(0.0), leaves=True):
        c.give(0, INT)
    with c.loop(past.count) as d:
        with c.loop(TERMS) as k:
            past.values.store(said(d, past.parts.load(REAL, k)), k)
        terms, worst = past.found.at(d * TERMS), c.variable(0.0)
        c.run("px_fit", past.parts, past.values, whole(c, 1), terms)
        with c.loop(DEGREE) as k:
            x = (past.parts.load(REAL, k) + past.parts.load(REAL, k + 1)) * 0.5
            missed = c.absolute(c.call(REAL, "px_value", terms, x) - said(d, x))
            worst.set(larger(c, worst.get(), missed))
        with c.when(~(worst.get() <= largest.load(REAL, d) * part), leaves=True):
            c.give(0, INT)
    c.give(1, INT)


@function("void px_pair(ptr m, double part)")
def _pair(c: Code, m: Value, part: Value) -> None:
    """One of two neighbours, wherever that loses nothing."""
    past = Past(c, m)
    pieces = past.pieces()
    to, taken, row = c.variable(0, INT), c.variable(0, INT), past.count * TERMS
    with c.loop(pieces) as i, c.when(i >= taken.get()):
        place = to.get()
        begin, scale = past.begins.load(REAL, i), past.scales.load(REAL, i)
        joined = c.variable(0, INT)
        with c.when(i + 2 < pieces):
            joined.set(c.call(INT, "px_join", m, i, part))
        with c.when(joined.get().equals(1)):
            width = past.begins.load(REAL, i + 2) - begin
            past.scales.store(1.0 / width, place)
            c.run("px_copy", past.first_term(place, whole(c, 0)), past.found, row)
        with c.when(joined.get().equals(0) & (place < i)):
            past.scales.store(scale, place)
            source = past.first_term(i, whole(c, 0))
            c.run("px_copy", past.first_term(place, whole(c, 0)), source, row)
        past.begins.store(begin, place)
        to.set(place + 1)
        taken.set(i + 1 + joined.get())
    past.head.store(to.get(), Head.PIECES)
    c.give()


@function("i32 px_make_room(ptr m, double before)")
def _make_room(c: Code, m: Value, before: Value) -> None:
    """For another piece, where there is none left: a quarter of all, if that can be."""
    past = Past(c, m)
    with c.when(past.pieces() + 2 <= past.room, leaves=True):
        c.give(0)
    c.run("px_forget", m, before)
    for part in MERGED:
        with c.loop(_PASSES), c.when(past.pieces() * 4 > past.room * 3):
            c.run("px_pair", m, c.constant(part, REAL))
    c.run("px_link", m)
    with c.when(past.pieces() + 2 > past.room, leaves=True):
        m.store(past.message(past.count), Own.ENDED)
        c.give(ACTED)
    c.give(0)
