"""What is wished of an export, and what follows from it for any of them.

Raises:    UsageError V505 for parameters that there are not.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.instance.plan import is_settable
from planarc.ir.derivatives import Scope
from planarc.view.storage import no_match

if TYPE_CHECKING:
    from planarc.codegen.slopes import Slopes
    from planarc.ir.program import Program

#: Co-simulation has errors of this part of the experiment's tolerance, or less.
_FINER, _FINEST = 0.01, 1e-10


class Wishes(Data):
    """`version` of the standard is 2 or 3; `outputs` matches names of variables that become
    outputs; None: the model's own, or, where it has none, all coordinates. `parameters` matches
    those that a host may set. Without `platforms` all that the version knows. With `stiff`
    co-simulation takes implicit steps; with `source` there are sources, too."""

    version: int = 3
    outputs: re.Pattern[str] | None = None
    parameters: re.Pattern[str] | None = None
    platforms: tuple[str, ...] | None = None
    stiff: bool = False
    source: bool = False


def restricted(program: Program, parameters: re.Pattern[str] | None) -> Program:
    """The program with only those parameters left to set that a pattern matches."""
    if parameters is None:
        return program
    slots = tuple(
        p if parameters.search(p.name) else replace(p, settable=False)
        for p in program.parameter_slots
    )
    if not any(map(is_settable, slots)):
        names = [p.name for p in program.parameter_slots if is_settable(p)]
        raise no_match("parameter that an FMU can set", parameters, names)
    return replace(program, parameter_slots=slots)


def derivatives(program: Program, wanted: Collection[int]) -> Slopes | None:
    """The derivatives of these slots and of the states' derivatives, by states, inputs and time;
    not by time where it is an argument of a function without derivatives."""
    from planarc.codegen.slopes import derive_slopes

    bare = replace(program, parameter_slots=())
    found = derive_slopes(bare, Scope.ALL, wanted, timed=True)
    return derive_slopes(bare, Scope.ALL, wanted) if found is None else found


def tolerance_of(program: Program) -> float:
    """The tolerance of an exported model's own integrator."""
    return finer(program.experiment.tolerance)


def finer(tolerance: float) -> float:
    """The same where results shall have this one."""
    return min(_FINER * tolerance, _FINEST)
