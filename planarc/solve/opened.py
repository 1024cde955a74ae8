"""A program put together: all that a run has in its workspace before anything is solved.

In:   Program, Kernel, RunOptions
Out:  Request, and in the kernel's workspace parameters, start values and discrete values

Runs begin so, and so does whoever asks what a mechanism can do at its start.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from planarc.core.diagnostic import error
from planarc.core.options import RunOptions
from planarc.core.source import NOWHERE, Span
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.places import declaration
from planarc.ir.program import Program
from planarc.runtime import external
from planarc.solve.events.iteration import Events
from planarc.solve.rescue.rescue import Rescue
from planarc.solve.settings import Request, resolve

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.core.arrays import Vector


def open_program(program: Program, kernel: Kernel, options: RunOptions) -> Request:
    """Fill the workspace. Raises UsageError for a wrong request, PlanarcError R414 for parameters
    without value."""
    request = resolve(program, options)
    set_workspace(program, kernel, request)
    Events(program, kernel, request, Rescue(program, kernel)).begin(request.start)
    return request


def set_workspace(program: Program, kernel: Kernel, request: Request) -> None:
    """Parameters, what depends on them, start values, and inputs."""
    external.begin_run()
    w = kernel.w
    if isinstance(w, list):
        for slot, value in zip(*_defaults(program), strict=True):
            w[slot] = value
    else:
        slots, defaults = _default_arrays(program)
        w[slots] = defaults  # type: ignore[call-overload]
    for slot, value in request.values.items():
        w[slot] = value
    flag = kernel.parameters()
    bad = _not_finite(program, kernel)
    if flag != 0 or bad:
        spans = {f"parameter `{p.name}`": (p.name, p.span) for p in program.parameter_slots}
        name, span = spans.get(bad, (bad.strip("`"), NOWHERE))
        if span is NOWHERE:
            span = _place(program, kernel, name)
        raise error(
            "R414",
            f"{bad} has no finite value" if bad else "the parameters have no value",
            declaration(program, name, span),
            hint="check the parameters and constants it is computed from",
        )
    for slot, value in request.starts.items():
        w[slot] = value
    for name in program.inputs:  # what nobody drives keeps its start value
        w[program.slots[name]] = w[program.slots[f"start({name})"]]


def _place(program: Program, kernel: Kernel, name: str) -> Span:
    """The place of the equation that gives a variable its value."""
    from planarc.solve.messages.trouble import determining

    slot = next((c.slot for c in program.columns if c.name == name), None)
    giver = None if slot is None else determining(program, kernel, slot)
    return NOWHERE if giver is None else giver.span


def _not_finite(program: Program, kernel: Kernel) -> str:
    """The first parameter, constant or variable that never changes without a finite value,
    or nothing."""
    # Their slots stand before those of the candidates. Of a list, a length tells of all at once.
    end = program.candidates[0].slot if program.candidates else len(kernel.w)
    values: Any = kernel.w[:end]
    if isinstance(values, list):
        finite = math.isfinite(math.hypot(*values))
    else:
        import numpy as np

        finite = np.count_nonzero(np.isfinite(values)) == len(values)
    if finite:
        return ""
    for p in program.parameter_slots:
        if not math.isfinite(kernel.w[p.slot]):
            return f"parameter `{p.name}`"
    for c in program.columns:
        if c.constant and not math.isfinite(kernel.w[c.slot]):
            return f"`{c.name}`"
    return ""


@once
def _defaults(program: Program) -> tuple[list[int], list[float]]:
    """The slots of parameters with a value of their own, and these."""
    found = [(p.slot, p.default) for p in program.parameter_slots if p.default is not None]
    return [slot for slot, _ in found], [value for _, value in found]


@once
def _default_arrays(program: Program) -> tuple[NDArray[np.intp], Vector]:
    """The same for NumPy."""
    import numpy as np

    slots, defaults = _defaults(program)
    return np.array(slots, np.intp), np.array(defaults, float)
