"""The picture of a mechanism that draws nothing itself: its frames and joints.

In:   Result with its mechanism
Out:  items: a bar between the frames of a link, a circle at each joint, axes at the origin

Used only where no component has a visual of its own, as in a library without pictures or with
`enableAnimation=false`. Sizes follow from how far the frames are spread.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from planarc.ir.insight import Track
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.result import Result
from planarc.view.item import Item, Kind, plain, smooth

_LINK, _JOINT, _GROUND = (110.0, 122.0, 138.0), (214.0, 69.0, 65.0), (90.0, 96.0, 105.0)


def skeleton(result: Result, axes: bool = True) -> list[Item]:
    """Bars, joints and axes; none where the result holds no positions of frames."""
    mechanism = result.program.mechanism
    if mechanism is None or not len(result.time):
        return []
    points = {
        frame: (result.track(f"{frame}.r[1]"), result.track(f"{frame}.r[2]"))
        for link in mechanism.links
        for frame in link.frames
        if f"{frame}.r[1]" in result and f"{frame}.r[2]" in result
    }
    if not points:
        return []
    size = _spread(points)
    found = [*_bars(mechanism, points, size), *_joints(mechanism, points, size)]
    return [_axes(size), *found] if axes else found


def _axes(size: float) -> Item:
    return Item(
        "world", Kind.FRAME, 0.0, 0.0, 0.0, size / 6, size / 200, _GROUND, -size,
        labels=("x", "y"),
    )  # fmt: skip


def _bars(
    mechanism: Mechanism, points: dict[str, tuple[Track, Track]], size: float
) -> Iterator[Item]:
    """Bars from the first frame of a link to its others, each place once."""
    for i, link in enumerate(mechanism.links):
        frames = [f for f in link.frames if f in points]
        if i == GROUND or not frames:
            continue
        x, y = points[frames[0]]
        seen = set()
        for frame in frames[1:]:
            dx, dy = points[frame][0] - x, points[frame][1] - y
            length = np.hypot(dx, dy)
            key = np.round(np.asarray(length) / size, 9).tobytes()
            if not np.any(length > 1e-9 * size) or key in seen:
                continue
            seen.add(key)
            yield Item(
                link.name, Kind.SHAPE, x, y, smooth(np.arctan2(dy, dx)), plain(length), size / 50,
                _LINK, shape="beam",
            )  # fmt: skip
        if not seen:
            yield Item(
                link.name, Kind.SHAPE, x, y, 0.0, size / 25, size / 25, _LINK, 0.0,
                shape="box", upright=True,
            )  # fmt: skip


def _joints(
    mechanism: Mechanism, points: dict[str, tuple[Track, Track]], size: float
) -> Iterator[Item]:
    for joint in mechanism.joints:
        for frame in joint.frames:
            if frame in points:
                x, y = points[frame]
                yield Item(
                    joint.name, Kind.SHAPE, x, y, 0.0, size / 30, size / 30, _JOINT, size,
                    shape="cylinder", upright=True,
                )  # fmt: skip


def _spread(points: dict[str, tuple[Track, Track]]) -> float:
    spans = [
        np.ptp(np.concatenate([np.atleast_1d(p[axis]) for p in points.values()])) for axis in (0, 1)
    ]
    largest = float(max(spans))
    return largest if largest > 0 and np.isfinite(largest) else 1.0
