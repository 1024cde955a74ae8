"""Mechanisms that stand still from the first row of a run to its last.

In:   Result
Out:  note R451, at the first of the user's joints or bodies that could move

What acts may be in balance, as it is meant to be; or a drive, a force, a start speed or the lever
of the weight was forgotten.

A slide whose axis is left at its default, across which the weight acts, is told also where others
move.

Examples: a body directly on a hinge, whose weight has no lever about it; a lift whose slide lacks
`n={0, 1}`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, Severity, Still
from planarc.core.prose import shortened
from planarc.ir.flat import Part
from planarc.ir.mechanism import GROUND
from planarc.ir.once import once
from planarc.ir.places import declared_part, own_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.ir.result import Result

_SPEEDS = ("m/s", "rad/s")
#: What rounding leaves of a speed that is zero, in m/s or rad/s.
_ROUNDING = 1e-9
_SHOWN = 3
#: An axis that is written.
_AXIS = r"\bn\s*="


def judge_still(result: Result) -> Iterator[Diagnostic]:
    """The note about a run in which nothing moves, or a slide does not that is left level."""
    if len(result.time) < 3 or result.events or result.ended is not None:
        return
    program = result.program
    told = program.locked is not None or any(w.code == "S322" for w in result.warnings)
    if told or not any(s.states for s in result.states):
        return  # it cannot move
    slots, free = _speeds(program)
    level = _level_slides(program)
    if _is_moving(result, slots):
        yield from _left_level(result, level)
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
        hint=_upright(first)
        if first.name in level
        else "what acts is in balance, or nothing acts: give a start speed, a drive or a force; "
        "a weight turns a hinge only if the centre of mass is off its axis, as behind a rod",
    )


def _is_moving(result: Result, slots: Sequence[int]) -> bool:
    import numpy as np

    half = len(result.time) // 2  # where most that moves does: a column takes longer to read
    quick = (result.data[half, result.stored[s]] for s in slots if s in result.stored)
    if any(abs(speed) > _ROUNDING for speed in quick):
        return True
    return any(bool(np.any(np.abs(result.of_slot(slot)) > _ROUNDING)) for slot in slots)


def _left_level(result: Result, level: Mapping[str, int]) -> Iterator[Diagnostic]:
    """The notes about level slides that stand still while others move."""
    import numpy as np

    for name, slot in level.items():
        part = own_part(result.program, name)
        if part is not None and np.all(np.abs(result.of_slot(slot)) <= _ROUNDING):
            yield Still(
                "R451",
                f"`{name}` stands still while others move",
                part.span,
                Severity.NOTE,
                hint=_upright(part),
            )


def _upright(slide: Part) -> str:
    return (
        f"its axis is left at n={{1, 0}}, and the weight acts across it: write "
        f"`{slide.name}(n={{0, 1}})`, if it is to rise and fall"
    )


@once
def _level_slides(program: Program) -> dict[str, int]:
    """The user's slides from the ground along x, as nothing else is written, with the slots of
    their speeds; none where gravity does not point down."""
    mechanism = program.mechanism
    values = {p.name: p.default for p in program.parameter_slots}
    worlds = [p.name for p in program.parts if p.inner and p.class_name.endswith(".World")]
    if mechanism is None or not worlds or not values.get(f"{worlds[0]}.g"):
        return {}
    if values.get(f"{worlds[0]}.n[1]") or f"{worlds[0]}.n[1]" not in values:
        return {}
    speeds = {c.name: c.slot for c in program.columns if c.name.endswith(".v")}
    candidates = {c.slot for c in program.candidates}
    found = {}
    for joint in (j.name for j in mechanism.joints if GROUND in j.links):
        part, slot = declared_part(program, joint), speeds.get(f"{joint}.v", -1)
        level = (values.get(f"{joint}.n[1]"), values.get(f"{joint}.n[2]")) == (1.0, 0.0)
        written = part is None or re.search(_AXIS, part.span.text)
        if level and slot in candidates and not written:
            found[joint] = slot
    return found


@once
def _speeds(program: Program) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The slots of all speeds, those that may be states first; and whose speeds the latter are."""
    candidates = {c.slot for c in program.candidates}
    speeds = [c for c in program.columns if c.unit in _SPEEDS]
    free = [c for c in speeds if c.slot in candidates]
    slots = dict.fromkeys(c.slot for c in (*free, *speeds))
    return tuple(slots), tuple(c.name.rpartition(".")[0] for c in free)
