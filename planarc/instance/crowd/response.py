"""How ports and states answer to forces, and the matrix of all contacts, in LLVM.

    px_times(rows, a, columns, values, b, columns, values, c, columns, values, sums, marks)
                                        c = a*b of sparse matrices by rows; columns rise
    px_entries(rows, a, columns, b) -> count     no more entries than c has
    px_respond(block, t, states) -> flag         what forces at the active ports do
    px_arrange(block, count)                     the contacts by ports
    px_couple(block, count) -> flag                the motion of all contacts by their impulses; 1
                                                 where there is no memory

Reference: `solve.stepping.ports`.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import INT, POINTER, REAL, Code, Value, function
from planarc.instance.block import is_null, plan, whole
from planarc.instance.crowd.layout import Area, Count, Part, arrays, part, said
from planarc.instance.plan import Own, Table
from planarc.instance.relations import attempt


def response_functions() -> tuple[str, ...]:
    return _times(), _entries(), _differ(), _respond(), _arrange(), _join()


@function(
    "void px_times(i64 rows, ptr a, ptr a_columns, ptr a_values, ptr b, ptr b_columns, "
    "ptr b_values, ptr c, ptr c_columns, ptr c_values, ptr sums, ptr marks)"
)
def _times(
    c: Code, rows: Value, a: Value, a_columns: Value, a_values: Value, b: Value,
    b_columns: Value, b_values: Value, out: Value, columns: Value, values: Value, sums: Value,
    marks: Value,
) -> None:  # fmt: skip
    """Columns are put into their places as they come up; `marks` are those of this row."""
    count = c.variable(0, INT)
    out.store(whole(c, 0))
    with c.loop(rows) as i:
        first, mark = count.get(), i + 1
        with c.loop(a.load(INT, i + 1), a.load(INT, i)) as k:
            row, factor = a_columns.load(INT, k), a_values.load(REAL, k)
            with c.loop(b.load(INT, row + 1), b.load(INT, row)) as j:
                column = b_columns.load(INT, j)
                with c.when(~marks.load(INT, column).equals(mark)):
                    marks.store(mark, column)
                    sums.store(0.0, column)
                    _insert(c, columns, first, count.get(), column)
                    count.set(count.get() + 1)
                sums.store(sums.load(REAL, column) + factor * b_values.load(REAL, j), column)
        with c.loop(count.get(), first) as k:
            values.store(sums.load(REAL, columns.load(INT, k)), k)
        out.store(count.get(), mark)
    c.give()


def _insert(c: Code, columns: Value, first: Value, end: Value, column: Value) -> None:
    """Among those from `first` on, which rise."""
    place = c.variable(end, INT)
    again, moves, looks, behind = (c.label() for _ in range(4))
    c.enter(again)
    c.branch(place.get() > first, looks, behind)
    c.begin(looks)
    c.branch(columns.load(INT, place.get() - 1) > column, moves, behind)
    c.begin(moves)
    columns.store(columns.load(INT, place.get() - 1), place.get())
    place.set(place.get() - 1)
    c.jump(again)
    c.begin(behind)
    columns.store(column, place.get())


@function("i64 px_entries(i64 rows, ptr a, ptr columns, ptr b)")
def _entries(c: Code, rows: Value, a: Value, columns: Value, b: Value) -> None:
    count = c.variable(0, INT)
    with c.loop(a.load(INT, rows)) as k:
        row = columns.load(INT, k)
        count.set(count.get() + (b.load(INT, row + 1) - b.load(INT, row)))
    c.give(count.get(), INT)


@function("void px_differ(ptr m, ptr now, ptr before, i64 rows, ptr of, ptr starts, ptr felt, "
          "ptr out, i64 colour)")  # fmt: skip
def _differ(
    c: Code, m: Value, now: Value, before: Value, rows: Value, of: Value, starts: Value,
    felt: Value, out: Value, colour: Value,
) -> None:  # fmt: skip
    """Entries of one colour: what has changed. Row i is that of number of[i]."""
    colours = part(c, Part.COLOUR)
    with c.loop(rows) as i:
        row = of.load(INT, i)
        entries = c.loop(starts.load(INT, row + 1), starts.load(INT, row))
        with entries as k, c.when(colours.load(INT, felt.load(INT, k)).equals(colour)):
            out.store(now.load(REAL, i) - before.load(REAL, i), k)
    c.give()


@function("i32 px_respond(ptr m, double t, ptr y)")
def _respond(c: Code, m: Value, t: Value, y: Value) -> None:
    """No port is pushed before or after it; the workspace is filled at this point."""
    ports, states = said(c, Count.PORTS), plan(c, Table.STATES)
    free, moved, active, forces, velocity, of_states, slopes, others, candidate, order = arrays(
        m, Area.FREE, Area.MOVED, Area.ACTIVE, Area.FORCES, Area.RESPONSE, Area.STATES,
        Area.SLOPES, Area.OTHERS, Area.CANDIDATE, Area.T_STARTS,
    )  # fmt: skip
    starts, felt = part(c, Part.FELT_STARTS), part(c, Part.FELT)
    state_starts, state_felt = part(c, Part.STATE_STARTS), part(c, Part.STATE_FELT)
    colours, accelerations = part(c, Part.COLOUR), part(c, Part.ACCELERATIONS)
    c.run("px_collect", m, accelerations, ports, free)
    c.run("px_rates", m, slopes)
    for which, entries in ((starts, velocity), (state_starts, of_states)):
        rows = ports if which is starts else plan(c, Table.MOVED)
        with c.loop(which.load(INT, rows)) as k:
            entries.store(0.0, k)
    with c.loop(ports) as i:
        order.store(i, i)
    with c.loop(said(c, Count.COLOURS)) as colour:
        some = c.variable(0, INT)
        with c.loop(ports) as i:
            here = colours.load(INT, i).equals(colour) & active.load(INT, i).equals(1)
            forces.store(c.select(here, c.constant(1.0, REAL), 0.0), i)
            some.set(c.select(here, whole(c, 1), some.get()))
        with c.when(some.get().equals(1)):
            c.run("px_push", m, forces)
            attempt(c, "px_see", m, t, y)
            c.run("px_collect", m, accelerations, ports, moved)
            c.run("px_rates", m, others)
            c.run("px_differ", m, moved, free, ports, order, starts, felt, velocity, colour)
            c.run("px_differ", m, others, slopes, states, candidate, state_starts, state_felt,
                  of_states, colour)  # fmt: skip
    with c.loop(ports) as i:
        forces.store(0.0, i)
    c.run("px_push", m, forces)
    c.give(0)


@function("void px_arrange(ptr m, i64 count)")
def _arrange(c: Code, m: Value, count: Value) -> None:
    """The transposed of the contacts' rows, in which the order of rows stays."""
    places, values, starts, to, turned = arrays(
        m, Area.J_COLUMNS, Area.J_VALUES, Area.T_STARTS, Area.T_COLUMNS, Area.T_VALUES
    )
    ports = said(c, Count.PORTS)
    with c.loop(ports + 1) as i:
        starts.store(whole(c, 0), i)
    with c.loop(count * 12) as k:
        behind = places.load(INT, k) + 1
        starts.store(starts.load(INT, behind) + 1, behind)
    with c.loop(ports) as i:
        starts.store(starts.load(INT, i + 1) + starts.load(INT, i), i + 1)
    with c.loop(count * 12) as k:
        port = places.load(INT, k)
        at = starts.load(INT, port)
        to.store(k / 6, at)
        turned.store(values.load(REAL, k), at)
        starts.store(at + 1, port)
    # Each begin has moved to where the next port's was.
    with c.loop(ports) as i:
        back = ports - i
        starts.store(starts.load(INT, back - 1), back)
    starts.store(whole(c, 0))
    c.give()


