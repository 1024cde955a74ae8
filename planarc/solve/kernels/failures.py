"""Finds the equation that a number which is not finite came from."""

from __future__ import annotations

import math
from collections.abc import Sequence

from planarc.ir.expr import text
from planarc.ir.program import Let, Program


def first_not_finite(program: Program, w: Sequence[float]) -> int:
    """The first equation, in the order of evaluation, whose unknown is not finite, or -1."""
    for statements in (program.parameters, *program.levels, program.rest):
        for s in statements:
            lets = (s,) if isinstance(s, Let) else program.blocks[s.block].body
            for let in lets:
                slot = program.slots.get(text(let.target))
                if let.equation is not None and slot is not None and not math.isfinite(w[slot]):
                    return let.equation
    return -1
