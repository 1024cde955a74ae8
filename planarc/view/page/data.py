"""The numbers that a page carries.

In:   Result, Scene, figures
Out:  values for `json`

    scene    {time, tracks, shapes, items, box, layers, scales, events}; a moving quantity of an
             item is `[number of its track]`, one that never changes a number; items name their
             shape by its number, the parts of a form's lengths stand in the order of its `basis`
    curves   {time, columns, variables, figures}; a variable is
             [name, number of its column, factor, unit, description]

One choice of rows serves curves and motion: of every stretch of time the rows where a curve of
the figures is lowest and highest, so that no peak is lost. A page has room for so many
characters; variables that do not fit are left out, parameters of parts first, and counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from math import pi
from typing import Any

import numpy as np

from planarc.core.arrays import Vector
from planarc.ir.insight import Layer, Series, Track
from planarc.ir.program import Column
from planarc.ir.result import Result
from planarc.view.arrows import Scale
from planarc.view.item import Item
from planarc.view.marks.shapes import Shape, bounded_extra, shape_of
from planarc.view.page.columns import Columns, encode, number
from planarc.view.page.figures import Figure
from planarc.view.page.shapes import shape_data
from planarc.view.scene import Scene

#: The most rows of a page: more would make it slow to load, and no screen shows them.
ROWS = 3000
#: Characters for the variables, and the least number of rows.
ROOM, FEWEST_ROWS = 1_000_000, 600
#: Characters of the motion that always have room beside them.
_MOTION = 250_000

_DEGREES = 180 / pi


def scene_data(
    scene: Scene,
    rows: Any = None,
    events: Iterable[float] = (),
    layers: Sequence[Layer] = (),
    tracks: Columns | None = None,
) -> dict[str, Any]:
    """The motion of all rows, or of some; `tracks` keep its columns in another way."""
    chosen = slice(None) if rows is None else rows
    tracks = Columns(chosen) if tracks is None else tracks

    def put(track: Track) -> Any:
        return number(track) if isinstance(track, (int, float)) else [tracks.add(track)]

    shapes: dict[Shape, int] = {}
    items = [_item(item, put, shapes) for item in scene.items]
    corner = [] if scene.corner is None else [_corner(scene.corner, put, shapes)]
    return {
        "time": encode(scene.time[chosen], "<f8"),
        "items": items,
        "shapes": [shape_data(shape) for shape in shapes],
        "layers": [*(_layer(layer, put) for layer in layers), *corner],
        "scales": [_scale(scale) for scale in scene.scales],
        "tracks": tracks.all,
        "box": scene.box,
        "classes": scene.classes,
        "events": [float(t) for t in events],
    }


def room_beside(scene: dict[str, Any]) -> int:
    """Characters for the variables of a page that shows a scene: a long one leaves less."""
    carried = sum(len(t) for t in scene["tracks"] if isinstance(t, str))
    return max(ROOM // 5, ROOM - max(0, carried - _MOTION))


def curve_data(
    result: Result,
    figures: Sequence[Figure],
    rows: Any = None,
    series: Sequence[Series] = (),
    room: int = ROOM,
    columns: Columns | None = None,
) -> dict[str, Any]:
    """The variables, and which of them the figures show; `left_out` counts what did not fit."""
    chosen = slice(None) if rows is None else rows
    columns = Columns(chosen) if columns is None else columns
    variables: list[list[Any]] = [
        [s.name, columns.add(s.values), 1.0, s.unit, s.description] for s in series
    ]
    first = {name for figure in figures for name in figure.curves}
    left_out = 0
    for column in sorted(
        (c for c in result.program.columns if not c.name.startswith("$")),
        key=lambda c: (c.name not in first, c.protected, c.constant),
    ):
        if column.name not in first and columns.size + 110 * len(variables) > room:
            left_out += 1
            continue
        scale, unit = shown_unit(column)
        values = columns.add(_values(result, column))
        factor = _factor(column.sign * scale)
        variables.append([column.name, values, factor, unit, column.description])
    order = {c.name: i for i, c in enumerate(result.program.columns)}
    variables.sort(key=lambda v: order.get(v[0], -1))
    return {
        "time": encode(result.time[chosen], "<f8"),
        "columns": columns.all,
        "variables": variables,
        "figures": [
            {"title": f.title, "on": f.on, "curves": list(f.curves)} for f in figures if f.curves
        ],
        "left_out": left_out,
    }


def shown_unit(column: Column) -> tuple[float, str]:
    """Factor and unit of a variable: angles in degrees, unless the model wants another unit."""
    if column.unit == "rad" and column.display_unit in ("deg", ""):
        return _DEGREES, "deg"
    return 1.0, column.unit


_factor = cache(number)  # there are few


def _values(result: Result, column: Column) -> Track:
    """The values without the sign, so that opposite variables share a column."""
    return result.of_slot(column.slot)


def choose_rows(result: Result, figures: Sequence[Figure], tracks: int, share: int = 1) -> Any:
    """The rows of a page: all, or so many that what must be there has room, which so many runs
    share."""
    shown = [n for f in figures if f.on for n in f.curves if n in result][:24]
    needed = tracks + sum(len(f.curves) for f in figures)
    limit = min(ROWS, max(FEWEST_ROWS, int(ROOM / (5.34 * max(1, needed))))) // share
    return thin_rows(len(result.time), [result[name] for name in shown], limit)


def thin_rows(count: int, columns: Sequence[Vector], limit: int = ROWS) -> Any:
    """The rows to keep, ascending: all, or at most about `limit`.

    A third are spread evenly, for the motion; the others are where a column is lowest and
    highest in a stretch.
    """
    if count <= limit:
        return np.arange(count)
    keep = [np.linspace(0, count - 1, max(2, limit // 3)).astype(int)]
    pieces = max(1, limit // (3 * max(1, len(columns))))
    length = -(-count // pieces)
    starts = np.arange(0, count, length)
    for column in columns:
        padded = np.resize(column, length * len(starts))
        padded[count:] = column[-1]  # the last row again, so that all stretches are as long
        stretches = np.nan_to_num(padded).reshape(len(starts), length)
        keep += [starts + stretches.argmin(axis=1), starts + stretches.argmax(axis=1)]
    kept = np.zeros(count, dtype=bool)
    kept[np.minimum(np.concatenate(keep), count - 1)] = True
    return np.flatnonzero(kept)


def _item(item: Item, put: Any, shapes: dict[Shape, int]) -> dict[str, Any]:
    shape = shape_of(item)
    data = {name: put(getattr(item, name)) for name in ("x", "y", "angle", "length", "width")}
    extra = bounded_extra(item)
    if not isinstance(extra, float) or extra:
        data["extra"] = put(extra)
    shaped = shapes.setdefault(shape, len(shapes))
    color = [put(c) for c in item.color]
    if item.shape == "plate" and item.points:
        data["middle"] = [number(float(m)) for m in np.mean(item.points, axis=0)]
    told = {"component": item.component, "shape": shaped, "color": color, **data}
    return {**told, "parts": item.parts} if item.parts else told


def _corner(item: Item, put: Any, shapes: dict[Shape, int]) -> dict[str, Any]:
    """The axes of the world, as a layer that can be put out."""
    told = {"id": "axes", "title": "Axes", "kind": "corner", "unit": "", "on": True, "members": []}
    return {**told, "item": _item(item, put, shapes)}


def _scale(scale: Scale) -> dict[str, Any]:
    """What tells how long arrows are that components draw."""
    color = [number(float(np.ravel(c)[0])) for c in scale.color]
    return {"unit": scale.unit, "metres": scale.metres, "color": color}


def _layer(layer: Layer, put: Any) -> dict[str, Any]:
    members = []
    for m in layer.members:
        member = {"name": m.name, "x": put(m.x), "y": put(m.y)}
        if layer.kind == "vectors":
            member.update(u=put(m.u), v=put(m.v))
        if layer.kind == "masses":
            member.update(u=put(m.u))
        members.append(member if m.on else {**member, "on": False})
    told = {name: getattr(layer, name) for name in ("id", "title", "kind", "unit", "on")}
    return {**told, "members": members}
