"""The numbers that the page carries, thinned and rounded.

In:   Result, Scene, curves
Out:  a value for `json`: times, curves, and items whose moving quantities are `[track number]`

One choice of rows serves curves and animation: of every stretch of time the rows where a curve
is lowest and highest, so that no peak is lost. Equal tracks are written once.

Example:  {"time": [0, 0.1], "tracks": [[0, -0.02]], "items": [{"angle": [0], "length": 1.2}]}
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from planarc.view.report.curves import Curve

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.ir.result import Result
    from planarc.view.scene import Item, Scene, Track

#: Rows on the page; more would make it slow to load, and no screen shows them.
ROWS = 3000


def page_data(result: Result, scene: Scene, curves: tuple[Curve, ...]) -> dict[str, Any]:
    """Everything that the page's script reads."""
    values = [result[curve.name] * curve.scale for curve in curves]
    rows = thin_rows(len(result.time), values)
    tracks = _Tracks(rows)
    return {
        "time": _numbers(result.time[rows], 9),
        "rows": len(result.time),
        "curves": [
            {
                "name": curve.name,
                "unit": curve.unit,
                "description": curve.description,
                "shown": curve.shown,
                "values": _numbers(column[rows], 7),
            }
            for curve, column in zip(curves, values, strict=True)
        ],
        "items": [_item(item, tracks) for item in scene.items],
        "tracks": tracks.all,
        "box": scene.box,
    }


def thin_rows(count: int, columns: list[NDArray[np.float64]], limit: int = ROWS) -> Any:
    """The rows to keep, ascending: all, or at most about `limit`."""
    import numpy as np

    if count <= limit:
        return np.arange(count)
    keep = {0, count - 1}
    pieces = max(2, limit // (2 * max(1, len(columns))))
    edges = np.linspace(0, count, pieces + 1).astype(int)
    for start, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        keep.add(start)
        for column in columns:
            piece = column[start:end]
            keep.update((start + int(np.argmin(piece)), start + int(np.argmax(piece))))
    return np.array(sorted(keep))


class _Tracks:
    """The moving quantities of all items, each distinct one once."""

    def __init__(self, rows: NDArray[np.int64]) -> None:
        self._rows = rows
        self._known: dict[bytes, int] = {}
        self.all: list[list[float | None]] = []

    def __call__(self, track: Track) -> float | list[int] | None:
        if isinstance(track, (int, float)):
            return _number(float(track), 7)
        key = track.tobytes()
        if key not in self._known:
            self._known[key] = len(self.all)
            self.all.append(_numbers(track[self._rows], 6))
        return [self._known[key]]


def _item(item: Item, tracks: _Tracks) -> Mapping[str, Any]:
    data: dict[str, Any] = {
        "component": item.component,
        "kind": item.kind.value,
        "x": tracks(item.x),
        "y": tracks(item.y),
        "angle": tracks(item.angle),
        "length": tracks(item.length),
        "width": tracks(item.width),
        "color": [tracks(c) for c in item.color],
    }
    if item.shape:
        data.update(shape=item.shape, upright=item.upright, extra=tracks(item.extra))
    if item.labels:
        data["labels"] = list(item.labels)
    if item.points:
        data["points"] = [[_number(x, 6), _number(y, 6)] for x, y in item.points]
    return data


def _numbers(values: Any, digits: int) -> list[float | None]:
    """As many significant digits as the largest value needs; what is not finite is null."""
    import numpy as np

    finite = values[np.isfinite(values)]
    largest = float(np.max(np.abs(finite))) if finite.size else 0.0
    places = digits - 1 - math.floor(math.log10(largest)) if largest > 0 else 0
    if places > 300:  # nothing but noise around zero
        return [0.0] * len(values)
    rounded = np.round(values.astype(float), places) + 0.0  # + 0.0: no -0
    if finite.size == values.size:
        return rounded.tolist()  # type: ignore[no-any-return]
    return [v if math.isfinite(v) else None for v in rounded.tolist()]


def _number(value: float, digits: int) -> float | None:
    return float(f"{value:.{digits}g}") if math.isfinite(value) else None