@function("i32 px_couple(ptr m, i64 count)")
def _join(c: Code, m: Value, count: Value) -> None:
    """In memory that begins at `Area.M_COLUMNS` and at `Area.A_COLUMNS`: how much is known no
    sooner."""
    ports, rows = said(c, Count.PORTS), count * 2
    j = arrays(m, Area.J_STARTS, Area.J_COLUMNS, Area.J_VALUES)
    t = arrays(m, Area.T_STARTS, Area.T_COLUMNS, Area.T_VALUES)
    starts, middle, sums, marks, velocity = arrays(
        m, Area.A_STARTS, Area.M_STARTS, Area.SUMS, Area.MARKS, Area.RESPONSE
    )
    felt_starts, felt = part(c, Part.FELT_STARTS), part(c, Part.FELT)
    with c.loop(rows + 1) as i:
        j[0].store(i * 6, i)
    c.run("px_arrange", m, count)
    most = c.call(INT, "px_entries", ports, felt_starts, felt, t[0])
    between = _room(c, m, Area.M_COLUMNS, most)
    c.run("px_times", ports, felt_starts, felt, velocity, *t, middle, *between, sums, marks)
    most = c.call(INT, "px_entries", rows, *j[:2], middle)
    of_all = _room(c, m, Area.A_COLUMNS, most)
    with c.loop(rows) as i:
        marks.store(whole(c, 0), i)
    c.run("px_times", rows, *j, middle, *between, starts, *of_all, sums, marks)
    c.give(0)


def _room(c: Code, m: Value, which: Area, count: Value) -> tuple[Value, Value]:
    """For columns and values."""
    columns = c.call(POINTER, "calloc", count * 2 + 1, whole(c, 8))
    m.load(POINTER, Own.CONTACT).store(columns, which)
    with c.when(is_null(c, columns), leaves=True):
        c.give(1)
    m.load(POINTER, Own.CONTACT).store(columns.at(count), which + 1)
    return columns, columns.at(count)
