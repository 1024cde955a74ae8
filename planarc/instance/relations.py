"""Relations of an exported model: their zero functions, and the truths that are stored.

    px_zeros(block, t) -> flag         the zero functions at time and states; largest sizes
    px_indicate(block) -> flag         what a host sees of them
    px_crossed(block, zeros) -> way    from here to the next crossing of any; 0 or less: gone
    px_passed(block, t)                widths and sizes where a step was accepted
    px_rises(block, t, bent) -> flag   how far each moves within a short time
    px_quiet(block) -> size            below which a number may be rounding alone
    px_widen(block, t) -> flag         how far beyond zero each one crosses next

A relation is true where its zero function is negative, and, when it is not strict, where it is
zero. Between events its truth is stored, and a zero function may cross only in one way. It
has done so when it is beyond zero by `NOISE` of its largest size, or by more where an event left
it on the other side, or standing at zero.

Reference: `solve.events.crossings`, which says the same for a run.
"""

from __future__ import annotations

from collections.abc import Collection

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function, table
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import constant, larger, plan, whole
from planarc.instance.plan import Look, Own, Relation, Row, Table, swinging
from planarc.ir.program import Program
from planarc.solve.contact.touches import Points
from planarc.solve.events.crossings import FURTHER_OFF, NOISE, QUIET
from planarc.solve.events.instants import DIGITS

#: What moves by less than so many times what may be rounding stands still.
STILL = 4.0
#: The least width, and what is more than the width needs to be.
LEAST, MORE = 1e-100, 1.0 + 1e-6
_EPSILON = 2.0**-52


def relation_functions() -> tuple[str, ...]:
    return _zeros(False), _indicate(), _crossed(), _passed(), _rises(), _quiet(), _widen()


def zero_functions() -> tuple[str, ...]:
    """Those that a run in Python asks for."""
    return _zeros(True), _rises(), _quiet()


def relation_table(program: Program, timed: Collection[int]) -> str:
    """Rows as of `plan.Row`; `timed` are relations whose instants are known."""
    touching, swings = Points(program).components, swinging(program, timed)
    rows = (
        (r.slot, r.strict, r.time_only, i in timed, swings.get(i, 0), r.component in touching)
        for i, r in enumerate(program.relations)
    )
    return table("px_relations", (int(n) for row in rows for n in row))


def numbers_of(c: Code, m: Value, which: Relation) -> Value:
    """An array with a number for each relation."""
    return m.load(POINTER, Own.RELATIONS).at(plan(c, Table.RELATIONS) * int(which))


def looked(c: Code, m: Value, which: Look) -> Value:
    """Zero functions at a time within a step."""
    return m.load(POINTER, Own.LOOKS).at(plan(c, Table.RELATIONS) * int(which))


def told(c: Code, i: Value, which: Row) -> Value:
    """What the model says of a relation."""
    return constant(c, "px_relations").load(INT, i * len(Row) + int(which))


def truth(c: Code, m: Value, i: Value) -> Value:
    """The stored one."""
    w, _, _, _ = open_frame(m)
    return ~w.load(REAL, told(c, i, Row.SLOT)).equals(0.0)


def set_truth(c: Code, m: Value, i: Value, bit: Value) -> None:
    w, _, _, _ = open_frame(m)
    w.store(c.select(bit, c.constant(1.0, REAL), 0.0), told(c, i, Row.SLOT))


def sign(c: Code, i: Value, g: Value) -> Value:
    """The truth that the value of a zero function stands for."""
    return (g < 0.0) | (g.equals(0.0) & told(c, i, Row.STRICT).equals(0))


def differs(c: Code, one: Value, two: Value) -> Value:
    return c.emit("i1", f"xor i1 {one.text}, {two.text}")


def word(c: Code, bit: Value) -> Value:
    return c.emit(INT, f"zext i1 {bit.text} to i64")


def room(c: Code, t: Value) -> Value:
    """How far two instants may be apart that are one."""
    return larger(c, c.absolute(t) * (DIGITS * _EPSILON), 1e-14)


def attempt(c: Code, function: str, *arguments: Value) -> None:
    """Call, and give its flag where that is not 0."""
    flag = c.call(FLAG, function, *arguments)
    with c.when(~flag.equals(0), leaves=True):
        c.give(flag)


@function("i32 px_zeros(ptr m, double t)")
def _zeros(c: Code, m: Value, t: Value, asks: bool) -> None:
    now, largest = (numbers_of(c, m, k) for k in (Relation.NOW, Relation.LARGEST))
    leaps = numbers_of(c, m, Relation.INSTANT)  # of a run that finds instants by itself
    attempt(c, "pc_roots", m, t, m.load(POINTER, Own.Y), now)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        size, seen = c.absolute(now.load(REAL, i)), largest.load(REAL, i)
        more = size > seen
        if asks:  # what stands at a pole says nothing of sizes
            more = more & leaps.load(REAL, i).equals(0.0)
        largest.store(c.select(more, size, seen), i)
    c.give(0)


