"""Hatches along a curve that is fixed in the ground, on its solid side.

In:   a CURVE, the points of all bodies as they start, the width of a link
Out:  an Item   a CURVE `hatch`, whose points are the two ends of each stroke

The solid side is the one where the fewer points of bodies lie, each seen from the place of the
curve that is nearest to it; the right one, of the way along the curve, where they are as many.

Example: a floor from (-1, 0) to (1, 0) with a ball above it: strokes to the lower left
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from planarc.core.arrays import Vector
from planarc.view.item import Item
from planarc.view.linkage.groups import Place

#: The distance of strokes and how far they reach, in units; the most strokes.
_STEP, _DEEP, _MOST = 0.75, 0.55, 80


def hatches(curve: Item, bodies: Sequence[Place], unit: float) -> Item:
    """The strokes beside a curve of the ground."""
    line = np.array(curve.points)
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))))
    count = int(np.clip(round(along[-1] / (_STEP * unit)), 3, _MOST))
    at = (np.arange(count) + 0.8) / count * along[-1]
    begin = np.stack([np.interp(at, along, line[:, i]) for i in (0, 1)], axis=1)
    way = _directions(line, along, at)
    right = _solid_side(curve, line, bodies) * np.stack([way[:, 1], -way[:, 0]], axis=1)
    begin = begin + 0.5 * float(np.max(curve.width)) * right
    end = begin + _DEEP * unit * (right - way)
    strokes = np.stack([begin, end], axis=1).reshape(-1, 2).tolist()
    return replace(curve, shape="hatch", points=tuple((x, y) for x, y in strokes))


def _directions(line: Vector, along: Vector, at: Vector) -> Vector:
    """Unit vectors along a line, at places along it."""
    piece = np.searchsorted(along, at, "right").clip(1, len(line) - 1)
    step = line[piece] - line[piece - 1]
    found: Vector = step / np.maximum(np.hypot(*step.T), 1e-300)[:, None]
    return found


def _solid_side(curve: Item, line: Vector, bodies: Sequence[Place]) -> float:
    """1 where what is solid lies to the right of a line, else -1."""
    x, y, angle = (float(np.ravel(v)[0]) for v in (curve.x, curve.y, curve.angle))
    c, s = np.cos(angle), np.sin(angle)
    left = 0.0
    for u, v in bodies:
        point = np.array([c * (u - x) + s * (v - y), c * (v - y) - s * (u - x)])
        near = int(np.argmin(np.hypot(*(line - point).T)))
        way = line[min(near + 1, len(line) - 1)] - line[max(near - 1, 0)]
        off = point - line[near]
        left += float(np.sign(way[0] * off[1] - way[1] * off[0]))
    return 1.0 if left >= 0.0 else -1.0
