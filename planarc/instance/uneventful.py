"""What stands in the place of events in a model that has none.

The functions have the names and flags of those in `events`, `relations`, `instants`, `ends` and
`within`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import hold, whole
from planarc.instance.events import SETTLED, set_flag
from planarc.instance.plan import Own, Stale, Table
from planarc.instance.relations import attempt
from planarc.instance.settling import UNSOLVED

#: There are no relations, no instants, and nothing to settle.
_NOTHING = f"""
define i32 @px_indicate(ptr %m) nounwind {{
  ret i32 0
}}
define void @px_passed(ptr %m, double %t) nounwind {{
  ret void
}}
define double @px_next(ptr %m) nounwind {{
  ret double 0x7E37E43C8800759C
}}
define i32 @px_settled(ptr %m) nounwind {{
  ret i32 {SETTLED}
}}
define void @px_finish(ptr %m) nounwind {{
  ret void
}}
define void @px_watch(ptr %m, double %t, double %part) nounwind {{
  ret void
}}
define void @px_within(ptr %m, double %t, double %h) nounwind {{
  ret void
}}
define double @px_locate(ptr %m, double %t, double %most) nounwind {{
  ret double %most
}}
define i32 @px_happen(ptr %m) nounwind {{
  ret i32 0
}}
define i32 @px_crowd(ptr %m) nounwind {{
  ret i32 0
}}
define i64 @px_waits(ptr %m) nounwind {{
  ret i64 0
}}
"""


def uneventful_functions() -> tuple[str, ...]:
    return _NOTHING, _prepare(), _first(), _update()


@function("i32 px_prepare(ptr m)")
def _prepare(c: Code, m: Value) -> None:
    w, _, _, _ = open_frame(m)
    attempt(c, "pc_parameters", m, w.load(REAL))
    set_flag(c, m, Table.INITIAL, 1.0)
    c.give(0)


@function("i32 px_first(ptr m)")
def _first(c: Code, m: Value) -> None:
    w, _, _, _ = open_frame(m)
    set_flag(c, m, Table.INITIAL, 0.0)
    attempt(c, "pc_outputs", m, w.load(REAL), m.load(POINTER, Own.Y))
    hold(c, m)
    c.give(0)


@function("i32 px_update(ptr m)")
def _update(c: Code, m: Value) -> None:
    """What the host has set counts from here on."""
    w, _, _, _ = open_frame(m)
    touched = m.load(INT, Own.TOUCHED).equals(1)
    with c.when(touched):
        hold(c, m)
        m.store(whole(c, 0), Own.TOUCHED)
        m.store(whole(c, 0), Own.EXACT)
        m.store(whole(c, Stale.ALL), Own.STALE)
    flag = c.call(FLAG, "pc_outputs", m, w.load(REAL), m.load(POINTER, Own.Y))
    with c.when(flag.equals(0)):
        m.store(whole(c, Stale.NOTHING), Own.STALE)
        with c.when(touched):
            hold(c, m)
            c.run("px_measure", m)
    c.give(c.select(touched & ~flag.equals(0), c.constant(UNSOLVED, FLAG), 0))
