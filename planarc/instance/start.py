"""Start values that fit together, from the assembly found at export, for other parameters.

    px_start(block) -> flag     the workspace at the start; 1 where no start is found

The conditions are those of `solve.start.system`: the residuals of the blocks below the top,
initial equations, and what was held at export. Newton's steps have the least norm, so that what
no condition determines stays where it was, and are at most `LONGEST` long; each must lessen the
residuals. Where the whole way from the parameters at export to the new ones is too far, it is gone
in parts, so that a loop stays in the assembly that was found at export.

Example: a four-bar exported with its coupler up, and another length of the crank: the loop
closes with its coupler up.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.instance.block import constant, hold, image, is_null, larger, plan, whole
from planarc.instance.events import SETTLED
from planarc.instance.plan import PARAMETER, Own, Stale, Table
from planarc.instance.relations import attempt
from planarc.ir.frame import ARRAYS, Number, Record

#: Longest change of an unknown in one step, and how often one is halved.
LONGEST, HALVINGS, STEPS = 0.5, 12, 60
#: The least part of the way to other parameters that is gone at once.
SMALLEST = 2.0**-8
#: Residuals below this part of their rows count as zero (`solve.start.newton.SMALL`).
SMALL = 1e-10
#: Rounds of start values and truths before they are called contradictory.
ROUNDS = 50
#: What is added to the diagonal of rows that may depend on each other.
MORE = 1e-13


def start_functions(apart: bool) -> tuple[str, ...]:
    return _start(), _blame(), _assemble(apart), _part(apart), _rows(), _solve(), _step()


def _counts(c: Code) -> tuple[Value, Value, Value, Value]:
    """The table of the start system; how many unknowns, rows, and rows that hold a value."""
    table = constant(c, "px_system")
    return table, plan(c, Table.MOVED), plan(c, Table.WIDTH), plan(c, Table.HELD)


@function("i32 px_start(ptr m)", seldom=True)
def _start(c: Code, m: Value) -> None:
    """Start values and what is true there by turns: each may change what the other one is."""
    w, _, _, _ = open_frame(m)
    begins, done = plan(c, Table.BEGIN), c.variable(0, INT)
    with c.when(begins >= 0):
        w.store(w.load(REAL), begins)
    attempt(c, "px_prepare", m)
    with c.loop(ROUNDS), c.when(done.get().equals(0)):
        attempt(c, "px_assemble", m)
        flag = c.call(FLAG, "px_settled", m)
        with c.when(flag > 0, leaves=True):
            c.give(flag)
        with c.when(flag.equals(SETTLED)):
            done.set(whole(c, 1))
    with c.when(done.get().equals(0), leaves=True):
        c.give(1)
    attempt(c, "px_first", m)
    c.call(FLAG, "px_exchange", m)
    m.store(whole(c, Stale.REST), Own.STALE)
    c.give(c.call(FLAG, "pc_rhs", m, w.load(REAL), m.load(POINTER, Own.Y),
                  m.load(POINTER, Own.RATES)))  # fmt: skip


@function("void px_blame(ptr m)", seldom=True)
def _blame(c: Code, m: Value) -> None:
    """What failed is the loop that is farthest from closing."""
    _, numbers, _, area = open_frame(m)
    table, row, most = constant(c, "pc_blocks"), c.variable(1, INT), c.variable(0.0)
    with c.loop(table.load(INT)) as k:
        record = table.at(row.get())
        residuals = area.at(record.load(INT, Record.AREA) + ARRAYS)
        closes = record.load(INT, Record.BELOW) > record.load(INT, Record.LINEAR)
        with c.when(closes), c.loop(record.load(INT, Record.RESIDUALS)) as i:
            size = c.absolute(residuals.load(REAL, i))
            with c.when(size > most.get()):
                most.set(size)
                numbers.store(k, Number.FAILED)
        row.set(row.get() + record.load(INT, Record.TEARS) * 3 + Record.SLOTS)
    c.give()


@function("i32 px_assemble(ptr m)", seldom=True)
def _assemble(c: Code, m: Value, apart: bool) -> None:
    w, numbers, _, _ = open_frame(m)
    table, moved, width, _ = _counts(c)
    size = plan(c, Table.SIZE)
    # rows with their slopes, a trial row, sizes, matrix with its right side, solution, step;
    # the values wanted, the last ones found
    room = (moved + 1) * width + width * 8 + width * width + moved * 2
    memory = c.call(POINTER, "calloc", room + size + moved, whole(c, 8))
    with c.when(is_null(c, memory), leaves=True):
        c.give(1)
    wanted = memory.at(room)
    found, candidates = wanted.at(size), table.at(5)
    c.run("px_copy", wanted, w, size)
    there, part, flag = c.variable(0.0), c.variable(1.0), c.variable(c.constant(0, FLAG), FLAG)
    before = image(c, m, apart).at(plan(c, Table.WORKSPACE))
    with c.loop(moved) as i:
        found.store(before.load(REAL, candidates.load(INT, i)), i)
    again, failed, behind = c.label(), c.label(), c.label()
    c.enter(again)
    with c.loop(moved) as i:
        w.store(found.load(REAL, i), candidates.load(INT, i))
    reach = there.get() + part.get()
    flag.set(c.call(FLAG, "px_part", m, wanted, c.select(reach < 1.0, reach, 1.0)))
    with c.when(flag.get().equals(0)):
        flag.set(c.call(FLAG, "px_solve", m, memory))
    good = c.label()
    c.branch(flag.get().equals(0), good, failed)
    c.begin(good)
    there.set(reach)
    with c.loop(moved) as i:
        found.store(w.load(REAL, candidates.load(INT, i)), i)
    c.branch(reach < 1.0, again, behind)
    c.begin(failed)
    part.set(part.get() * 0.5)
    c.branch(part.get() > SMALLEST, again, behind)
    c.begin(behind)
    c.run("free", memory)
    with c.when(~flag.get().equals(0), leaves=True):
        c.run("px_blame", m)
        c.give(flag.get())
    states = plan(c, Table.STATES)
    slots, y = numbers.at(Number.FIRST_STATE), m.load(POINTER, Own.Y)
    with c.loop(states) as i:
        y.store(w.load(REAL, slots.load(INT, i)), i)
    hold(c, m)
    ended = c.call(FLAG, "pc_rhs", m, w.load(REAL), y, m.load(POINTER, Own.RATES))
    with c.when(ended.equals(0)):
        hold(c, m)
        c.call(FLAG, "px_exchange", m)
    c.give(ended)


@function("i32 px_part(ptr m, ptr wanted, double part)", seldom=True)
def _part(c: Code, m: Value, wanted: Value, part: Value, apart: bool) -> None:
    """A part of the way from the values at export to those that the host wants."""
    w, _, _, _ = open_frame(m)
    before = image(c, m, apart).at(plan(c, Table.WORKSPACE))
    rules = m.load(POINTER, Own.RULES)

    def between(slot: Value, end: Value) -> Value:
        start = before.load(REAL, slot)
        return c.select(part >= 1.0, end, start + (end - start) * part)

    with c.loop(plan(c, Table.SIZE)) as i, c.when(rules.load(INT, i).equals(PARAMETER)):
        w.store(between(i, wanted.load(REAL, i)), i)
    flag = c.call(FLAG, "pc_parameters", m, w.load(REAL))
    given, starts = m.load(POINTER, Own.GIVEN), m.load(POINTER, Own.STARTS)
    slots = constant(c, "px_starts")
    with c.loop(plan(c, Table.GIVEN)) as k, c.when(given.load(INT, k) > 0):
        slot = slots.load(INT, k)
        w.store(between(slot, starts.load(REAL, k)), slot)
    c.give(flag)


@function("i32 px_rows(ptr m, ptr function, ptr rows)", seldom=True)
def _rows(c: Code, m: Value, differences: Value, rows: Value) -> None:
    """The residuals, and their slopes where that function is given."""
    table, _, width, held = _counts(c)
    w, _, _, _ = open_frame(m)
    flag = differences.call(FLAG, m, table, rows)
    with c.when(~flag.equals(0), leaves=True):
        c.give(flag)
    slots = constant(c, "px_wanted")
    own = rows.at(width - held)
    with c.loop(held) as k:
        own.store(own.load(REAL, k) - w.load(REAL, slots.load(INT, k)), k)
    c.give(0)


def _norm(c: Code, rows: Value, sizes: Value, width: Value) -> Value:
    total = c.variable(0.0)
    with c.loop(width) as i:
        part = rows.load(REAL, i) / sizes.load(REAL, i)
        total.set(total.get() + part * part)
    return total.get()


@function("i32 px_solve(ptr m, ptr memory)", seldom=True)
def _solve(c: Code, m: Value, memory: Value) -> None:
    """Newton's method; the workspace is left at the solution."""
    table, moved, width, _ = _counts(c)
    w, _, _, _ = open_frame(m)
    candidates = table.at(5)
    trial = memory.at((moved + 1) * width)
    sizes = trial.at(width)
    step = sizes.at(width * 7 + width * width)
    before = step.at(moved)
    done = c.variable(0, INT)
    with c.when(width.equals(0) | moved.equals(0), leaves=True):
        c.give(0)
    with c.loop(STEPS), c.when(done.get().equals(0)):
        rows = Value(c, POINTER, "@pc_differences")
        flag = c.call(FLAG, "px_rows", m, rows, memory)
        with c.when(~flag.equals(0), leaves=True):
            c.give(flag)
        small, longest, most = c.variable(1, INT), c.variable(0.0), c.variable(0.0)
        with c.loop(width) as i:
            most.set(larger(c, most.get(), c.absolute(memory.load(REAL, i))))
        point = Value(c, POINTER, "@pc_point")
        with c.when(most.get().equals(0.0), leaves=True):  # of many bodies a step takes minutes
            c.give(c.call(FLAG, "px_rows", m, point, trial))
        with c.loop(width) as i:
            size = c.variable(0.0)
            with c.loop(moved) as j:
                slope = c.absolute(memory.load(REAL, (j + 1) * width + i))
                size.set(larger(c, size.get(), slope))
            limit = larger(c, size.get(), c.constant(1e-3, REAL)) * SMALL
            with c.when(~(c.absolute(memory.load(REAL, i)) <= limit)):
                small.set(whole(c, 0))
            sizes.store(larger(c, size.get(), c.constant(1.0, REAL)), i)
        flag = c.call(FLAG, "px_step", memory, sizes, step)
        with c.when(~flag.equals(0), leaves=True):
            c.give(c.select(small.get().equals(1), c.constant(0, FLAG), c.constant(1, FLAG)))
        with c.loop(moved) as j:
            longest.set(larger(c, longest.get(), c.absolute(step.load(REAL, j))))
            before.store(w.load(REAL, candidates.load(INT, j)), j)
        part = c.variable(c.select(longest.get() > LONGEST, LONGEST / longest.get(), 1.0))
        norm = _norm(c, memory, sizes, width)
        better = c.variable(0, INT)
        with c.loop(HALVINGS), c.when(better.get().equals(0)):
            with c.loop(moved) as j:
                x = before.load(REAL, j) + part.get() * step.load(REAL, j)
                w.store(x, candidates.load(INT, j))
            flag = c.call(FLAG, "px_rows", m, point, trial)
            with c.when(flag.equals(0)):
                lesser = _norm(c, trial, sizes, width)
                with c.when(lesser < norm):
                    better.set(whole(c, 1))
            part.set(part.get() * 0.5)
        ended = (longest.get() < 1e-9) & small.get().equals(1)
        with c.when(better.get().equals(0)):  # nothing is left but rounding, or no way leads on
            with c.loop(moved) as j:
                w.store(before.load(REAL, j), candidates.load(INT, j))
            with c.when(small.get().equals(0), leaves=True):
                c.give(1)
        with c.when(better.get().equals(0) | ended):
            done.set(whole(c, 1))
    with c.when(done.get().equals(0), leaves=True):
        c.give(1)
    point = Value(c, POINTER, "@pc_point")
    c.give(c.call(FLAG, "px_rows", m, point, trial))


