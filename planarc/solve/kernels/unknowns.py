"""The unknowns of all blocks, for integrators that solve them together with the step."""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.expr import text
from planarc.ir.kernel import Unknowns
from planarc.ir.program import Program, Solve


def find_unknowns(program: Program, selection: Sequence[int]) -> Unknowns:
    """Of the blocks that the right-hand side solves, for a choice of states."""
    states = set(selection)
    found = Unknowns([], [], [], [])
    solved = {s.block for level in program.levels for s in level if isinstance(s, Solve)}
    for i in sorted(solved):
        code = program.blocks[i]
        if not code.residuals:
            continue
        found.residuals.append((i, len(code.residuals)))
        for j, tear in enumerate(code.tears):
            if not code.height:
                found.slots.append(program.slots[text(tear)])
                found.rates.append(-1)
                found.nominals.append(-1)
            elif code.first + j not in states:
                c = program.candidates[code.first + j]
                found.slots.append(c.slot)
                found.rates.append(c.derivative)
                found.nominals.append(-1 if c.nominal is None else c.nominal)
    return found
