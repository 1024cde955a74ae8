"""Paths and vectors that the report lays over the mechanism, as items of a scene.

The largest vector of a layer is a good quarter of the mechanism's size, as on the page.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from planarc.core.unknown import unknown_name
from planarc.ir.insight import Layer, Mark
from planarc.view.item import Item, Kind
from planarc.view.scene import Scene, with_items

#: Red, green, blue by the id of a layer; those of the page's light ground.
_COLORS = {
    "paths": (13.0, 122.0, 95.0),
    "forces": (192.0, 54.0, 44.0),
    "velocities": (29.0, 99.0, 196.0),
    "accelerations": (160.0, 56.0, 155.0),
}
#: The longest vector and the thickness of all, as shares of the mechanism's larger side.
_LONGEST, _THICK = 0.28, 0.009
#: The height of what covers all else.
_TOP = 1e6


def with_layers(scene: Scene, layers: Sequence[Layer], names: Sequence[str]) -> Scene:
    """The scene with some layers, by their ids. Raises UnknownName for others."""
    known = {layer.id: layer for layer in layers if layer.id in _COLORS}
    for name in names:
        if name not in known:
            raise unknown_name("layer of this mechanism", name, known)
    chosen = [known[name] for name in dict.fromkeys(names)]
    items = [item for layer in chosen for item in _items(layer, _span(scene))]
    under = [i for i in items if i.kind is Kind.CURVE]
    return with_items(scene, under, [i for i in items if i.kind is not Kind.CURVE])


def _span(scene: Scene) -> float:
    left, bottom, right, top = scene.box or (-1.0, -1.0, 1.0, 1.0)
    return max(right - left, top - bottom, 1e-9)


def _items(layer: Layer, span: float) -> Iterator[Item]:
    import numpy as np

    marks = [mark for mark in layer.members if mark.on]
    if layer.kind == "paths":
        yield from (_path(mark, _COLORS[layer.id]) for mark in marks)
        return
    sizes = [np.hypot(mark.u, mark.v) for mark in marks]
    largest = max((float(np.nanmax(s, initial=0.0)) for s in sizes), default=0.0)
    if not (largest > 0 and math.isfinite(largest)):
        return
    for mark, size in zip(marks, sizes, strict=True):
        angle = np.arctan2(mark.v, mark.u)
        turned = np.unwrap(np.nan_to_num(angle)) if angle.ndim else float(angle)
        length = size * (_LONGEST * span / largest)
        yield Item(
            mark.name,
            Kind.ARROW,
            mark.x,
            mark.y,
            turned,
            length if length.ndim else float(length),
            _THICK * span,
            _COLORS[layer.id],
            _TOP,
        )


def _path(mark: Mark, color: tuple[float, float, float]) -> Item:
    import numpy as np

    x, y = np.broadcast_arrays(np.atleast_1d(mark.x), np.atleast_1d(mark.y))
    points = tuple((float(a), float(b)) for a, b in zip(x, y, strict=True) if np.isfinite(a + b))
    return Item(mark.name, Kind.CURVE, 0.0, 0.0, 0.0, 0.0, 0.0, color, points=points)
