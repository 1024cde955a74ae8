"""Redundant joints of an exported model: what was left out, since it follows from the rest, holds.

Which forces are open, and that the motion does not depend on them, was found out at export.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic
from planarc.ir.program import Program
from planarc.solve.start.sharing import does_not_hold


def misfit_slots(program: Program) -> Iterator[int]:
    """Where the workspace tells by how much each condition is missed."""
    slots = {c.name: c.slot for c in program.columns}
    for condition in program.sharing.conditions if program.sharing is not None else ():
        yield slots[condition.name]


def misfits(program: Program, number: str = "...") -> list[Diagnostic]:
    """The ends of a run that misses them, at time 0, in their order; `number` tells by how much."""
    conditions = program.sharing.conditions if program.sharing is not None else ()
    return [does_not_hold(program, c, 0.0, number) for c in conditions]
