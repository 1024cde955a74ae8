"""Ends of steps at events, in LLVM.

    px_watch(block, t, part)           note a stage that lies behind a crossing
    px_locate(block, t, most) -> h     a step that ends right behind a crossing
    px_happen(block) -> flag           what happens at the present point
    px_crowd(block) -> flag            count crossings right behind each other

They stand apart from `steps`, which calls them, since only models with events have them.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import larger, whole
from planarc.instance.plan import Own, Relation, Stale
from planarc.instance.relations import attempt, numbers_of
from planarc.instance.steps import BEGIN, vector

#: Trials until a crossing is known to so many last digits of the time.
_TRIALS, _EXACT = 100, 4 * 2.0**-52
#: A value below this part of the one at the other end may be rounding.
_SLIGHT = 1e-3
#: Crossings in a row that are too many, and the time from one to the next, in units of `Own.AHEAD`.
_CROWD, _CROWD_TIME = 100, 3.0
#: The flag of too many events.
CROWDED = 4


def end_functions() -> tuple[str, ...]:
    return _watch(), _trial(), _locate(), _crowd(), _happen()


@function("void px_watch(ptr m, double t, double part)")
def _watch(c: Code, m: Value, t: Value, part: Value) -> None:
    """The first stage that lies behind a crossing is kept."""
    zeros = numbers_of(c, m, Relation.TRIAL)
    c.call(FLAG, "pc_zeros", m, t, zeros)
    over = c.call(REAL, "px_crossed", m, zeros) <= 0.0
    with c.when(over & (m.load(REAL, Own.NODE) > part)):
        m.store(part, Own.NODE)
    c.give()


@function("double px_trial(ptr m, double t, double h)")
def _trial(c: Code, m: Value, t: Value, h: Value) -> None:
    """A step, and how far it ends from the next crossing of a relation."""
    zeros = numbers_of(c, m, Relation.TRIAL)
    with c.when(c.call(FLAG, "px_stages", m, t, h).equals(0), leaves=True):
        flag = c.call(FLAG, "pc_zeros", m, t + h, zeros)
        way = c.call(REAL, "px_crossed", m, zeros)
        c.give(c.select(flag.equals(0), way, -1e300), REAL)
    c.give(c.constant(-1e300, REAL), REAL)


@function("double px_locate(ptr m, double t, double most)", seldom=True)
def _locate(c: Code, m: Value, t: Value, most: Value) -> None:
    """The step itself is made anew each time, so that its end is as exact as any other."""
    zeros = numbers_of(c, m, Relation.TRIAL)
    last = c.variable(c.call(REAL, "px_trial", m, t, most))
    with c.when(last.get() > 0.0, leaves=True):  # a stage was not the solution
        c.give(most, REAL)
    m.store(whole(c, 1), Own.CROSSED)
    low, high = c.variable(0.0), c.variable(most)
    c.call(FLAG, "pc_roots", m, t, vector(c, m, BEGIN), zeros)
    first = c.variable(larger(c, c.call(REAL, "px_crossed", m, zeros), 1e-300))
    side, done = c.variable(0, INT), c.variable(0, INT)
    least = larger(c, c.absolute(t), c.absolute(t + most)) * _EXACT
    with c.loop(_TRIALS) as k, c.when(done.get().equals(0)):
        width = high.get() - low.get()
        with c.when(width <= least):
            done.set(whole(c, 1))
        with c.when(width > least):
            part = first.get() / (first.get() - last.get())
            halved = (k - k / 4 * 4).equals(3) | ~((part > 0.0) & (part < 1.0))
            # What begins at zero, as a bounce does, is rounding there: look further away.
            halved = halved | (first.get() < -last.get() * _SLIGHT)
            x = low.get() + width * c.select(halved, c.constant(0.5, REAL), part)
            x = c.select(x > low.get() + least * 0.5, x, low.get() + least * 0.5)
            x = c.select(x < high.get() - least * 0.5, x, high.get() - least * 0.5)
            way = c.call(REAL, "px_trial", m, t, x)
            over = way <= 0.0
            # Illinois' rule: where the same end moves again, the other's value counts half.
            again = side.get().equals(c.select(over, whole(c, 1), whole(c, -1)))
            half = c.select(again, c.constant(0.5, REAL), 1.0)
            low.set(c.select(over, low.get(), x))
            first.set(c.select(over, first.get() * half, way))
            last.set(c.select(over, way, last.get() * half))
            high.set(c.select(over, x, high.get()))
            side.set(c.select(over, whole(c, 1), whole(c, -1)))
    c.call(REAL, "px_trial", m, t, high.get())
    c.give(high.get(), REAL)


@function("i32 px_crowd(ptr m)", seldom=True)
def _crowd(c: Code, m: Value) -> None:
    w, _, _, _ = open_frame(m)
    t = w.load(REAL)
    with c.when(m.load(INT, Own.CROSSED).equals(1)):
        soon = t - m.load(REAL, Own.LATEST) < m.load(REAL, Own.AHEAD) * _CROWD_TIME
        count = c.select(soon, m.load(INT, Own.CROWDED) + 1, whole(c, 0))
        m.store(count, Own.CROWDED)
        m.store(t, Own.LATEST)
    with c.when(m.load(INT, Own.CROWDED) > _CROWD, leaves=True):
        c.give(CROWDED)
    c.give(0)


@function("i32 px_happen(ptr m)", seldom=True)
def _happen(c: Code, m: Value) -> None:
    """Where it is not too often."""
    m.store(whole(c, 0), Own.EXACT)
    attempt(c, "px_crowd", m)
    m.store(whole(c, 0), Own.CROSSED)
    attempt(c, "px_update", m)
    with c.when(c.call(REAL, "px_look", m) > m.load(REAL, Own.BOUND)):
        changed = c.call(FLAG, "px_exchange", m)
        with c.when(changed > 0):
            m.store(whole(c, Stale.ALL), Own.STALE)
    c.give(0)
