"""A model checked without a run: all stages up to `structure`, and what its mechanism can do.

In:   Request
Out:  Checked, or what an earlier check remembered of it

Where there are loops, their conditions may depend on each other: the mechanism is put together at
its start, on NumPy's back end, which is there at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.clock import Clock
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend
from planarc.probe.mobility import mobility_at_start
from planarc.remembered import Checked, recall_check, remember_check
from planarc.request.request import Request, open_target
from planarc.stages import (
    attachment_warnings,
    find_mechanism,
    flatten,
    to_code,
    to_dae,
    to_program,
    to_sorted,
    without_collection,
)

if TYPE_CHECKING:
    from planarc.ir.mechanism import Mechanism, Mobility
    from planarc.ir.sorted import SortedDae


def check_model(request: Request, clock: Clock | None = None, start: bool = False) -> Checked:
    """All stages up to `structure`. A start that cannot be found is an error only with `start`."""
    clock = clock or Clock()
    with clock.phase("recall"):
        known = recall_check(request)
    if known is not None and not (start and known.mechanism and known.mobility is None):
        return known
    with without_collection():
        target = open_target(request)
        flat = flatten(target, clock)
        dae = to_dae(flat, clock)
        model = to_sorted(dae, clock)
        sizes = model.equations_before, model.equations_after, model.state_count
        mechanism = find_mechanism(dae)
        warnings = (*flat.warnings, *attachment_warnings(dae, mechanism))
        checked = Checked(flat.name, *sizes, warnings, mechanism)
        if mechanism is not None and (start or mechanism.loops > 0):
            found = None
            try:
                found = _find_mobility(model, mechanism, clock)
            except PlanarcError:
                if start:
                    raise
            # What cannot be assembled cannot move either.
            if mechanism.locked is not None and (found is None or found.rank <= 0):
                warnings = (*warnings, mechanism.locked)
            checked = replace(checked, mobility=found, warnings=warnings)
    remember_check(request, target, checked)
    return checked


def _find_mobility(model: SortedDae, mechanism: Mechanism, clock: Clock) -> Mobility | None:
    program = replace(to_program(model, clock), mechanism=mechanism)
    code = to_code(program, Backend.NUMPY, clock)
    with clock.phase("start"):
        return mobility_at_start(program, str(code))
