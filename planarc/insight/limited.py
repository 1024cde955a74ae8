"""Controllers and limiters that give their limit through most of a run.

In:   Result
Out:  notes R454, at the user's part

What they control goes its own way then: the limit is too low, it was left at its default, or the
controller has the wrong sign. It is no limit that a part gives now and then.

Example: `LimPID pid(yMax=2)` for an arm whose weight asks for 6 N.m.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.ir.once import once
from planarc.ir.places import declared_part
from planarc.ir.program import Program

if TYPE_CHECKING:
    from planarc.core.arrays import Vector
    from planarc.ir.result import Result

#: Classes with a limit, and how their upper and their lower one are called.
_LIMITED = {"LimPID": ("yMax", "yMin"), "Limiter": ("uMax", "uMin")}
#: The share of a run's time that is most of it, and what is as good as a limit.
_MOST, _NEAR = 0.75, 1e-6


class _Block(Data):
    """A block with the slots of its output, which has this sign there, and of its limits."""

    name: str
    output: int
    sign: int
    limits: tuple[tuple[str, int], ...]


def judge_limited(result: Result) -> Iterator[Diagnostic]:
    """The notes about blocks that are at a limit nearly all the while."""
    import numpy as np

    blocks = limited_blocks(result.program)
    if not blocks or result.ended is not None:
        return
    steps = np.diff(result.time)
    if len(steps) < 2 or not steps.any():
        return
    for block in blocks:
        part = declared_part(result.program, block.name)
        y = block.sign * np.broadcast_to(result.of_slot(block.output), result.time.shape)
        if part is None or not np.ptp(y):  # a signal that is constant was hardly to be limited
            continue
        at = {name: _share(steps, y, result.constants[slot]) for name, slot in block.limits}
        if (share := sum(at.values())) > _MOST:
            name = max(at, key=lambda n: at[n])
            other = "" if share == at[name] else " or the other one"
            yield Diagnostic(
                "R454",
                f"`{block.name}` is at its limit `{name}`{other} for {share:.0%} of the run",
                part.span,
                Severity.NOTE,
                hint=f"look at `{name}`, at its gains, and at the sign of what it measures",
            )


def _share(steps: Vector, y: Vector, limit: float) -> float:
    """The part of the time at whose both ends a signal is at its limit."""
    there = abs(y - limit) <= _NEAR * abs(limit)
    return float(steps[there[1:] & there[:-1]].sum() / steps.sum())


@once
def limited_blocks(program: Program) -> tuple[_Block, ...]:
    classes = {p.name: p.class_name.rpartition(".")[2] for p in program.parts}
    limited = {name: _LIMITED[kind] for name, kind in classes.items() if kind in _LIMITED}
    if not limited:
        return ()
    outputs = {c.name: (c.slot, c.sign) for c in program.columns}
    slots = {p.name: p.slot for p in program.parameter_slots}
    found = []
    for name, limits in limited.items():
        known = tuple((n, slots[f"{name}.{n}"]) for n in limits if f"{name}.{n}" in slots)
        if declared_part(program, name) and f"{name}.y" in outputs and known:
            found.append(_Block(name, *outputs[f"{name}.y"], known))
    return tuple(found)
