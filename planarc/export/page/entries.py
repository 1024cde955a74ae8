"""What a page calls of a model, in LLVM. Only 32-bit numbers and pointers cross the border, which
JavaScript knows as its own numbers.

    page_new() -> block                     an instance as it was exported
    page_set(block, slot, value) -> flag    a parameter or a start value, before it begins
    page_begin(block) -> flag               start values that fit together; 1 where there are none;
                                            below zero the message with which the start ends a run
    page_place(block) -> workspace          where its values stand, also where there is no start
    page_rows(block, times, first, last, slots, width, out) -> rows
                                            run on, and keep a row at each time

A row is `width` numbers of the workspace, out[row*width + i] = w[slots[i]]. Fewer rows than were
asked for: a run ended; `page_rows` leaves the reason in the word behind the last row that there is
room for: the number of the message (`instance.actions`) that an assertion or an event ended
it with, or what stood in the way, as a number below 0 (`instance.events`).

Before and behind each event the page is called itself, by

    page_event(time, behind, w, crossing, fired, samples)

with pointers to the workspace, to flags of the relations and samplers that switch (64 bits each),
and to the starts of all samplers, then their intervals.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value
from planarc.codegen.native.newton import open_frame
from planarc.export.fmi.entries import Entries
from planarc.export.heard import tell_events
from planarc.instance.block import whole
from planarc.instance.plan import Own, Phase, Stale
from planarc.instance.settling import ACTED


def functions(eventful: bool = False, crowded: bool = False) -> Entries:
    """All of them; those of an `eventful` model tell its events. Steps of a `crowded` one have
    their own length."""
    e = Entries(lambda *_: None, crowded=crowded)
    if eventful:
        tell_events(e, "page_event")
    with e.plain("page_new", "", POINTER) as (c, _):
        null = Value(c, POINTER, "null")
        c.give(c.call(POINTER, "px_new", null, null, whole(c, 0), null))
    with e.plain("page_set", "ptr m, i32 slot, double value") as (c, (m, slot, value)):
        c.give(c.call(FLAG, "px_set", m, _long(c, slot) * 8, whole(c, 0), value))
    with e.plain("page_begin", "ptr m") as (c, (m,)):
        flag = c.call(FLAG, "px_refresh", m, whole(c, Stale.NOTHING))
        e.enter(c, m, Phase.STEP)
        ended = c.flag(m.load(INT, Own.ENDED).negative())
        c.give(c.select(flag.equals(ACTED), ended, flag))
    with e.plain("page_place", "ptr m", POINTER) as (c, (m,)):
        c.give(open_frame(m)[0])
    _rows(e)
    return e


def _long(c: Code, value: Value) -> Value:
    return c.emit(INT, f"sext i32 {value.text} to i64")


def _rows(e: Entries) -> None:
    arguments = "ptr m, ptr times, i32 first, i32 last, ptr slots, i32 width, ptr out"
    with e.plain("page_rows", arguments) as (c, (m, times, first, last, slots, width, out)):
        begin, end, wide = (_long(c, v) for v in (first, last, width))
        w, _, _, _ = open_frame(m)
        reason = out.at(end * wide)
        reason.store(whole(c, 0))
        with c.loop(end, begin) as i:
            # A step ends with each row: a loop is closed from the last row, never from far beyond.
            if not e.crowded:
                m.store(whole(c, 0), Own.EXACT)
            flag = c.call(FLAG, "px_advance", m, times.load(REAL, i))
            rest = c.call(FLAG, "px_refresh", m, whole(c, Stale.NOTHING))
            reason.store(c.emit(INT, f"sext i32 {flag.negative().text} to i64"))
            with c.when(flag.equals(ACTED)):
                reason.store(m.load(INT, Own.ENDED))
            with c.when(~flag.equals(0) | ~rest.equals(0), leaves=True):
                c.give(c.flag(i))
            row = out.at(i * wide)
            with c.loop(wide) as k:
                row.store(w.load(REAL, slots.load(INT, k)), k)
            failed = c.call(FLAG, "px_asserts", m, w.load(REAL))
            with c.when(failed > 0, leaves=True):
                reason.store(c.emit(INT, f"sext i32 {failed.text} to i64"))
                c.give(c.flag(i + 1))
        c.give(last)
