"""Derivatives of an exported model's values by its states, inputs and the time, exact, in LLVM.

    px_seed(block, width)                         nothing moves; states move as told
    px_move(block, place, column, by) -> flag     a state, an input or the time moves; 1: none
    px_pass(block) -> flag                        all motions, through loops by their equations
    px_moved(block, place, column) -> motion      of a value in the workspace

`place` is the address of a value in the workspace, as `px_place` gives it. The model's own are
the tape, its coefficients `pc_slopes_all`, and the node of each slot. A model with functions that
cannot be differentiated has an empty tape.

Reference: `codegen.slopes`, `codegen.native.passing`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from planarc.codegen.native.assembly import FLAG, INT, POINTER, REAL, Code, Value, function
from planarc.codegen.native.newton import open_frame
from planarc.codegen.native.passing import passing_functions
from planarc.instance.block import plan, whole
from planarc.instance.plan import INPUT, Own, Table
from planarc.ir.derivatives import CHUNK, Head, Passing
from planarc.ir.frame import Frame, Number

if TYPE_CHECKING:
    from planarc.codegen.slopes import Slopes
    from planarc.ir.program import Program

#: Instead of a node.
RESTS, UNKNOWN = -1, -2


def slope_functions() -> tuple[str, ...]:
    return (*passing_functions(), _seed(), _move(), _pass(), _moved())


def nodes_of(program: Program, slopes: Slopes | None) -> list[int]:
    """The node of each slot, and behind them that of what is no slot."""
    found = [UNKNOWN] * (program.size + 1)
    if slopes is not None:
        for slot in slopes.wanted:
            found[slot] = RESTS
        for node, slot in enumerate(slopes.slots):
            if slot >= 0:
                found[slot] = node
    return found


def has_slopes(c: Code) -> Value:
    """Whether the model can be differentiated."""
    return plan(c, Table.SLOPES) > 0


def slot_of(c: Code, m: Value, place: Value) -> Value:
    """The slot of an address in the workspace; the number of slots for any other."""
    first = c.emit(INT, f"ptrtoint ptr {m.load(POINTER, Frame.W).text} to i64")
    slot = (c.emit(INT, f"ptrtoint ptr {place.text} to i64") - first) / 8
    size = plan(c, Table.SIZE)
    inside = (slot >= 0) & (slot < size)
    return c.emit(INT, f"select i1 {inside.text}, i64 {slot.text}, i64 {size.text}")


def node_of(m: Value, slot: Value) -> Value:
    """`RESTS` where the value never moves, `UNKNOWN` where no derivative was asked for."""
    return m.load(POINTER, Own.NODES).load(INT, slot)


@function("void px_seed(ptr m, i64 width)")
def _seed(c: Code, m: Value, width: Value) -> None:
    passing = m.load(POINTER, Own.PASSING)
    tape = passing.load(POINTER, Passing.TAPE)
    chunks = (tape.load(INT, Head.LARGEST) + (CHUNK - 1)) / CHUNK
    passing.store(m, Passing.FRAME)
    passing.store(Value(c, POINTER, "@pc_slopes_all"), Passing.COEFFICIENTS)
    passing.store(width, Passing.WIDTH)
    passing.store(chunks * CHUNK, Passing.STRIDE)
    columns, motions = (passing.load(POINTER, k) for k in (Passing.COLUMNS, Passing.MOTIONS))
    nodes = tape.load(INT, Head.NODES)
    with c.loop(nodes) as i:
        columns.store(whole(c, -1), i)
    with c.loop(nodes * width) as i:
        motions.store(0.0, i)
    _, numbers, _, _ = open_frame(m)
    with c.loop(plan(c, Table.STATES)) as i:
        slot = numbers.at(Number.FIRST_STATE).load(INT, i)
        columns.store(whole(c, 0), node_of(m, slot))
    c.give()


@function("i32 px_move(ptr m, ptr place, i64 column, double by)")
def _move(c: Code, m: Value, place: Value, column: Value, by: Value) -> None:
    passing = m.load(POINTER, Own.PASSING)
    columns, motions = (passing.load(POINTER, k) for k in (Passing.COLUMNS, Passing.MOTIONS))
    slot = slot_of(c, m, place)
    node = node_of(m, slot)
    known = m.load(POINTER, Own.RULES).load(INT, slot).equals(INPUT) | slot.equals(0)
    with c.when(node < 0, leaves=True):
        c.give(c.select(known, c.constant(0, FLAG), c.constant(1, FLAG)))
    with c.when(~(known | (columns.load(INT, node) >= 0)), leaves=True):
        c.give(1)
    columns.store(column, node)
    row = motions.at(node * passing.load(INT, Passing.WIDTH))
    row.store(row.load(REAL, column) + by, column)
    c.give(0)


@function("i32 px_pass(ptr m)")
def _pass(c: Code, m: Value) -> None:
    passing = m.load(POINTER, Own.PASSING)
    c.run("pc_ranges", passing)
    c.give(c.call(FLAG, "pc_pass", passing, m.load(POINTER, Frame.W).load(REAL)))


@function("double px_moved(ptr m, ptr place, i64 column)")
def _moved(c: Code, m: Value, place: Value, column: Value) -> None:
    passing = m.load(POINTER, Own.PASSING)
    node = node_of(m, slot_of(c, m, place))
    with c.when(node < 0, leaves=True):
        c.give(c.constant(0.0, REAL))
    ranges = passing.load(POINTER, Passing.RANGES)
    outside = (column < ranges.load(INT, node * 2)) | (column >= ranges.load(INT, node * 2 + 1))
    row = passing.load(POINTER, Passing.MOTIONS).at(node * passing.load(INT, Passing.WIDTH))
    c.give(c.select(outside, c.constant(0.0, REAL), row.load(REAL, column)), REAL)
