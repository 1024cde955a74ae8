"""One instant of an event in an exported model: truths and discrete values until they rest.

    px_settle(block, t, moved) -> flag   with pre-values as they are; `moved`: states were set anew
    px_turn(block, t) -> flag            relations at zero take their truth right after; 1: one did

Flags of failures are those of `instance.events`. What this module does, and why, stands in
`solve.events.settling`, which does it for a run.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import larger, plan, whole
from planarc.instance.plan import PASSES, Own, Relation, Row, Table
from planarc.instance.relations import (
    attempt,
    differs,
    numbers_of,
    set_truth,
    sign,
    told,
    truth,
    word,
)
from planarc.solve.events.crossings import EXACT, NOISE
from planarc.solve.events.settling import EXACTLY, MOST_SEARCHED, MOST_TURNS, PATIENCE, SOON

#: What ends an event: no solution, no rest, an action.
UNSOLVED, ENDLESS, ACTED = 1, 2, 3
#: What ends a start: a `sample` whose ticks lie closer together than instants.
DENSE = 5
_PRIME = 1099511628211


def settling_functions(asks: bool = False) -> tuple[str, ...]:
    """`asks`: what may be rounding alone is `Own.DOUBT`, for a run in Python to decide."""
    return (_snapshot(), _same(), _hash(), _iterate(), _clear(asks), _signs(), _release(asks),
            _settle(asks), _agrees(), _search(), _turn(asks))  # fmt: skip


def switching(c: Code) -> Value:
    """Truths and discrete values of a snapshot."""
    return plan(c, Table.RELATIONS) + plan(c, Table.DISCRETES)


def discrete(m: Value, i: Value, which: int) -> Value:
    """The slots of a discrete variable: itself, its left limit, its start."""
    return m.load(POINTER, Own.DISCRETES).load(INT, i * 3 + which)


@function("void px_snapshot(ptr m, i64 which)")
def _snapshot(c: Code, m: Value, which: Value) -> None:
    w, _, _, _ = open_frame(m)
    to, count = m.load(POINTER, Own.SNAPSHOTS).at(which * switching(c)), plan(c, Table.RELATIONS)
    with c.loop(count) as i:
        to.store(w.load(REAL, told(c, i, Row.SLOT)), i)
    with c.loop(plan(c, Table.DISCRETES)) as i:
        to.store(w.load(REAL, discrete(m, i, 0)), count + i)
    c.give()


@function("i64 px_same(ptr m, i64 one, i64 two)")
def _same(c: Code, m: Value, one: Value, two: Value) -> None:
    rows, count = m.load(POINTER, Own.SNAPSHOTS), switching(c)
    a, b, found = rows.at(one * count), rows.at(two * count), c.variable(1, INT)
    with c.loop(count) as i, c.when(~a.load(REAL, i).equals(b.load(REAL, i))):
        found.set(whole(c, 0))
    c.give(found.get())


@function("i64 px_hash(ptr m, i64 which)")
def _hash(c: Code, m: Value, which: Value) -> None:
    """A number that tells snapshots apart."""
    row, found = m.load(POINTER, Own.SNAPSHOTS).at(which * switching(c)), c.variable(17, INT)
    with c.loop(switching(c)) as i:
        bits = row.load(INT, i)
        mixed = c.emit(INT, f"xor i64 {found.get().text}, {bits.text}") * _PRIME
        high = c.emit(INT, f"lshr i64 {mixed.text}, 29")
        found.set(c.emit(INT, f"xor i64 {mixed.text}, {high.text}"))
    c.give(found.get())


@function("i32 px_iterate(ptr m, double t, i64 initial)")
def _iterate(c: Code, m: Value, t: Value, initial: Value) -> None:
    """The equations, and what assigns, with the stored truths as they are; then zero functions."""
    with c.when(~c.call(FLAG, "pc_outputs", m, t, m.load(POINTER, Own.Y)).equals(0), leaves=True):
        c.give(UNSOLVED)
    with c.when(c.call(FLAG, "pc_discrete", m, t) < 0, leaves=True):
        c.give(UNSOLVED)
    c.run("px_branches", m, initial)
    attempt(c, "px_assign", m, t)
    with c.when(~c.call(FLAG, "px_zeros", m, t).equals(0), leaves=True):
        c.give(UNSOLVED)
    c.give(0)


def doubt(c: Code, m: Value) -> None:
    m.store(whole(c, 1), Own.DOUBT)


@function("i64 px_clear(ptr m, i64 i, double quiet)")
def _clear(c: Code, m: Value, i: Value, quiet: Value, asks: bool) -> None:
    """Whether a zero function is more than rounding. One that was changed at this instant is known
    better than one that was integrated."""
    g = numbers_of(c, m, Relation.NOW).load(REAL, i)
    before = numbers_of(c, m, Relation.BEFORE).load(REAL, i)
    noise = numbers_of(c, m, Relation.LARGEST).load(REAL, i) * NOISE
    size = c.absolute(g)
    large = (size > quiet) & ((size > noise) | (c.absolute(g - before) > quiet))
    touch = told(c, i, Row.TOUCH).equals(1)
    of_touch, other = word(c, (g >= 0.0) | (size > noise)), word(c, (size <= EXACT) | large)
    if asks:
        with c.when(~touch & ~((size <= EXACT) | (size > larger(c, quiet, noise)))):
            doubt(c, m)
    c.give(c.select(touch, of_touch, other))


@function("i64 px_signs(ptr m, i64 careful)")
def _signs(c: Code, m: Value, careful: Value) -> None:
    """Truths from the zero functions, but not of those that are at zero here; 1 where one changed.
    `careful`: none becomes true while another one becomes false."""
    now, held, bound, restless, wanted = (
        numbers_of(c, m, k)
        for k in (Relation.NOW, Relation.HELD, Relation.BOUND, Relation.RESTLESS, Relation.TRIAL)
    )
    quiet, count = c.call(REAL, "px_quiet", m), plan(c, Table.RELATIONS)
    falling, changed = c.variable(0, INT), c.variable(0, INT)
    with c.loop(count) as i:
        wanted.store(0.0, i)
        g = now.load(REAL, i)
        with c.when(c.absolute(g) > bound.load(REAL, i)):
            held.store(whole(c, 0), i)
        free = held.load(INT, i).equals(0)
        other = differs(c, sign(c, i, g), truth(c, m, i))
        known = c.variable(told(c, i, Row.OF_TIME), INT)
        with c.when(free & other & known.get().equals(0)):
            known.set(c.call(INT, "px_clear", m, i, quiet))
        with c.when(free & other & known.get().equals(1)):
            wanted.store(1.0, i)
            with c.when(truth(c, m, i)):
                falling.set(whole(c, 1))
    late = careful.equals(1) & falling.get().equals(1)
    with c.loop(count) as i:
        waits = late & ~truth(c, m, i)
        with c.when(wanted.load(REAL, i).equals(1.0) & ~waits):
            set_truth(c, m, i, ~truth(c, m, i))
            restless.store(whole(c, 1), i)
            changed.set(whole(c, 1))
    c.give(changed.get())


@function("void px_release(ptr m)")
def _release(c: Code, m: Value, asks: bool) -> None:
    """Hold no relation any more of which a side was set anew."""
    now, held, at = (numbers_of(c, m, k) for k in (Relation.NOW, Relation.HELD, Relation.HELD_AT))
    quiet = c.call(REAL, "px_quiet", m)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        own = c.select(told(c, i, Row.TOUCH).equals(1), c.constant(0.0, REAL), quiet)
        way = c.absolute(now.load(REAL, i) - at.load(REAL, i))
        if asks:
            with c.when(held.load(INT, i).equals(1) & (way > 0.0) & (way <= own)):
                doubt(c, m)
        with c.when(way > own):
            held.store(whole(c, 0), i)
    c.give()


@function("i32 px_settle(ptr m, double t, i64 moved)", seldom=True)
def _settle(c: Code, m: Value, t: Value, moved: Value, asks: bool) -> None:
    seen, known, careful = m.load(POINTER, Own.SEEN), c.variable(0, INT), c.variable(0, INT)
    restless = numbers_of(c, m, Relation.RESTLESS)
    count = plan(c, Table.RELATIONS)
    with c.loop(count) as i:
        restless.store(whole(c, 0), i)
    # Loops of numbers that do not come to rest by themselves are closed in Python.
    most = whole(c, PATIENCE) if asks else plan(c, Table.DISCRETES) + PASSES
    with c.loop(most) as k:
        c.run("px_snapshot", m, whole(c, 0))
        attempt(c, "px_iterate", m, t, whole(c, 0))
        with c.when(k.equals(0) & moved.equals(1)):
            c.run("px_release", m)
        c.call(INT, "px_signs", m, careful.get())
        c.run("px_snapshot", m, whole(c, 1))
        with c.when(c.call(INT, "px_same", m, whole(c, 0), whole(c, 1)).equals(1), leaves=True):
            c.give(0)
        now, back = c.call(INT, "px_hash", m, whole(c, 1)), c.variable(0, INT)
        with c.loop(known.get()) as i, c.when(seen.load(INT, i).equals(now)):
            back.set(whole(c, 1))
        with c.when(back.get().equals(1)):
            with c.when(careful.get().equals(1), leaves=True):
                c.give(c.call(FLAG, "px_search", m, t))
            careful.set(whole(c, 1))
            known.set(whole(c, 0))
            with c.loop(count) as i:
                restless.store(whole(c, 0), i)
        seen.store(now, known.get())
        known.set(known.get() + 1)
    c.give(ENDLESS)


@function("i64 px_agrees(ptr m, double t, double near)", seldom=True)
def _agrees(c: Code, m: Value, t: Value, near: Value) -> None:
    """Whether the truths as they are follow from their own equations."""
    now, largest, held, bound, at = (
        numbers_of(c, m, k)
        for k in (Relation.NOW, Relation.LARGEST, Relation.HELD, Relation.BOUND, Relation.HELD_AT)
    )
    with c.loop(PASSES):
        c.run("px_snapshot", m, whole(c, 0))
        with c.when(~c.call(FLAG, "px_iterate", m, t, whole(c, 0)).equals(0), leaves=True):
            m.store(whole(c, 0), Own.ENDED)
            c.give(0, INT)
        c.run("px_snapshot", m, whole(c, 1))
        with c.when(c.call(INT, "px_same", m, whole(c, 0), whole(c, 1)).equals(1), leaves=True):
            with c.loop(plan(c, Table.RELATIONS)) as i:  # as good as zero: keep the truth
                size = c.absolute(now.load(REAL, i))
                small = size <= near * larger(c, largest.load(REAL, i), c.constant(1.0, REAL))
                with c.when(small & told(c, i, Row.OF_TIME).equals(0)):
                    held.store(whole(c, 1), i)
                    at.store(now.load(REAL, i), i)
                    bound.store(size * 2.0, i)
            c.give(whole(c, 1) - c.call(INT, "px_signs", m, whole(c, 0)))
    c.give(0, INT)


@function("i32 px_search(ptr m, double t)", seldom=True)
def _search(c: Code, m: Value, t: Value) -> None:
    """Try all truths of the restless relations, those nearest to the present ones first, until one
    choice agrees with its own equations. What agrees less exactly crosses again further off."""
    restless, left = (numbers_of(c, m, k) for k in (Relation.RESTLESS, Relation.BEYOND))
    count = plan(c, Table.RELATIONS)
    places, own = c.place(INT, MOST_SEARCHED), c.place(INT, MOST_SEARCHED)
    total = c.variable(0, INT)
    with c.loop(count) as i:
        taken = restless.load(INT, i).equals(1) & (total.get() < MOST_SEARCHED)
        with c.when(taken):
            places.store(i, total.get())
            own.store(word(c, truth(c, m, i)), total.get())
            total.set(total.get() + 1)
    k = total.get()
    choices = c.emit(INT, f"shl i64 1, {k.text}")
    for near in EXACTLY:
        with c.loop(k + 1) as flipped, c.loop(choices) as n:
            bits = c.emit(INT, f"call i64 @llvm.ctpop.i64(i64 {n.text})")
            with c.when(bits.equals(flipped)):
                with c.loop(k) as i:
                    shifted = c.emit(INT, f"lshr i64 {n.text}, {i.text}")
                    flip = c.emit("i1", f"trunc i64 {shifted.text} to i1")
                    other = differs(c, flip, own.load(INT, i).equals(1))
                    set_truth(c, m, places.load(INT, i), other)
                good = c.call(INT, "px_agrees", m, t, c.constant(near, REAL))
                with c.when(good.equals(1), leaves=True):
                    if near:
                        with c.loop(count) as i:
                            left.store(restless.load(INT, i), i)
                    c.give(0)
    c.give(ENDLESS)


@function("i32 px_turn(ptr m, double t)", seldom=True)
def _turn(c: Code, m: Value, t: Value, asks: bool) -> None:
    now, largest, rises, bent, held, at, bound, late, turned, left = (
        numbers_of(c, m, k)
        for k in (Relation.NOW, Relation.LARGEST, Relation.RISES, Relation.TRIAL, Relation.HELD,
                  Relation.HELD_AT, Relation.BOUND, Relation.LATE, Relation.TURNED, Relation.BEYOND)
    )  # fmt: skip
    count, some, flat = plan(c, Table.RELATIONS), c.variable(0, INT), c.variable(0, INT)

    def rest(i: Value) -> Value:
        """How far from zero one at zero may be."""
        noise = largest.load(REAL, i) * NOISE
        counts = late.load(INT, i).equals(0) | m.load(INT, Own.RESET).equals(1)
        own = bound.load(REAL, i)
        return c.select((own >= 0.0) & counts, own, noise)

    def near(i: Value) -> Value:
        size = c.absolute(now.load(REAL, i))
        return (turned.load(INT, i) < MOST_TURNS) & (size <= larger(c, rest(i), NOISE))

    with c.loop(count) as i, c.when(near(i)):
        some.set(whole(c, 1))
    with c.when(some.get().equals(0), leaves=True):
        c.give(0)
    with c.when(~c.call(FLAG, "px_rises", m, t, whole(c, 0)).equals(0), leaves=True):
        c.give(0)

    def least(i: Value) -> Value:
        return largest.load(REAL, i) * (1e-4 * NOISE)

    def is_flat(i: Value, pace: Value) -> Value:
        # What begins to slide has no pace at first, but for how its surfaces turn meanwhile.
        flat = c.absolute(pace) <= least(i)
        return flat if asks else told(c, i, Row.TOUCH).equals(1) | flat

    with c.loop(count) as i:
        bent.store(rises.load(REAL, i), i)
        with c.when(near(i) & is_flat(i, rises.load(REAL, i))):
            flat.set(whole(c, 1))
    with c.when(flat.get().equals(1)):
        flag = c.call(FLAG, "px_rises", m, t, whole(c, 1))
        with c.loop(count) as i:
            first = bent.load(REAL, i)
            second = c.select(flag.equals(0), rises.load(REAL, i), first)
            rises.store(c.select(is_flat(i, first), second, first), i)
    changed = c.variable(c.constant(0, FLAG), FLAG)
    with c.loop(count) as i, c.when(near(i)):
        size, rise = c.absolute(now.load(REAL, i)), rises.load(REAL, i)
        soon = larger(c, rest(i), c.absolute(rise) * SOON)
        other = differs(c, rise < 0.0, truth(c, m, i))
        with c.when((size <= soon) & (c.absolute(rise) > least(i)) & other):
            set_truth(c, m, i, rise < 0.0)
            held.store(whole(c, 1), i)
            at.store(now.load(REAL, i), i)
            bound.store(larger(c, rest(i), size), i)
            with c.when(turned.load(INT, i).equals(MOST_TURNS - 1)):  # it was turned back
                left.store(whole(c, 1), i)
            turned.store(turned.load(INT, i) + 1, i)
            changed.set(c.constant(1, FLAG))
    c.give(changed.get())
