"""What one iteration of an event compares with the one before.

In:   Program, Kernel
Out:  Snapshot    truths and discrete values
"""

from __future__ import annotations

from typing import TypeAlias

from planarc.ir.dae import Kind
from planarc.ir.kernel import Kernel, Taker, taker
from planarc.ir.once import once
from planarc.ir.program import Program

#: Iterations at one instant before it is called endless.
MOST_ITERATIONS = 100
#: Last iterations of which the changes are named then: one round may take several.
LAST_ITERATIONS = 16

#: The truths of the relations, and the discrete values, at one iteration.
Snapshot: TypeAlias = tuple[float, ...]


def most_iterations(program: Program) -> int:
    """Each discrete variable may wait for the one before it."""
    return MOST_ITERATIONS + len(program.discretes)


def snapshot(program: Program, kernel: Kernel) -> Snapshot:
    return _switching(program)(kernel.w)


def changed_numbers(program: Program, before: Snapshot, now: Snapshot) -> list[int]:
    """The slots that a pass changed, where these are real numbers and nothing else."""
    first, found = len(program.relations), []
    for i, (old, new) in enumerate(zip(before, now, strict=True)):
        if old == new:
            continue
        if i < first or program.discretes[i - first].kind is not Kind.REAL:
            return []
        found.append(program.discretes[i - first].slot)
    return found


@once
def _switching(program: Program) -> Taker:
    return taker([*(r.slot for r in program.relations), *(d.slot for d in program.discretes)])
