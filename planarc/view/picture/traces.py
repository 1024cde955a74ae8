"""The paths of points, as items of a scene.

A point is named by a vector of the model (`couplerBody.r_0CM`), by a component that has one
(`couplerBody`: its centre of mass, or the origin of its frame), or by a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.unknown import unknown_name
from planarc.view.item import Item, Kind

if TYPE_CHECKING:
    from planarc.ir.result import Result

#: The endings with which a name is tried, in this order.
_VECTORS = ("", ".r_0CM", ".r", ".frame_a.r", ".frame_b.r")
_COLOR = (214.0, 69.0, 65.0)
#: The most points of a path; no picture shows more.
_POINTS = 600


def trace_items(result: Result, names: Sequence[str]) -> tuple[Item, ...]:
    """The paths of named points. Raises UnknownName (a UsageError) for a name that is none."""
    return tuple(_trace(result, name) for name in names)


def _trace(result: Result, name: str) -> Item:
    import numpy as np

    vector = next((name + v for v in _VECTORS if f"{name}{v}[1]" in result), None)
    if vector is None or f"{vector}[2]" not in result:
        vectors = (n[:-3] for n in result.columns if n.endswith("[1]") and n[:-3] + "[2]" in result)
        parts = (p.name for p in result.program.parts if _has_point(result, p.name))
        raise unknown_name("point", name, dict.fromkeys((*parts, *vectors)))
    x, y = result[f"{vector}[1]"], result[f"{vector}[2]"]
    times = np.linspace(result.time[0], result.time[-1], min(_POINTS, 4 * len(x)))
    path = zip(np.interp(times, result.time, x), np.interp(times, result.time, y), strict=True)
    points = tuple((float(a), float(b)) for a, b in path if np.isfinite(a + b))
    return Item(name, Kind.CURVE, 0.0, 0.0, 0.0, 0.0, 0.0, _COLOR, points=points)


def _has_point(result: Result, part: str) -> bool:
    return any(f"{part}{v}[1]" in result for v in _VECTORS[1:])