@function("i32 px_step(ptr rows, ptr sizes, ptr step)", seldom=True)
def _step(c: Code, rows: Value, sizes: Value, step: Value) -> None:
    """The step of least norm: with rows A of one size, A*A'*l = -r and step = A'*l."""
    _, moved, width, _ = _counts(c)
    right = sizes.at(width)
    solution = right.at(width)
    scratch = solution.at(width)
    order = scratch.at(width)
    matrix = order.at(width * 3)

    def entry(i: Value, j: Value) -> Value:
        return rows.load(REAL, (j + 1) * width + i) / sizes.load(REAL, i)

    with c.loop(width) as i:
        right.store(c.constant(0.0, REAL) - rows.load(REAL, i) / sizes.load(REAL, i), i)
        with c.loop(width) as k:
            total = c.variable(0.0)
            with c.loop(moved) as j:
                total.set(total.get() + entry(i, j) * entry(k, j))
            matrix.store(total.get(), i * width + k)
        place = i * width + i
        matrix.store(matrix.load(REAL, place) * (1.0 + MORE) + 1e-300, place)
    flag = c.call(FLAG, "pc_solve", matrix, right, solution, scratch, order, width)
    with c.when(flag < 0, leaves=True):
        c.give(1)
    with c.loop(moved) as j:
        total = c.variable(0.0)
        with c.loop(width) as i:
            total.set(total.get() + entry(i, j) * solution.load(REAL, i))
        step.store(total.get(), j)
    c.give(0)
