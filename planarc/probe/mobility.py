"""What a mechanism can do at its start: mobility by the rank of the conditions.

In:   Program, code of one back end
Out:  Mobility

The mechanism is put together as a run does it. There the rank of the loops' conditions tells how
many of them are independent; each that is not gives back a degree of freedom that the count takes.

Example: a parallelogram with a third bar parallel to the others. By count 4*3 - 6*2 = 0; the rank
of its four conditions is three, so that it moves with one degree of freedom.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, Severity
from planarc.core.options import RunOptions
from planarc.ir.mechanism import Mobility

if TYPE_CHECKING:
    from planarc.compiled import Compiled

#: The message that names redundant joints.
_REDUNDANT = "R415"


def mobility_at_start(compiled: Compiled) -> Mobility | None:
    """None of a model without a mechanism. Raises PlanarcError where it cannot be assembled."""
    from planarc.insight.rank import deficiency
    from planarc.solve.events.iteration import Events
    from planarc.solve.kernels.numpy.support import without_lapack
    from planarc.solve.settings import resolve
    from planarc.solve.simulate import set_workspace
    from planarc.solve.start.solve import solve_start

    program = compiled.program
    if program.mechanism is None:
        return None
    kernel = compiled.load()
    request = resolve(program, RunOptions(backend=compiled.backend))
    set_workspace(program, kernel, request)
    Events(program, kernel, request.span).begin(request.start)
    redundant = None
    with without_lapack():
        try:
            solve_start(program, kernel, request.start)
        except PlanarcError as problem:
            first = problem.diagnostics[0]
            if first.code != _REDUNDANT:
                raise
            redundant = replace(first, severity=Severity.WARNING)
        dependent = deficiency(program, kernel)
    return Mobility(program.mechanism.mobility, dependent, redundant)