@function("i32 px_indicate(ptr m)")
def _indicate(c: Code, m: Value) -> None:
    """At a point that was evaluated."""
    w, _, _, _ = open_frame(m)
    now, width, shown = (
        numbers_of(c, m, k) for k in (Relation.NOW, Relation.WIDTH, Relation.SHOWN)
    )
    attempt(c, "pc_zeros", m, w.load(REAL), now)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        far = width.load(REAL, i)
        shown.store(now.load(REAL, i) + c.select(truth(c, m, i), -far, far), i)
    c.give(0)


@function("double px_crossed(ptr m, ptr zeros)")
def _crossed(c: Code, m: Value, zeros: Value) -> None:
    least, width = c.variable(1e300), numbers_of(c, m, Relation.WIDTH)
    with c.loop(plan(c, Table.RELATIONS)) as i, c.when(told(c, i, Row.TIMED).equals(0)):
        g = zeros.load(REAL, i)
        way = c.select(truth(c, m, i), -g, g) + width.load(REAL, i)
        least.set(c.select(way < least.get(), way, least.get()))
    c.give(least.get(), REAL)


@function("void px_passed(ptr m, double t)")
def _passed(c: Code, m: Value, t: Value) -> None:
    """A point was accepted: sizes, and widths of those that went far from zero."""
    now, largest, width = (
        numbers_of(c, m, k) for k in (Relation.NOW, Relation.LARGEST, Relation.WIDTH)
    )
    c.call(FLAG, "pc_zeros", m, t, now)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        g, seen = now.load(REAL, i), largest.load(REAL, i)
        size = c.absolute(g)
        largest.store(c.select(size > seen, size, seen), i)
        with c.when(c.select(truth(c, m, i), -g, g) > width.load(REAL, i)):
            width.store(larger(c, largest.load(REAL, i) * NOISE, LEAST), i)
    c.give()


@function("i32 px_rises(ptr m, double t, i64 bent)")
def _rises(c: Code, m: Value, t: Value, bent: Value) -> None:
    """To first order, or to the second; the workspace is that of a later time afterwards."""
    n, y = plan(c, Table.STATES), m.load(POINTER, Own.Y)
    slope = m.load(POINTER, Own.STAGES)
    later, last = slope.at(n), slope.at(n * 2)
    now, rises = (numbers_of(c, m, k) for k in (Relation.NOW, Relation.RISES))
    ahead = larger(c, room(c, t) * 4.0, m.load(REAL, Own.AHEAD))
    m.store(whole(c, 0), Own.EXACT)
    attempt(c, "pc_rhs", m, t, y, slope)
    attempt(c, "px_zeros", m, t)
    with c.loop(n) as i:
        later.store(y.load(REAL, i) + ahead * slope.load(REAL, i), i)
    with c.when(bent.equals(1)):
        attempt(c, "pc_rhs", m, t + ahead, later, last)
        with c.loop(n) as i:
            mean = (slope.load(REAL, i) + last.load(REAL, i)) * 0.5
            later.store(y.load(REAL, i) + ahead * mean, i)
    attempt(c, "pc_roots", m, t + ahead, later, rises)
    with c.loop(plan(c, Table.RELATIONS)) as i:
        rises.store(rises.load(REAL, i) - now.load(REAL, i), i)
    c.give(0)


@function("double px_quiet(ptr m)")
def _quiet(c: Code, m: Value) -> None:
    w, _, _, _ = open_frame(m)
    size, slots = c.variable(1.0), constant(c, "px_quiet_slots")
    with c.loop(plan(c, Table.QUIET)) as i:
        value = c.absolute(w.load(REAL, slots.load(INT, i)))
        size.set(c.select(value > size.get(), value, size.get()))
    c.give(size.get() * QUIET, REAL)


@function("i32 px_widen(ptr m, double t)")
def _widen(c: Code, m: Value, t: Value) -> None:
    count = plan(c, Table.RELATIONS)
    now, largest, width, rises, left = (
        numbers_of(c, m, k)
        for k in (Relation.NOW, Relation.LARGEST, Relation.WIDTH, Relation.RISES, Relation.BEYOND)
    )
    attempt(c, "px_zeros", m, t)
    quiet = c.call(REAL, "px_quiet", m)
    near = c.variable(0, INT)
    with c.loop(count) as i:
        rises.store(1e300, i)
        with c.when(c.absolute(now.load(REAL, i)) <= quiet):
            near.set(whole(c, 1))
    with c.when(near.get().equals(1)):
        flag = c.call(FLAG, "px_rises", m, t, whole(c, 0))
        with c.when(~flag.equals(0)), c.loop(count) as i:
            rises.store(1e300, i)
    with c.loop(count) as i:
        g = now.load(REAL, i)
        far = c.variable(larger(c, largest.load(REAL, i) * NOISE, LEAST))
        beyond = c.select(truth(c, m, i), g, -g)
        with c.when(beyond > 0.0):
            more = c.select(left.load(INT, i).equals(1), c.constant(FURTHER_OFF, REAL), MORE)
            far.set(far.get() + beyond * more)
        # What a touch compares is known better: bounces may be lower than what is quiet.
        touch = told(c, i, Row.TOUCH).equals(1)
        least = c.select(touch, largest.load(REAL, i) * NOISE, quiet)
        stands = (c.absolute(rises.load(REAL, i)) <= least * STILL) & (c.absolute(g) <= least)
        with c.when(stands):
            far.set(larger(c, far.get(), least * STILL))
        width.store(far.get(), i)
    c.give(0)
