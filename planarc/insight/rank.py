"""The rank of the conditions that close the loops, and the distance of a run from losing it.

In:   Program, Kernel    positions of joints in, the Jacobian of each loop's conditions out
Out:  Closeness          singular values over the rows; `deficiency` for one position

With J the Jacobian of a block's conditions (rows) by its joint coordinates (columns), two
numbers tell how well a position is determined, both relative to the largest singular value of J:

    loops    the smallest singular value of J; zero where conditions become dependent, as when a
             parallelogram lies flat
    held     the same of J without the columns of the states; zero at a dead point, where the
             other coordinates do not follow from the states

Example: a crank-slider driven at its slider has a dead point where crank and rod are in line.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from planarc.core.arrays import Vector, spread
from planarc.core.data import Data
from planarc.ir.kernel import Kernel
from planarc.ir.program import Program
from planarc.ir.result import Result

#: The share of the largest singular value below which others count as zero.
RANK = 1e-8
#: The most rows that are computed; values between them are on straight lines.
ROWS = 1000


class Closeness(Data):
    """Closeness to singularity over the rows. `states` are the coordinates that `held` holds."""

    loops: Vector
    held: Vector
    states: tuple[str, ...]


def find_closeness(result: Result, kernel: Kernel) -> Closeness | None:
    """The closeness of a run; None where no loop is closed. Changes the kernel's workspace."""
    program = result.program
    blocks = [(i, b) for i, b in enumerate(program.blocks) if b.height > 1 and b.residuals]
    if not blocks or not len(result.time):
        return None
    rows = spread(len(result.time), ROWS)
    for parameter in program.parameter_slots:
        if parameter.slot in result.constants:
            kernel.w[parameter.slot] = result.constants[parameter.slot]
    kernel.parameters()
    table = _candidates(result, rows)
    first = set(result.states[0].states) if result.states else set()
    states: list[str] = []
    smallest = np.full((2, len(rows)), np.inf)
    matrices: dict[int, list[Any]] = {i: [] for i, _ in blocks}
    slots = [0, *(c.slot for c in program.candidates)]
    for time, values in zip(result.time[rows].tolist(), table.tolist(), strict=True):
        for slot, value in zip(slots, (time, *values), strict=True):
            kernel.w[slot] = value
        for i, _ in blocks:
            matrices[i].append(kernel.jacobian(i))
    for i, block in blocks:
        stack = np.array(matrices[i], dtype=float)
        names = [program.candidates[block.first + j].display for j in range(len(block.tears))]
        free = [j for j, name in enumerate(names) if name not in first]
        states += [name for name in names if name in first]
        for k, part in enumerate((stack, stack[:, :, free])):
            smallest[k] = np.minimum(smallest[k], _relative(part, stack))
    loops, held = (np.interp(result.time, result.time[rows], s) for s in smallest)
    return Closeness(loops, held, tuple(states))


def deficiency(program: Program, kernel: Kernel) -> int:
    """The number of conditions that follow from the others at the kernel's present values."""
    missing = 0
    for i, block in enumerate(program.blocks):
        if block.height > 1 and block.residuals:
            sizes = np.linalg.svd(np.array(kernel.jacobian(i), dtype=float), compute_uv=False)
            missing += len(block.residuals) - int(np.sum(sizes > RANK * max(1.0, sizes[0])))
    return missing


def _relative(part: Any, whole: Any) -> Vector:
    """The smallest singular value of each matrix over the largest of the whole one."""
    found = np.full(len(whole), np.nan)
    finite = np.isfinite(whole).all(axis=(1, 2))
    if part.shape[2] < part.shape[1]:
        found[finite] = 0.0
    elif finite.any():
        least = np.linalg.svd(part[finite], compute_uv=False)[:, -1]
        most = np.linalg.svd(whole[finite], compute_uv=False)[:, 0]
        found[finite] = least / np.maximum(most, 1e-300)
    return found


def _candidates(result: Result, rows: Any) -> Any:
    """The values of all candidates for states in these rows."""
    table = np.empty((len(rows), len(result.program.candidates)))
    for j, candidate in enumerate(result.program.candidates):
        if candidate.slot in result.stored:
            table[:, j] = result.data[rows, result.stored[candidate.slot]]
        else:
            table[:, j] = result.constants[candidate.slot]
    return table
