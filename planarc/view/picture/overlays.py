"""Overlays of the mechanism, as items of a scene: the report's layers, paths of points.

The largest vector of a layer is a good quarter of the mechanism's size, as on the page.

A point is named by a vector of the model (`couplerBody.r_0CM`), by a component that has one
(`couplerBody`: its centre of mass, or the origin of its frame), or by a frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from msgspec.structs import replace

from planarc.core.unknown import refuse_unknown, unknown_name
from planarc.ir.insight import Layer, Mark, Track
from planarc.ir.result import Result
from planarc.view.item import Item, Kind, plain
from planarc.view.linkage.palette import FORCE
from planarc.view.picture.furniture import Key, round_125
from planarc.view.picture.names import NAMES, tags
from planarc.view.scene import Scene, with_items

#: Red, green, blue by the id of a layer; those of the page's light ground.
_COLORS = {
    "paths": (13.0, 122.0, 95.0),
    "forces": FORCE,
    "contacts": (194.0, 106.0, 0.0),
    "velocities": (29.0, 99.0, 196.0),
    "accelerations": (160.0, 56.0, 155.0),
    "masses": (186.0, 190.0, 197.0),
}
#: The longest vector and the thickness of all, as shares of the mechanism's larger side.
_LONGEST, _THICK = 0.28, 0.009
#: The radius of the disc of the largest mass, as such a share.
HEAVIEST = 0.08
#: The height of what covers all else.
_TOP = 1e6

#: The endings with which a name is tried, in this order.
_VECTORS = ("", ".r_0CM", ".r", ".frame_a.r", ".frame_b.r")
#: The most points of a path; no picture shows more.
_POINTS = 600


def with_layers(
    scene: Scene, layers: Sequence[Layer], names: Sequence[str]
) -> tuple[Scene, tuple[Key, ...]]:
    """The scene with some layers, by their ids, and keys of arrows. Raises UnknownName for
    others."""
    known = {layer.id: layer for layer in layers if layer.id in _COLORS}
    refuse_unknown("layer of this mechanism", names, [*known, NAMES])
    chosen = [known[name] for name in dict.fromkeys(names) if name != NAMES]
    span = _span(scene)
    vectors = {layer.id: _common(layer, scene, span) for layer in chosen if layer.kind == "vectors"}
    items = [i for layer in chosen for i in _items(layer, span, vectors.get(layer.id, 0.0))]
    under = [i for i in items if i.kind is not Kind.ARROW]
    over = [i for i in items if i.kind is Kind.ARROW]
    shared = {layer.unit: vectors[layer.id] for layer in chosen if vectors.get(layer.id)}
    drawn = with_items(
        _rescaled(scene, shared), under, [*over, *(tags(scene) if NAMES in names else ())]
    )
    keys = [_key(s.unit, s.metres, span, s.color) for s in scene.scales if s.unit not in shared]
    told = [layer for layer in chosen if vectors.get(layer.id)]
    keys += [_key(v.unit, vectors[v.id], span, _COLORS[v.id]) for v in told]
    return drawn, tuple(keys)


def _span(scene: Scene) -> float:
    left, bottom, right, top = scene.box or (-1.0, -1.0, 1.0, 1.0)
    return max(right - left, top - bottom, 1e-9)


def _common(layer: Layer, scene: Scene, span: float) -> float:
    """The scale of vectors, which arrows of the same unit that components draw share."""
    own = _scale([mark for mark in layer.members if mark.on], span)
    return min([own, *(s.metres for s in scene.scales if s.unit == layer.unit)])


def _rescaled(scene: Scene, scales: Mapping[str, float]) -> Scene:
    """The scene with its own arrows to other scales, by their units."""
    items = scene.items
    for scale in scene.scales:
        if scale.unit in scales:
            items = tuple(scale.changed(item, scales[scale.unit]) for item in items)
    return replace(scene, items=items)


def _items(layer: Layer, span: float, scale: float) -> Iterator[Item]:
    marks = [mark for mark in layer.members if mark.on]
    if layer.kind == "paths":
        yield from (_path(m.name, m.x, m.y, _COLORS[layer.id]) for m in marks)
        return
    if layer.kind == "masses":
        yield from _masses(marks, span, _COLORS[layer.id])
        return
    if not scale:
        return
    for mark in marks:
        angle = np.arctan2(mark.v, mark.u)
        turned = np.unwrap(np.nan_to_num(angle)) if angle.ndim else float(angle)
        length, width = plain(np.hypot(mark.u, mark.v) * scale), _THICK * span
        place = mark.name, Kind.ARROW, mark.x, mark.y, turned
        yield Item(*place, length, width, _COLORS[layer.id], _TOP)


def _masses(
    marks: Sequence[Mark], span: float, color: tuple[float, float, float]
) -> Iterator[Item]:
    """Discs whose areas are as the masses."""
    largest = max((float(np.max(m.u)) for m in marks), default=0.0)
    for mark in marks:
        wide = 2 * HEAVIEST * span * math.sqrt(float(np.max(mark.u)) / largest)
        place = mark.name, Kind.SHAPE, mark.x, mark.y, 0.0, 0.0
        yield Item(*place, wide, color, shape="sphere", upright=True)


def _scale(marks: Sequence[Mark], span: float) -> float:
    """Metres that a vector of size 1 is drawn long; 0 where none has a size."""
    sizes = (np.nanmax(np.hypot(m.u, m.v), initial=0.0) for m in marks)
    largest = max(map(float, sizes), default=0.0)
    return _LONGEST * span / largest if largest > 0 and math.isfinite(largest) else 0.0


def _key(unit: str, scale: float, span: float, color: tuple[Track, Track, Track]) -> Key:
    """The arrow that says how long a round value is drawn."""
    value = round_125(0.5 * _LONGEST * span / scale)
    text = f"{value:.10g} {unit}" if value < 1e6 else f"{value:.0e} {unit}"
    return Key(text, value * scale, color)


def _path(name: str, x: Track, y: Track, color: tuple[float, float, float]) -> Item:
    places = zip(*np.broadcast_arrays(np.atleast_1d(x), np.atleast_1d(y)), strict=True)
    points = tuple((float(a), float(b)) for a, b in places if np.isfinite(a + b))
    return Item(name, Kind.CURVE, 0.0, 0.0, 0.0, 0.0, 0.0, color, points=points)


def trace_items(result: Result, names: Sequence[str]) -> tuple[Item, ...]:
    """The paths of named points. Raises UnknownName (a UsageError) for a name that is none."""
    return tuple(_trace(result, name) for name in names)


def _trace(result: Result, name: str) -> Item:
    vector = next((name + v for v in _VECTORS if f"{name}{v}[1]" in result), None)
    if vector is None or f"{vector}[2]" not in result:
        vectors = (n[:-3] for n in result.columns if n.endswith("[1]") and n[:-3] + "[2]" in result)
        parts = (p.name for p in result.program.parts if _has_point(result, p.name))
        raise unknown_name("point", name, dict.fromkeys((*parts, *vectors)))
    x, y = result[f"{vector}[1]"], result[f"{vector}[2]"]
    times = np.linspace(result.time[0], result.time[-1], min(_POINTS, 4 * len(x)))
    path = np.interp(times, result.time, x), np.interp(times, result.time, y)
    return _path(name, *path, _COLORS["paths"])


def _has_point(result: Result, part: str) -> bool:
    return any(f"{part}{v}[1]" in result for v in _VECTORS[1:])
