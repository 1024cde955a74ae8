"""Where the numbers of a native kernel stand, found once for all kernels of a program."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from planarc.core.data import Data
from planarc.ir.frame import Number, Placement, Record, angles_of_loops, place
from planarc.ir.once import once
from planarc.ir.program import Program

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from planarc.core.arrays import Vector

    Indices = NDArray[np.intp]


class Table(Data):
    """What `pc_differences` reads of some derivatives, and the length of the rows that it writes.
    `numbers` live as long as their address is in use."""

    numbers: NDArray[np.int64]
    address: int
    width: int


class Layout(Data):
    """Numbers that all kernels of a program have in common; the arrays are never written."""

    place: Placement
    results: Indices  # slots that must be finite in a row
    candidates: Indices  # slots
    residuals: Indices  # places in `area` of the residuals below the top
    tear_starts: Indices  # slots of the start values of all tears
    parameters: Indices  # slots of parameters with a default
    defaults: Vector
    angles: NDArray[np.int64]  # of loops, as `Frame.ANGLES` has them
    first: tuple[int, ...]  # the candidates that are states before these are chosen
    asked: dict[Any, Table]  # what `pc_differences` reads
    selections: dict[tuple[int, ...], NDArray[np.int64]]  # numbers, from the first state on


@once
def find_layout(program: Program) -> Layout:
    placed = place(program)
    starts = {c.slot: c.start for c in program.candidates} | dict(program.guesses)
    tears = (s for r in placed.records for s in r[Record.SLOTS :][: r[Record.TEARS]])
    residuals = (
        placed.residuals(k) + i
        for k, code in enumerate(program.blocks)
        if code.height
        for i in range(len(code.residuals))
    )
    angles = angles_of_loops(program)
    given = [p for p in program.parameter_slots if p.default is not None]
    return Layout(
        placed,
        np.array(sorted({c.slot for c in program.columns if not c.constant}), np.intp),
        np.array([c.slot for c in program.candidates], np.intp),
        np.array(list(residuals), np.intp),
        np.array([starts[s] for s in tears], np.intp),
        np.array([p.slot for p in given], np.intp),
        np.array([p.default for p in given], float),
        np.array([len(angles), *(n for pair in angles for n in pair)], np.int64),
        tuple(c.first + i for c in program.blocks if c.height for i in range(c.free)),
        {},
        {},
    )


def numbers_of(
    program: Program, placed: Placement, selection: tuple[int, ...]
) -> NDArray[np.int64]:
    """Slots of the states, of their derivatives, and the unknowns of each block."""
    numbers = np.zeros(placed.numbers, np.int64)
    n, first = program.state_count, Number.FIRST_STATE
    chosen = [program.candidates[i] for i in selection]
    numbers[first : first + n] = [c.slot for c in chosen]
    numbers[first + n : first + 2 * n] = [c.derivative for c in chosen]
    taken = set(selection)
    for record, code in zip(placed.records, program.blocks, strict=True):
        if code.height and code.residuals:
            solved = [i for i in range(len(code.tears)) if code.first + i not in taken]
            at = record[Record.SOLVED]
            numbers[at : at + len(solved)] = solved
    return numbers[first:]
