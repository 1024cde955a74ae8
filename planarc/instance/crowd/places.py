"""Values and pushes of ports, states and their derivatives, in LLVM.

px_see(block, t, states) -> flag         evaluate, also what stands in no slot
px_collect(block, values, count, out)     values of the table
px_push(block, forces)                   set the force at each port
px_rates(block, out)                     derivatives of the states, from the workspace
px_kinds(block)                          which states are places, and where their speeds are
px_speeds(block, t, states, out) -> flag the derivatives of the places
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import constant, plan, whole
from planarc.instance.crowd.layout import Area, Count, Part, arrays, part, said
from planarc.instance.plan import Table
from planarc.instance.relations import attempt, word
from planarc.ir.frame import Number


def place_functions() -> tuple[str, ...]:
    return _see(), _gather(), _push(), _rates(), _kinds(), _speeds()


def rate_slots(c: Code, m: Value) -> Value:
    """The slots of the states' derivatives."""
    _, numbers, _, _ = open_frame(m)
    return numbers.at(plan(c, Table.STATES) + int(Number.FIRST_STATE))


@function("i32 px_see(ptr m, double t, ptr y)")
def _see(c: Code, m: Value, t: Value, y: Value) -> None:
    attempt(c, "pc_outputs", m, t, y)
    c.run("px_feel", m, t, *arrays(m, Area.SENSED))
    c.give(0)


@function("void px_collect(ptr m, ptr values, i64 count, ptr out)")
def _gather(c: Code, m: Value, values: Value, count: Value, out: Value) -> None:
    w, _, _, _ = open_frame(m)
    (sensed,) = arrays(m, Area.SENSED)
    size = plan(c, Table.SIZE)
    with c.loop(count) as i:
        place = values.load(INT, i)
        out.store(c.select(place < size, w.at(place), sensed.at(place - size)).load(REAL), i)
    c.give()


@function("void px_push(ptr m, ptr forces)")
def _push(c: Code, m: Value, forces: Value) -> None:
    w, _, _, _ = open_frame(m)
    now, before = part(c, Part.PUSHES), part(c, Part.BEFORE)
    with c.loop(said(c, Count.PORTS)) as i:
        force = forces.load(REAL, i)
        w.store(force, now.load(INT, i))
        w.store(force, before.load(INT, i))
    c.give()


@function("void px_rates(ptr m, ptr out)")
def _rates(c: Code, m: Value, out: Value) -> None:
    w, _, _, _ = open_frame(m)
    slots = rate_slots(c, m)
    with c.loop(plan(c, Table.STATES)) as i:
        out.store(w.load(REAL, slots.load(INT, i)), i)
    c.give()


@function("void px_kinds(ptr m)")
def _kinds(c: Code, m: Value) -> None:
    """A state is a place where its derivative is a candidate, too."""
    _, numbers, _, _ = open_frame(m)
    where, is_place, speed, candidate = arrays(
        m, Area.WHERE, Area.IS_PLACE, Area.SPEED, Area.CANDIDATE
    )
    size, slots = plan(c, Table.SIZE), numbers.at(int(Number.FIRST_STATE))
    of_states, candidates = where.at(size), constant(c, "px_system").at(5)
    with c.loop(size * 2) as i:
        where.store(whole(c, -1), i)
    with c.loop(plan(c, Table.MOVED)) as i:
        where.store(i, candidates.load(INT, i))
    with c.loop(plan(c, Table.STATES)) as i:
        of_states.store(i, slots.load(INT, i))
    rates = rate_slots(c, m)
    with c.loop(plan(c, Table.STATES)) as i:
        rate = rates.load(INT, i)
        is_place.store(word(c, where.load(INT, rate) >= 0), i)
        speed.store(of_states.load(INT, rate), i)
        candidate.store(where.load(INT, slots.load(INT, i)), i)
    c.give()


@function("i32 px_speeds(ptr m, double t, ptr y, ptr out)")
def _speeds(c: Code, m: Value, t: Value, y: Value, out: Value) -> None:
    is_place, speed = arrays(m, Area.IS_PLACE, Area.SPEED)
    states, known = plan(c, Table.STATES), c.variable(1, INT)
    with c.loop(states) as i:
        lacks = is_place.load(INT, i).equals(1) & (speed.load(INT, i) < 0)
        known.set(c.select(lacks, whole(c, 0), known.get()))
    with c.when(known.get().equals(1), leaves=True):
        with c.loop(states) as i, c.when(is_place.load(INT, i).equals(1)):
            out.store(y.load(REAL, speed.load(INT, i)), i)
        c.give(0)
    attempt(c, "px_see", m, t, y)
    c.run("px_rates", m, out)
    c.give(0)
