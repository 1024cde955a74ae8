"""Controllers and limiters that give their limit through most of a run.

In:   Result
Out:  notes R454, or warnings where it runs away, at the user's part

What they control goes its own way then: the limit is too low, it was left at its default, or the
controller has the wrong sign. It is no limit that a part gives now and then.

Example: `LimPID pid(yMax=2)` for an arm whose weight asks for 6 N.m.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Limited, Severity
from planarc.core.prose import listed
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
#: The set and the measured value of a controller, and how many times the greatest set value the
#: measured one is that runs away.
_INPUTS, _FAR = ("u_s", "u_m"), 5.0


class _Block(Data):
    """A block with the slots of its output, which has this sign there, and of its limits."""

    name: str
    output: int
    sign: int
    limits: tuple[tuple[str, int], ...]
    controls: bool  # what it gives would change if it was not at a limit


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
        if part is None or not (np.ptp(y) or block.controls):
            continue  # a signal that is constant was hardly to be limited
        at = {name: _share(steps, y, result.constants[slot]) for name, slot in block.limits}
        if (share := sum(at.values())) > _MOST:
            name = max(at, key=lambda n: at[n])
            names = [f"`{n}`" for n in at if at[n]] if share > at[name] else [f"`{name}`"]
            told = f"`{block.name}` is at its limit {listed(names, 'or')} for {share:.0%} of"
            told += " the run"
            hint = f"look at `{name}`, at its gains, and at the sign of what it measures"
            if away := _runs_away(result, block.name):
                told += f", and what it measures runs away from its set value, to {away:.4g}"
                hint = "a sign is wrong on the way from its output to what it measures, such as "
                hint += "that of a gain, or of the ratio of a gear"
            severity = Severity.WARNING if away else Severity.NOTE
            yield Limited("R454", told, part.span, severity, hint=hint)


def _runs_away(result: Result, name: str) -> float | None:
    """What a controller measures at the end, if that is far beyond all it was to be, and farther
    than ever before."""
    import numpy as np

    if not {f"{name}.u_s", f"{name}.u_m"} <= result.columns.keys():
        return None
    wanted, measured = (np.broadcast_to(result[f"{name}.{u}"], result.time.shape) for u in _INPUTS)
    far = abs(wanted - measured)
    scale = max(np.abs(wanted).max(), far[0])
    return float(measured[-1]) if far[-1] == far.max() > _FAR * scale > 0 else None


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
            controls = classes[name] == "LimPID"
            found.append(_Block(name, *outputs[f"{name}.y"], known, controls))
    return tuple(found)
