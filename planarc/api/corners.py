"""The corners of a table that a run must not step over.

In:   ascending times, two equal ones at a jump; values
Out:  the times at which the integrator is to stop

An integrator sees a signal where its steps end, and takes a pulse between these for nothing. The
*height* of a point is its distance from the line through two points as far from it on
either side, along the table; the points from which that is large mark what happens, as the foot,
the tip and the end of a pulse do. Of a table of few points all are stopped at. Of many measured
ones that is too much: for one of 10,000 points along a sine a run would take 25 times as long. What
is smooth has small heights near by, and large ones only where points lie as far apart as an
integrator's steps, so that stops follow the curve and not the measurement:

    distance 1     0  0  0  9  0  0  0  0  0      a pulse shows among its nearest neighbours,
    distance 4     0           .           0      a curve, at a greater distance
"""

from __future__ import annotations

import numpy as np

from planarc.core.arrays import Vector

#: Heights from this part of the range on are stopped at, and so many of the greatest in any case.
HIGH, FEW = 1e-2, 50
#: Parts of the range, and of the largest value, that are rounding.
ROUNDING, DIGITS = 1e-9, 1e-14


def corners(times: Vector, values: Vector) -> Vector:
    """The times at which to stop, ascending."""
    if not len(times):
        return times
    heights = _heights(times, values)
    reach = float(np.ptp(values))
    least = max(ROUNDING * reach, DIGITS * float(np.max(np.abs(values))))
    if len(heights) > FEW:
        least = max(least, min(HIGH * reach, float(np.partition(heights, -FEW - 1)[-FEW - 1])))
    found: Vector = times[heights > least]
    return found


def _heights(times: Vector, values: Vector) -> Vector:
    """The greatest height of each point: at distances 1, 2, 4, ..., every point, every second one,
    every fourth one, and so on. Values stand still outside of the table; where it jumps at an end,
    the other point of that time is high."""
    found, apart = np.zeros(len(times)), 1
    while apart < len(times):
        t, u = times[::apart], values[::apart]
        before, after = np.diff(t, prepend=2 * t[0] - t[1]), np.diff(t, append=2 * t[-1] - t[-2])
        back, ahead = np.diff(u, prepend=u[0]), np.diff(u, append=u[-1])
        height, around = np.abs(ahead * before - back * after), before + after
        height = np.divide(height, around, out=np.zeros_like(height), where=around > 0)
        found[::apart] = np.maximum(found[::apart], height)
        apart *= 2
    return found
