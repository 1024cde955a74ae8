"""Other states where the present ones go bad, in LLVM.

    px_look(block) -> sensitivity     the largest one, as `codegen.native.look` measures it
    px_measure(block)                 the margin that it leaves
    px_exchange(block) -> changed     the workspace at an accepted point; states and bound anew

The rule is `solve.states.selector`: candidates are exchanged where a state says too little of
what follows from it. Which ones the states are stands in the kernel's numbers; they are those
of the model description by their places, `_state[1]` and so on.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import Block, open_frame
from planarc.instance.block import constant, hold, plan, whole
from planarc.instance.plan import Own, Table
from planarc.ir.frame import Number, Record
from planarc.ir.newton import GROWN, WORST


def state_functions() -> tuple[str, ...]:
    return _look(), _measure(), _sort(), _block(), _exchange(), _choose()


@function("double px_look(ptr m)")
def _look(c: Code, m: Value) -> None:
    blocks, scales = constant(c, "px_open"), m.load(POINTER, Own.SCALES)
    c.give(c.call(REAL, "pc_look", m, blocks, plan(c, Table.OPEN), scales), REAL)


@function("void px_measure(ptr m)")
def _measure(c: Code, m: Value) -> None:
    """Where it is used up, the bound is passed for certain."""
    left = m.load(REAL, Own.BOUND) * 1.001 - c.call(REAL, "px_look", m)
    m.store(c.select(left > -1e300, left, -1e300), Own.MARGIN)
    c.give()


@function("void px_sort(ptr row, i64 count)")
def _sort(c: Code, row: Value, count: Value) -> None:
    with c.loop(count, 1) as i, c.loop(i) as k:
        a, b = row.load(INT, k), row.load(INT, i)
        with c.when(a > b):
            row.store(b, k)
            row.store(a, i)
    c.give()


@function("i64 px_exchange_in(ptr m, ptr place, ptr scales, ptr stay)", seldom=True)
def _block(c: Code, m: Value, place: Value, scales: Value, stay: Value) -> None:
    """Exchange candidates of one block; gives how often."""
    b = Block(m, constant(c, "pc_blocks").at(place.load(INT)))
    count, done = c.variable(0, INT), c.variable(0, INT)
    with c.loop(b.n), c.when(done.get().equals(0)):
        done.set(whole(c, 1))
        size = c.call(REAL, "pc_look", m, place, whole(c, 1), scales)
        with c.when((size > WORST) & (size < 1e300)):
            most, row, taken = c.variable(WORST), c.variable(0, INT), c.variable(0, INT)
            column = c.variable(b.m, INT)
            with c.loop(b.n) as tear:
                free = c.variable(1, INT)
                with c.loop(b.m) as k, c.when(b.solved.load(INT, k).equals(tear)):
                    free.set(whole(c, 0))
                with c.when(free.get().equals(1)):
                    j = column.get()
                    with c.when(stay.load(INT, tear).equals(0)), c.loop(b.m) as k:
                        x = b.matrix.load(REAL, k * b.n + j) / b.matrix.load(REAL, k * b.n + k)
                        with c.when(c.absolute(x) > most.get()):
                            most.set(c.absolute(x))
                            row.set(k)
                            taken.set(tear)
                    column.set(j + 1)
            with c.when(most.get() > WORST):
                b.solved.store(taken.get(), row.get())
                c.run("px_sort", b.solved, b.m)
                count.set(count.get() + 1)
                done.set(whole(c, 0))
    c.give(count.get())


@function("i32 px_exchange(ptr m)", seldom=True)
def _exchange(c: Code, m: Value) -> None:
    places, stay = constant(c, "px_open"), constant(c, "px_stay")
    scales = m.load(POINTER, Own.SCALES)
    table = constant(c, "pc_blocks")
    count, first = c.variable(0, INT), c.variable(0, INT)
    with c.loop(plan(c, Table.OPEN)) as k:
        own = scales.at(first.get())
        more = c.call(INT, "px_exchange_in", m, places.at(k), own, stay.at(first.get()))
        count.set(count.get() + more)
        first.set(first.get() + table.at(places.load(INT, k)).load(INT, Record.TEARS))
    with c.when(count.get() > 0):
        c.run("px_choose", m)
        hold(c, m)  # what is near is told by states
    worst = c.call(REAL, "px_look", m)
    kept = c.select(worst > WORST, worst * GROWN, WORST)
    m.store(c.select(kept < 1e300, kept, 1e300), Own.BOUND)
    m.store(whole(c, 0), Own.WAITING)
    m.store(whole(c, 0), Own.EXACT)
    c.give(c.flag(count.get()))


@function("void px_choose(ptr m)", seldom=True)
def _choose(c: Code, m: Value) -> None:
    """The kernel's numbers, and the states' values, for what is determined in each block."""
    w, numbers, _, _ = open_frame(m)
    table, follow = constant(c, "pc_blocks"), constant(c, "px_follow")
    at = c.variable(1, INT)
    with c.loop(follow.load(INT)):  # blocks whose choice is that of another one
        own, leader = (Block(m, table.at(follow.load(INT, at.get() + i))) for i in (0, 1))
        places = follow.at(at.get() + 2)
        with c.loop(leader.m) as k:
            own.solved.store(places.load(INT, leader.solved.load(INT, k)), k)
        c.run("px_sort", own.solved, own.m)
        at.set(at.get() + 2 + own.n)
    states, y = plan(c, Table.STATES), m.load(POINTER, Own.Y)
    first = numbers.at(Number.FIRST_STATE)
    row, state = c.variable(1, INT), c.variable(0, INT)
    with c.loop(table.load(INT)):
        b = Block(m, table.at(row.get()))
        with c.when(b.below), c.loop(b.n) as tear:
            free = c.variable(1, INT)
            with c.loop(b.m) as i, c.when(b.solved.load(INT, i).equals(tear)):
                free.set(whole(c, 0))
            with c.when(free.get().equals(1)):
                slot = b.slots.load(INT, tear)
                first.store(slot, state.get())
                first.store(b.slots.load(INT, b.n + tear), states + state.get())
                y.store(w.load(REAL, slot), state.get())
                state.set(state.get() + 1)
        row.set(row.get() + b.n * 3 + Record.SLOTS)
    c.give()
