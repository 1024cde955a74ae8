"""Mechanisms that stand still from the first row of a run to its last.

In:   Result
Out:  note R451, at the first of the user's joints or bodies that could move

What acts may be in balance, as it is meant to be; or a drive, a force, a start speed or the lever
of the weight was forgotten.

Example: a body directly on a hinge, whose weight has no lever about it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity, Still
from planarc.core.prose import shortened
from planarc.ir.once import once
from planarc.ir.places import own_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

_SPEEDS = ("m/s", "rad/s")
#: What rounding leaves of a speed that is zero, in m/s or rad/s.
_ROUNDING = 1e-9
_SHOWN = 3


def judge_still(result: Result) -> Iterator[Diagnostic]:
    """The note about a run in which nothing moves."""
    import numpy as np

    if len(result.time) < 3 or result.events or result.ended is not None:
        return
    program = result.program
    told = program.locked is not None or any(w.code == "S322" for w in result.warnings)
    if told or not any(s.states for s in result.states):
        return  # it cannot move
    slots, free = _speeds(program)
    half = len(result.time) // 2  # where most that moves does: a column takes longer to read
    for slot in slots:
        if slot in result.stored and abs(result.data[half, result.stored[slot]]) > _ROUNDING:
            return
    for slot in slots:
        if np.any(np.abs(result.of_slot(slot)) > _ROUNDING):
            return
    parts = {p.name: p for name in free if (p := own_part(program, name)) is not None}
    if not parts:
        return
    first = next(iter(parts.values()))
    named = shortened([f"`{name}`" for name in parts], _SHOWN)
    yield Still(
        "R451",
        f"nothing moves from t = {result.time[0]:.4g} to {result.time[-1]:.4g} s: {named} "
        "stand" + ("s" if len(parts) == 1 else "") + " still",
        first.span,
        Severity.NOTE,
        hint="what acts is in balance, or nothing acts: give a start speed, a drive or a force; "
        "a weight turns a hinge only if the centre of mass is off its axis, as behind a rod",
    )


@once
def _speeds(program: Program) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The slots of all speeds, those that may be states first; and whose speeds the latter are."""
    candidates = {c.slot for c in program.candidates}
    speeds = [c for c in program.columns if c.unit in _SPEEDS]
    free = [c for c in speeds if c.slot in candidates]
    slots = dict.fromkeys(c.slot for c in (*free, *speeds))
    return tuple(slots), tuple(c.name.rpartition(".")[0] for c in free)
