"""The memory of a native kernel: what compiled code and its loader agree on.

A kernel's *frame* is an array of pointers that every compiled function gets:

    w         float64   the workspace (see `program`)
    numbers   int64     flags, the selected states, the unknowns of each block
    accepted  float64   values, first and second derivatives of all tears, and the time
    area      float64   residuals, Jacobian and Newton's method of each block; sizes of unknowns
    vector    pointer   SUNDIALS' N_VGetArrayPointer
    past      int64     the past of delayed signals (`history.Memory`)
    passing   pointer   what derivatives are passed on in (`Passing`), where they are
    zeros     float64   the zero functions where CVODE looked last
    shifts    float64   what CVODE's zero functions are moved by (the first `Number.SHIFTED`)
    angles    int64     how many angles of loops there are, and for each its slot and its place in
                        `accepted`: CVODE's steps move them by less than `REACH`
    nominal   float64   the size of each state, where differences find it smaller
    matrix    pointer   SUNDIALS' SUNDenseMatrix_Data

and a block's *record* is a row of int64 constants in the compiled model:

    index, tears, residuals, below, linear, accepted, solved, area, shared, total, modal
    and for each tear the slots of its value, first and second derivative (-1: none)
"""

from __future__ import annotations

from ctypes import addressof, c_char
from enum import IntEnum
from typing import Any, Final

from planarc.core.data import Data
from planarc.ir.expr import text
from planarc.ir.once import once
from planarc.ir.program import BlockCode, Program


class Frame(IntEnum):
    W = 0
    NUMBERS = 1
    ACCEPTED = 2
    AREA = 3
    VECTOR = 4
    PAST = 5
    PASSING = 6
    ZEROS = 7
    SHIFTS = 8
    ANGLES = 9
    NOMINAL = 10
    MATRIX = 11


class Number(IntEnum):
    """Places in `numbers`; behind them state slots, derivative slots, solved unknowns."""

    MODE = 0
    FAILED = 1  # index of the block that failed, or -1
    STATES = 2  # how many
    OPEN = 3  # index of a modal block that left unknowns open, or -1
    SHIFTED = 4  # how many zero functions may be moved
    CONTENT = 5  # 1 where blocks of the top may keep values at which their slopes are singular
    NEAR = 6  # 1 where a loop came near to a pose in which it can go on in several ways
    FIRST_STATE = 7


class Mode(IntEnum):
    """The purpose of a run through `levels`. In all but SOLVE the candidates are given, and
    blocks below the top only tell their residuals and Jacobians."""

    SOLVE = 0
    GIVEN = 1
    MATRICES = 2  # blocks of the top tell their Jacobians too, even where none is needed
    BELOW = 3  # stop before the top level


class Record(IntEnum):
    INDEX = 0
    TEARS = 1
    RESIDUALS = 2
    BELOW = 3
    LINEAR = 4
    ACCEPTED = 5  # where its tears begin in each third of `accepted`
    SOLVED = 6  # where the positions of its unknowns begin in `numbers`
    AREA = 7  # where its part of `area` begins
    SHARED = 8  # where the matrix for elimination begins in `area`
    TOTAL = 9  # tears of all blocks together
    MODAL = 10
    SLOTS = 11


#: A block's part of `area`: four numbers of Newton's method, then arrays.
COUNT, FACTOR, NORM, TINY, ARRAYS = 0, 1, 2, 3, 4


class Placement(Data):
    """Sizes of a program's arrays and where each block's part begins."""

    records: tuple[tuple[int, ...], ...]
    numbers: int
    accepted: int
    area: int
    sizes: int  # where those of unknowns begin in `area`, one a slot

    def residuals(self, block: int) -> int:
        """The place in `area` at which the residuals of a block begin."""
        return self.records[block][Record.AREA] + ARRAYS

    def jacobian(self, block: int) -> int:
        """The place at which its matrix begins (row by row, a column for each tear)."""
        return self.residuals(block) + self.records[block][Record.RESIDUALS]


#: Numbers of arrays behind residuals and matrix: steps, sizes of rows, the order of elimination and
#: two more for it (one a residual), values before the step and at the start (one a tear).
ROW_ARRAYS: Final = 5
TEAR_ARRAYS: Final = 2


def address(array: Any) -> int:
    """The address of an array's first number, 0 where it has none: `array.ctypes.data`, in a
    quarter of its time."""
    return addressof(c_char.from_buffer(array)) if array.size else 0


def place(program: Program) -> Placement:
    """The placement of a program: the same for whoever asks."""
    blocks = program.blocks
    matrices = ((len(b.residuals), len(b.tears)) for b in blocks)
    largest = max((m * max(m + 1, n) for m, n in matrices), default=0)
    total = sum(len(b.tears) for b in blocks)
    derivative = {c.slot: c.derivative for c in program.candidates}
    shared = 0
    area = largest
    solved = Number.FIRST_STATE + 2 * program.state_count
    accepted = 0
    records = []
    for index, b in enumerate(blocks):
        head = (index, len(b.tears), len(b.residuals), int(b.height > 0), int(b.linear))
        slots = _slots(program, b, derivative)
        modal = int(b.modal)
        records.append((*head, accepted, solved, area, shared, total, modal, *slots))
        accepted += len(b.tears)
        solved += len(b.residuals)
        area += ARRAYS + len(b.residuals) * (1 + len(b.tears) + ROW_ARRAYS)
        area += TEAR_ARRAYS * len(b.tears)
    sizes = program.size if any(b.direct is not None for b in blocks) else 0
    return Placement(tuple(records), solved, 3 * total + 1, area + sizes, area)


@once
def angles_of_loops(program: Program) -> tuple[tuple[int, int], ...]:
    """The angles among the unknowns that close loops, by their slots and places in `accepted`."""
    angles = {c.slot for c in program.columns if c.unit == "rad"}
    found = []
    for code, record in zip(program.blocks, place(program).records, strict=True):
        if code.height and code.residuals and not code.linear:
            slots = record[Record.SLOTS :][: len(code.tears)]
            found += [(s, record[Record.ACCEPTED] + i) for i, s in enumerate(slots) if s in angles]
    return tuple(found)


def _slots(program: Program, block: BlockCode, derivative: dict[int, int]) -> list[int]:
    values = [program.slots[text(tear)] for tear in block.tears]
    first = [derivative.get(s, -1) if block.height else -1 for s in values]
    return [*values, *first, *(derivative.get(s, -1) for s in first)]
