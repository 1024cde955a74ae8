"""Derivatives that index reduction added and that nothing reads.

In:   levels, the symbols that are read elsewhere
Out:  the levels without them

Where the derivatives of a value are given (`dae.Equation.rates`), those of what the value itself
is made of are not asked for; the levels have them, as the value is needed below the top.

Example: an angle u[1] with its speed u[2] and its acceleration u[3], for `phi`

    level 2    u[1] := table    phi := u[1]
    level 1    u[2] := table    der(phi) := u[2]          (der(u[1]) is left out)
    top        u[3] := table    der(der(phi)) := u[3]     (so are der(der(u[1])) and der(u[2]))

Promises:  no equation of the user's is left out.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TypeGuard

from msgspec.structs import replace

from planarc.ir.expr import Expr, symbols
from planarc.ir.sorted import Assignment, Level, SourceEquation, Step


def without_unread(
    levels: Sequence[Level], equations: Sequence[SourceEquation], wanted: Collection[Expr]
) -> tuple[Level, ...]:
    """Leave out what only index reduction asked for, from the last step to the first."""
    read = set(wanted)
    kept: list[Level] = []
    for level in reversed(levels):
        steps = []
        for step in reversed(level.steps):
            if _is_derived(step, equations) and step.target not in read:
                continue
            steps.append(step)
            values = (*(a.value for a in step.inner), *(r.value for r in step.residuals))
            read.update(symbols(*values))
        kept.append(replace(level, steps=tuple(reversed(steps))))
    return tuple(reversed(kept))


def _is_derived(step: Step, equations: Sequence[SourceEquation]) -> TypeGuard[Assignment]:
    return isinstance(step, Assignment) and equations[step.equation].derived_from is not None
