"""Residuals and their derivatives by differences, at the start, in LLVM.

    pc_point(frame, table, row) -> flag        the numbers at the workspace's candidates
    pc_differences(frame, table, out) -> flag  that row, then a row of differences for each
                                               candidate moved; flag -1: one is not finite

The numbers are residuals of blocks below the top, residuals of the initial equations and
variables; which ones, the `table` says: int64 numbers

    mode, how many candidates, residuals, initial equations, variables;
    the slots of the candidates, the places of the residuals in `area`, the slots of the variables

One call for a whole Jacobian, since a call from Python costs more than an evaluation. The
workspace is left at the point, and evaluated.
"""

from __future__ import annotations

from planarc.codegen.native.assembly import FLAG, INT, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.ir.newton import DIFFERENCE

#: Numbers of a table before its lists.
HEAD = 5


def difference_functions() -> tuple[str, str]:
    return _point(), _differences()


def counts(table: Value) -> list[Value]:
    return [table.load(INT, i) for i in range(1, HEAD)]


@function("i32 pc_point(ptr frame, ptr table, ptr row)", seldom=True)
def _point(c: Code, frame: Value, table: Value, row: Value) -> None:
    w, _, _, area = open_frame(frame)
    moved, residuals, initial, variables = counts(table)
    places = table.at(moved + HEAD)
    slots = places.at(residuals)
    flag = c.call(FLAG, "pc_evaluate", frame, table.load(INT), row.at(residuals))
    with c.when(~flag.equals(0), leaves=True):
        c.give(flag)
    with c.loop(residuals) as i:
        row.store(area.load(REAL, places.load(INT, i)), i)
    values = row.at(residuals + initial)
    with c.loop(variables) as i:
        values.store(w.load(REAL, slots.load(INT, i)), i)
    total = c.variable(0.0)
    with c.loop(residuals + initial + variables) as i:
        total.set(total.get() + row.load(REAL, i) * 0.0)
    c.give(c.select(total.get().equals(0.0), c.constant(0, FLAG), c.constant(-1, FLAG)))


@function("i32 pc_differences(ptr frame, ptr table, ptr out)", seldom=True)
def _differences(c: Code, frame: Value, table: Value, out: Value) -> None:
    w, _, _, _ = open_frame(frame)
    moved, residuals, initial, variables = counts(table)
    width = residuals + initial + variables
    first = c.call(FLAG, "pc_point", frame, table, out)
    with c.when(~first.equals(0), leaves=True):
        c.give(first)
    with c.loop(moved) as j:
        slot, row = table.load(INT, j + HEAD), out.at((j + 1) * width)
        x = w.load(REAL, slot)
        size = c.largest(c.absolute(x), c.constant(1.0, REAL)) * DIFFERENCE
        there = c.variable(x + size)
        w.store(there.get(), slot)
        flag = c.variable(c.call(FLAG, "pc_point", frame, table, row), FLAG)
        with c.when(~flag.get().equals(0)):  # where there is no value on one side
            there.set(x - size)
            w.store(there.get(), slot)
            flag.set(c.call(FLAG, "pc_point", frame, table, row))
        w.store(x, slot)
        with c.when(~flag.get().equals(0), leaves=True):
            c.give(flag.get())
        step = there.get() - x
        with c.loop(width) as i:
            row.store((row.load(REAL, i) - out.load(REAL, i)) / step, i)
    with c.when(moved > 0):
        c.call(FLAG, "pc_point", frame, table, out)
    c.give(0)
