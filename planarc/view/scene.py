"""The scene: what a mechanism looks like, as plain data over the rows of a result.

In:   Result   its program lists the visuals: attributes as expressions in the model's variables
Out:  Scene    one item a drawn thing: where it is, how it is turned, its size and colour

Every kind of visual is brought to one form, so that any viewer can show it: an origin `x`, `y`
in the world, an `angle` of its length, `length` and `width`. A quantity is a number when it
never changes, else an array with a value for each row.

Example: the rod of a pendulum, 1.2 m long, at the origin

    shape(shapeType="beam", r=rod.frame_a.r, phi=rod.frame_a.phi, length=1.2, width=0.06)
    -> Item(shape="beam", x=0.0, y=0.0, angle=array([0, -0.02, ...]), length=1.2, width=0.06)

Needs:     a result whose columns hold the variables that the attributes name.
           Where nothing of the mechanism draws itself, its links and joints are drawn.
Promises:  items in drawing order (`height`, then declaration); angles without jumps of
           whole turns; what cannot be evaluated is left out and named in `notes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from msgspec.structs import replace

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.evaluate.record import first
from planarc.evaluate.rows import RowValues
from planarc.ir.dae import Visual
from planarc.ir.expr import Expr, Op, symbol_text
from planarc.ir.insight import Track
from planarc.ir.result import Result
from planarc.view.arrows import Scale, scaled
from planarc.view.box import bounds
from planarc.view.item import Item, Kind, plain, smooth
from planarc.view.linkage.dress import dress
from planarc.view.linkage.groups import find_groups
from planarc.view.linkage.palette import JOINT
from planarc.view.skeleton import skeleton


class Scene(Data):
    """Items over time; `box` is (left, bottom, right, top) of all at any time, or None.

    `corner` are the axes of the world and gravity, small and measured in pixels. `classes` are
    those of the components that the items belong to.
    """

    time: Vector
    items: tuple[Item, ...]
    box: tuple[float, float, float, float] | None
    notes: tuple[str, ...] = ()
    corner: Item | None = None
    classes: Mapping[str, str] = {}
    scales: tuple[Scale, ...] = ()  # of arrows that components draw


class NotDrawable(Exception):
    """The reason why an attribute has no value; told to the user as a note."""


def make_scene(result: Result) -> Scene:
    """The scene of a run, one pose for each row of the result."""
    values = RowValues(lambda e: _leaf(result, e), _undrawable)
    items: list[Item] = []
    notes: list[str] = []
    worlds = {part.name for part in result.program.parts if part.inner}
    with np.errstate(all="ignore"):
        for visual in result.program.visuals:
            try:
                attributes = {name: _evaluated(value, values) for name, value in visual.attributes}
                items.append(_item(visual, attributes))
            except NotDrawable as reason:
                notes.append(f"`{visual.component}` is not drawn: {reason}")
        groups = find_groups(result)
        world = [item for item in items if item.component.rpartition(".")[0] in worlds]
        stays = {id(item) for item in world if item.kind is not Kind.SHAPE}
        items = [item for item in items if id(item) not in stays]
        items = dress(items, groups) or skeleton(result, groups)
        items, scales = scaled(items, result, notes)
        box = bounds(items)
    classes = _classes(result, items)
    return Scene(result.time, tuple(items), box, tuple(notes), corner_of(world), classes, scales)


def _classes(result: Result, items: Sequence[Item]) -> dict[str, str]:
    """The classes of the components that are drawn, without their packages."""
    shown = {name for item in items for name in (item.component, *item.parts)}
    shown |= {name.rpartition(".")[0] for name in shown}
    parts = (part for part in result.program.parts if part.name in shown)
    return {part.name: part.class_name.rpartition(".")[2] for part in parts}


def corner_of(world: Sequence[Item]) -> Item | None:
    """The axes and the gravity arrow of the world, as one item for a corner of the picture."""
    axes = next((item for item in world if item.kind is Kind.FRAME), None)
    arrow = next((item for item in world if item.kind is Kind.ARROW), None)
    if axes is None and arrow is None:
        return None
    labels = axes.labels if axes is not None else ()
    way = first(arrow.angle) if arrow is not None and first(arrow.length) else None
    down = () if way is None else ((math.cos(way), math.sin(way)),)
    return Item(
        "world", Kind.SHAPE, 0.0, 0.0, 0.0, 0.0, 0.0, JOINT, shape="corner", upright=True,
        labels=labels, points=down,
    )  # fmt: skip


def with_items(scene: Scene, under: Sequence[Item], over: Sequence[Item]) -> Scene:
    """The scene with more items below and above all others."""
    if not (under or over):
        return scene
    items = (*under, *scene.items, *over)
    with np.errstate(all="ignore"):
        box = bounds(items)
    return replace(scene, items=items, box=box)


def _evaluated(value: Any, values: Callable[[Expr], Any]) -> Any:
    """The value of an attribute: nested tuples keep their nesting, texts stay."""
    if isinstance(value, tuple):
        return tuple(_evaluated(item, values) for item in value)
    return values(value) if isinstance(value, Expr) else value


def _leaf(result: Result, e: Expr) -> Any:
    if e.op is Op.TIME:
        return result.time
    if e.op is Op.EVENT:
        return _undrawable(e, ())
    name = symbol_text(*e.data) if e.op is Op.SYMBOL else e.data
    if name not in result:
        raise NotDrawable(f"the result has no variable `{name}`")
    return result.track(name)


def _undrawable(e: Expr, args: Sequence[Any]) -> Any:
    raise NotDrawable("its attributes use events or functions that cannot be inlined")


def _item(visual: Visual, a: dict[str, Any]) -> Item:
    try:
        kind = Kind(visual.kind)
    except ValueError:
        raise NotDrawable(f"nobody knows how to draw the kind `{visual.kind}`") from None
    try:
        return _MAKERS[kind](visual.component, a)
    except KeyError as missing:
        raise NotDrawable(f"it has no attribute `{missing.args[0]}`") from None


def _shape(component: str, a: dict[str, Any]) -> Item:
    x, y = _offset(a["r"], a["phi"], a["r_shape"])
    more = {"shape": str(a["shapeType"]), "upright": bool(first(a["zDirection"]))}
    shape = _placed(component, Kind.SHAPE, a, a["length"], a["width"], extra=a["extra"], **more)
    return replace(shape, x=x, y=y, angle=smooth(a["phi"] + a["angle"]))


def _arrow(kind: Kind, component: str, a: dict[str, Any]) -> Item:
    x, y = _offset(a["r"], a["phi"], a["r_tail"])
    hx, hy = a["r_head"]
    arrow = _placed(component, kind, a, plain(np.hypot(hx, hy)), a["width"])
    return replace(arrow, x=x, y=y, angle=smooth(a["phi"] + np.arctan2(hy, hx)))


def _frame(component: str, a: dict[str, Any]) -> Item:
    labels = str(a["label1"]), str(a["label2"])
    return _placed(component, Kind.FRAME, a, a["axisLength"], a["axisWidth"], labels=labels)


def _curve(component: str, a: dict[str, Any]) -> Item:
    points = tuple((first(x), first(y)) for x, y in a["points"])
    shape = "" if first(a.get("filled", 1)) else "line"
    return _placed(component, Kind.CURVE, a, 0.0, a["width"], points=points, shape=shape)


def _text(component: str, a: dict[str, Any]) -> Item:
    return _placed(component, Kind.TEXT, a, 0.0, a["width"], labels=(str(a["text"]),))


def _placed(
    component: str, kind: Kind, a: dict[str, Any], length: Track, width: Track, **more: Any
) -> Item:
    """An item at the frame of its visual."""
    (x, y), height = a["r"], first(a["heightShift"])
    red, green, blue = a["color"]
    color = (red, green, blue)
    return Item(component, kind, x, y, a["phi"], length, width, color, height, **more)


_MAKERS: dict[Kind, Callable[[str, dict[str, Any]], Item]] = {
    Kind.SHAPE: _shape,
    Kind.ARROW: partial(_arrow, Kind.ARROW),
    Kind.DOUBLE_ARROW: partial(_arrow, Kind.DOUBLE_ARROW),
    Kind.FRAME: _frame,
    Kind.CURVE: _curve,
    Kind.TEXT: _text,
}


def _offset(r: Any, phi: Track, v: Any) -> tuple[Track, Track]:
    """r + R(phi)*v."""
    c, s = np.cos(phi), np.sin(phi)
    return plain(r[0] + c * v[0] - s * v[1]), plain(r[1] + s * v[0] + c * v[1])
