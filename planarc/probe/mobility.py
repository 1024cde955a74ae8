"""What a mechanism can do at its start: mobility by the rank of the conditions.

In:   Program
Out:  Mobility

The mechanism is put together as a run does it. There the rank of the loops' conditions tells how
many of them are independent; each that is not gives back a degree of freedom that the count takes.

Example: a parallelogram with a third bar parallel to the others. By count 4*3 - 6*2 = 0; the rank
of its four conditions is three, so that it moves with one degree of freedom.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.diagnostic import Severity
from planarc.ir.mechanism import Mobility
from planarc.probe.open import open_program

if TYPE_CHECKING:
    from planarc.ir.program import Program


def mobility_at_start(program: Program, text: str | None = None) -> Mobility | None:
    """None of a model without a mechanism; `text` is that of the program for NumPy, where it is
    known. Raises PlanarcError where the mechanism cannot be assembled."""
    from planarc.insight.rank import deficiency
    from planarc.solve.start.redundancy import Redundant

    if program.mechanism is None:
        return None
    opened, redundant = open_program(program, text), None
    try:
        opened.start()
    except Redundant as problem:
        redundant = replace(problem.diagnostics[0], severity=Severity.WARNING)
    return Mobility(program.mechanism.mobility, deficiency(program, opened.kernel), redundant)
