"""The box around drawn things, at all times."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import starmap
from typing import Any

import numpy as np

from planarc.evaluate.record import span
from planarc.view.item import Item, Kind


def bounds(items: Sequence[Item]) -> tuple[float, float, float, float] | None:
    """The smallest upright rectangle around all items at all times."""
    points = [point for item in items for point in _outline(item)]
    spans = [span([point[axis] for point in points]) for axis in (0, 1)]
    if None in spans:
        return None
    (left, right), (low, high) = spans  # type: ignore[misc]
    return left, low, right, high


_CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def _outline(item: Item) -> list[tuple[Any, Any]]:
    """Points that lie on the edge of what is drawn, or a little outside."""
    c, s = np.cos(item.angle), np.sin(item.angle)

    def at(u: Any, v: Any) -> tuple[Any, Any]:
        return item.x + c * u - s * v, item.y + s * u + c * v

    if item.kind is Kind.CURVE:
        return [at(u, v) for u, v in item.points]
    if item.shape == "plate":
        r = item.width / 2
        return [(x + i * r, y + j * r) for x, y in starmap(at, item.points) for i, j in _CORNERS]
    if item.kind is Kind.FRAME:
        return [at(0.0, 0.0), at(item.length, 0.0), at(0.0, item.length)]
    half = np.abs(item.width) / 2
    if item.upright:
        x, y = at(*item.points[0]) if item.points else (item.x, item.y)
        return [(x - half, y - half), (x + half, y + half)]
    if item.shape == "ground":
        return [at(-half, -np.abs(item.length)), at(half, 0.0)]
    if item.shape == "block":
        return [at(i * item.length / 2, j * half) for i, j in _CORNERS]
    return [at(u, v) for u in (0.0, item.length) for v in (-half, half)]
