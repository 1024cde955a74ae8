"""What a C program calls of a model.

    model_new() -> instance               as it was exported; null where there is no memory
    model_set(m, slot, value) -> flag     a parameter or start value before the begin, an input ever
    model_begin(m) -> flag                start values that fit together; 1 where there are none
    model_go(m, t) -> flag                to a time, with all variables there
    model_message(m, number) -> text      with its values; it stands until the next one is asked for

`model_go` gives 0, the number of the message (`model_message`) that an assertion or an event ended
the run with, or -1 where no step leads on.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Value
from planarc.codegen.native.newton import open_frame
from planarc.export.fmi.entries import Entries
from planarc.instance.block import whole
from planarc.instance.plan import Own, Phase, Stale
from planarc.instance.settling import ACTED


def functions() -> Entries:
    """All of them."""
    e = Entries(lambda *_: None)
    with e.plain("model_new", "", POINTER) as (c, _):
        null = Value(c, POINTER, "null")
        c.give(c.call(POINTER, "px_new", null, null, whole(c, 0), null))
    with e.plain("model_set", "ptr m, i32 slot, double value") as (c, (m, slot, value)):
        reference = c.emit(INT, f"sext i32 {slot.text} to i64") * 8
        c.give(c.call(FLAG, "px_set", m, reference, whole(c, 0), value))
    with e.plain("model_begin", "ptr m") as (c, (m,)):
        flag = c.call(FLAG, "px_refresh", m, whole(c, Stale.NOTHING))
        e.enter(c, m, Phase.STEP)
        c.give(flag)
    with e.plain("model_go", "ptr m, double t") as (c, (m, t)):
        w, _, _, _ = open_frame(m)
        moved = c.variable(c.constant(0, FLAG), FLAG)
        with c.when(t > w.load(REAL)):  # a step of no length has no Jacobian
            moved.set(c.call(FLAG, "px_advance", m, t))
        flag = moved.get()
        with c.when(flag.equals(ACTED), leaves=True):
            c.call(FLAG, "px_refresh", m, whole(c, Stale.NOTHING))
            c.give(c.flag(m.load(INT, Own.ENDED)))
        rest = c.call(FLAG, "px_refresh", m, whole(c, Stale.NOTHING))
        with c.when(~flag.equals(0) | ~rest.equals(0), leaves=True):
            c.give(-1)
        found = c.call(FLAG, "px_asserts", m, w.load(REAL))
        c.run("px_values", m, c.emit(INT, f"sext i32 {found.text} to i64"))
        c.give(found)
    with e.plain("model_message", "ptr m, i32 number", POINTER) as (c, (m, number)):
        c.give(c.call(POINTER, "px_fill", m, c.call(POINTER, "px_message", m, number)))
    return e
