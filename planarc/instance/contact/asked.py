"""What a run in Python asks of an impact besides, in LLVM.

    px_refine(block, k)             impulses corrected by the speeds that came of them
    px_note_strike(block)           what it changed, in `Area.LOG`
    px_height(block, k) -> part     how low the bounces are that begin

Reference: `solve.contact.impacts`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.instance.block import whole
from planarc.instance.contact.access import arrays, kept, seen, slot, touches, zero
from planarc.instance.contact.area import LOGGED, STRIKES, Area, Kept, Reads, Seen
from planarc.instance.contact.touches import before_of, read_of
from planarc.instance.plan import Touch
from planarc.ir.frame import Frame
from planarc.solve.contact.problem import IDLE, STICKS


def asked_functions() -> tuple[str, ...]:
    return _refine(), _log(), _height()


@function("void px_refine(ptr m, i64 k)")
def _refine(c: Code, m: Value, k: Value) -> None:
    """Correct the impulses by the speeds that came of them: of a touch that hardly moves what it
    strikes, what they do is known to few digits."""
    now, here, before, speeds, impulses, listed, total, cases, mu, way, x = arrays(
        m, Area.NOW, Area.HERE, Area.BEFORE, Area.SPEEDS, Area.IMPULSES, Area.LIST, Area.SUM,
        Area.CASES, Area.MU, Area.WAY, Area.FORCES,
    )  # fmt: skip
    with c.loop(k) as j:
        i = here.load(INT, j)
        listed.store(j, j)
        held = ~before_of(c, before, Touch.HELD).load(REAL, i).equals(0.0)
        drift = c.select(held, before_of(c, before, Reads.V).load(REAL, i), zero(c))
        v = read_of(c, now, Reads.V).load(REAL, i) - drift
        slip = read_of(c, now, Reads.SLIP).load(REAL, i)
        for place, came in ((j, v), (k + j, slip)):
            total.store(came - speeds.load(REAL, place), place)
        mu.store(0.0, j)
        acts = impulses.load(REAL, j).equals(0.0), impulses.load(REAL, k + j).equals(0.0)
        cases.store(c.select(acts[0], whole(c, 0), whole(c, 1)), j)
        cases.store(c.select(acts[1], whole(c, IDLE), whole(c, STICKS)), k + j)
        way.store(cases.load(INT, k + j), j)
    c.run("px_gather", m, k, k, total)
    with c.when(c.call(FLAG, "px_case", m, k).equals(0)):
        c.call(FLAG, "px_shift", m, k, k, x)
    c.give()


@function("void px_note_strike(ptr m)", seldom=True)
def _log(c: Code, m: Value) -> None:
    """Tell of a strike."""
    n, w = touches(c), m.load(POINTER, Frame.W)
    before, held, log = arrays(m, Area.BEFORE, Area.HELD, Area.LOG)
    strikes = seen(c, m, Seen.STRIKES)
    count = strikes.load(INT)
    strikes.store(count + 1)
    with c.when(count < STRIKES):
        row = log.at(count * n * (2 * len(LOGGED)))
        with c.loop(n) as i:
            for k, which in enumerate(LOGGED):
                was = held if which is Touch.HELD else before_of(c, before, which)
                row.store(was.load(REAL, i), n * (2 * k) + i)
                row.store(w.load(REAL, slot(c, i, which)), n * (2 * k + 1) + i)
    c.give()


@function("double px_height(ptr m, i64 k)", seldom=True)
def _height(c: Code, m: Value, k: Value) -> None:
    """Of the lowest bounce that begins here, as a part of its first one."""
    here, before, speeds, still = arrays(m, Area.HERE, Area.BEFORE, Area.SPEEDS, Area.STILL)
    least = c.variable(1.0)
    with c.loop(k) as j:
        i, v = here.load(INT, j), speeds.load(REAL, j)
        first = kept(c, m, Kept.FIRST).load(REAL, i)
        springs = before_of(c, before, Reads.E).load(REAL, i) < 1.0
        part = v / first
        lower = (v > still.load(REAL, j)) & (first > 0.0) & springs & (part * part < least.get())
        with c.when(lower):
            least.set(part * part)
    c.give(least.get(), REAL)
