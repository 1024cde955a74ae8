"""How much drives and joints carry: the largest value over a run, when, and the mean square.

In:   Result, Mechanism, Drives
Out:  Peak   a quantity with its largest absolute value, the time of it, and its RMS

Of a joint the force between its two sides, and the torque where it holds one; of a drive its
efforts and its power. What is nothing but round-off is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from planarc.core.arrays import Vector
from planarc.evaluate.record import whole
from planarc.insight.drives import Drive
from planarc.insight.values import Values, integral
from planarc.ir.insight import Peak
from planarc.ir.mechanism import Mechanism
from planarc.ir.result import Result

#: The share of the largest value of a unit below which others are round-off.
_NOTHING = 1e-9


def find_peaks(
    result: Result,
    mechanism: Mechanism | None,
    drives: Sequence[Drive],
    values: Values | None = None,
) -> tuple[Peak, ...]:
    """The peaks of all drives and joints, drives first."""
    if len(result.time) < 2:
        return ()
    held = _held(values or Values(result), mechanism)
    found = [_peak(result.time, *own) for own in (*_driving(result, drives), *held)]
    largest: dict[str, float] = {}
    for p in found:
        largest[p.unit] = max(p.largest, largest.get(p.unit, 0.0))
    return tuple(p for p in found if p.largest > _NOTHING * largest[p.unit])


def _driving(result: Result, drives: Sequence[Drive]) -> Iterator[tuple[str, str, Vector]]:
    columns = result.columns
    for drive in drives:
        for name in drive.efforts:
            yield name, columns[name].unit, result[name]
        yield f"{drive.name} power", "W", drive.power


def _held(values: Values, mechanism: Mechanism | None) -> Iterator[tuple[str, str, Vector]]:
    for joint in () if mechanism is None else mechanism.joints:
        frame = next((f for f in joint.frames if values.has(f, "f[1]", "f[2]", "t")), None)
        if frame is not None:
            x, y = values.pair(frame, "f")
            yield f"{joint.name} force", "N", values.full(1.0) * np.hypot(x, y)
            yield f"{joint.name} torque", "N.m", values.full(1.0) * values.get(f"{frame}.t")


def _peak(time: Vector, name: str, unit: str, values: Vector) -> Peak:
    rows = finite(values)
    return Peak(name, unit, peak(time, rows), instant(time, rows), rms(time, rows))


@whole("finite")
def finite(values: Vector) -> Vector:
    """The values, 0 where there is none."""
    return np.nan_to_num(values, posinf=0.0, neginf=0.0)


@whole("peak")
def peak(time: Vector, values: Vector) -> float:
    """The value that is largest without its sign."""
    return float(values[np.argmax(np.abs(values))])


@whole("instant")
def instant(time: Vector, values: Vector) -> float:
    """The time of it."""
    return float(time[np.argmax(np.abs(values))])


@whole("rms")
def rms(time: Vector, values: Vector) -> float:
    """The root of the mean square over the time."""
    span = float(time[-1] - time[0])
    mean = float(integral(time, values**2)[-1]) / span if span > 0 else float(values[0] ** 2)
    root: float = max(mean, 0.0) ** 0.5
    return root
