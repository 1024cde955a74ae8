"""What a start has too much of: conditions beyond the states, and ground that carries nothing."""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.diagnostic import Diagnostic
from planarc.ir.program import CandidateSlot, FixedSlot, Program
from planarc.solve.messages import trouble
from planarc.solve.start.system import System


def spare_ground(program: Program) -> str:
    """What stands on the ground for nothing, and may be where a loop was to be closed."""
    spare = program.mechanism.spare if program.mechanism else ()
    parts = {p.name for p in program.parts if not p.inner}
    own = [n for n in spare if "." not in n and n in parts]
    return f"; nothing is connected to {trouble.names(own)}" if own else ""


def too_many_conditions(system: System, written: Sequence[str]) -> Diagnostic | None:
    """The message where initial equations, with these texts, and fixed start values are more
    than the states."""
    program = system.program
    fixed = [c for c in program.candidates if c.fixed]
    residuals = sum(len(system.block_rows[i]) for i, _ in system.blocks)
    states = len(program.candidates) - residuals
    count = len(system.initial_rows) + len(fixed) + len(system.conditions)
    if not system.initial_rows or count <= states:
        return None
    both: list[CandidateSlot | FixedSlot] = [*fixed, *system.conditions]
    held = (f"{c.display}(fixed = true)" for c in both)
    names = trouble.names(list(dict.fromkeys((*written, *held))))
    few = "no state" if not states else "1 state" if states == 1 else f"{states} states"
    number = "one" if count - states == 1 else str(count - states)
    return Diagnostic(
        "R412",
        f"the start conditions cannot all be met: there are {count} of them for {few}",
        hint=f"remove {number} of {names}",
    )
