"""The look of each kind of item: its forms, in its own axes, before its size is known.

In:   Item
Out:  Shape   forms from the lowest to the highest; x along the item's length, y to its left

Example: a beam is one bar from the origin to (L, 0), W wide, with round ends

    Shape((Form("bar", ((ZERO, -0.5*W), (L, 0.5*W)), radius=0.5*W, ...),), needs="lw")

This is all that is known of shapes: `draw` makes the marks of pictures from it, the page draws
the same forms (`page/paint.js`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.evaluate.record import atan2, cos, modulo, sin
from planarc.ir.insight import Track
from planarc.view.item import Item, Kind
from planarc.view.marks.forms import (
    EDGE,
    FAINT,
    HATCH,
    HOLLOW,
    ORIGIN,
    PLAIN,
    Form,
    Place,
    disc,
    line,
    solid,
)
from planarc.view.marks.furniture import ALONG, arrow, corner, frame, ground, ruler, tag
from planarc.view.marks.measure import EXTRA, METRE, PIXEL, THIN, ZERO, L, Measure, W

#: The line of a guide beside its axis, as a share of the width.
RAIL = 0.32
#: The angle between two points of a round corner.
_ARC = math.pi / 10


class Shape(Data, cache_hash=True):
    """Forms of an item; `needs` are the sizes, `l` and `w`, without which none is drawn."""

    forms: tuple[Form, ...]
    needs: str = ""


def shape_of(item: Item) -> Shape:
    """The shape of an item; equal ones are one object."""
    extra = 0.0 if (item.kind, item.shape, item.upright) in _VARY else _first(item.extra)
    return _shape(item.kind, item.shape, item.upright, extra, item.labels, item.points)


def bounded_extra(item: Item) -> Track:
    """The `extra` by which a shape is measured, within its bounds."""
    bounds = _VARY.get((item.kind, item.shape, item.upright))
    if bounds is None:
        return 0.0
    low, high, default = bounds
    value = np.where(np.asarray(item.extra) == 0.0, default, item.extra).clip(low, high)
    return float(value) if value.ndim == 0 else value


def forget_shapes() -> None:
    """Make shapes afresh: numbers that remember are taken for no others."""
    _shape.cache_clear()


@lru_cache(maxsize=1000)
def _shape(
    kind: Kind,
    shape: str,
    upright: bool,
    extra: float,
    labels: tuple[str, ...],
    points: tuple[tuple[float, float], ...],
) -> Shape:
    match kind:
        case Kind.ARROW | Kind.DOUBLE_ARROW:
            return Shape(tuple(arrow(ALONG, 2 if kind is Kind.DOUBLE_ARROW else 1)), "l")
        case Kind.FRAME:
            return Shape(tuple(frame(labels)), "l")
        case Kind.CURVE:
            path = tuple((x * METRE, y * METRE) for x, y in points)
            if shape == "hatch":
                pairs = zip(path[::2], path[1::2], strict=True)
                return Shape(tuple(line(pair, ZERO, 1.0, HATCH) for pair in pairs))
            return Shape((solid("line", *path) if shape else line(path, W, THIN, PLAIN),))
        case Kind.TEXT:
            return Shape((Form("label", ((ZERO, ZERO),), PLAIN, radius=W, text=labels[0]),))
    if shape == "ground":
        return Shape(tuple(ground()))
    if shape == "corner":
        return Shape(tuple(corner(labels, points)))
    if shape == "ruler":
        return Shape(tuple(ruler(labels[0])))
    if shape == "tag":
        return Shape(tuple(tag(labels[0], points)))
    if shape == "note":
        return Shape((Form("label", (ORIGIN,), FAINT, radius=12.0 * PIXEL, text=labels[0]),))
    if shape == "plate":
        return Shape((_plate(points),))
    known = _ENDS if upright else _SIDES
    forms = known.get(shape, known["box"])
    drawn = tuple(forms(extra)) if callable(forms) else forms
    return Shape(tuple(_moved(drawn, *points)), "" if upright else "lw")


def _moved(forms: tuple[Form, ...], *places: tuple[float, float]) -> Iterator[Form]:
    """The forms at a place in metres, if there is one."""
    x, y = places[0] if places else (0.0, 0.0)
    for form in forms:
        shifted = tuple((u + x * METRE, v + y * METRE) for u, v in form.points)
        yield replace(form, points=shifted) if places else form


def _first(value: Track) -> float:
    """The number of turns or teeth; the first one of a number that changes."""
    number = float(value) if isinstance(value, (int, float)) else float(value[0])
    return number if math.isfinite(number) else 0.0


_SIDE = ((ZERO, -0.5 * W), (L, 0.5 * W))
_END = ((-0.5 * W, -0.5 * W), (0.5 * W, 0.5 * W))


def _plate(corners: tuple[tuple[float, float], ...]) -> Form:
    """A flat body through corners in metres, counter-clockwise: rounded by half its width."""
    if len(corners) < 2:
        ((x, y),) = corners or ((0.0, 0.0),)
        return replace(disc(), points=((x * METRE, y * METRE),))
    rim: list[Place] = []
    directions = [
        atan2(b[1] - a[1], b[0] - a[0])
        for a, b in zip(corners, (*corners[1:], corners[0]), strict=True)
    ]
    for i, (x, y) in enumerate(corners):
        first = directions[i - 1] - math.pi / 2
        turn = modulo(directions[i] - directions[i - 1], 2 * math.pi)
        steps = max(1, math.ceil(turn / _ARC))
        for k in range(steps + 1):
            angle = first + turn * k / steps
            across = 0.5 * cos(angle) * W, 0.5 * sin(angle) * W
            rim.append((x * METRE + across[0], y * METRE + across[1]))
    return solid("line", *rim)


def _zigzag(extra: float, low: float = -0.5, high: float = 0.5) -> Iterator[Form]:
    """A spring: as many turns as `extra` says, and straight ends."""
    turns = max(1, round(extra or 5))
    middle, half = (low + high) / 2, (high - low) / 2
    corners = (
        ((0.14 + 0.72 * (i + 0.5) / (2 * turns)) * L, (middle + half * (-1) ** i) * W)
        for i in range(2 * turns)
    )
    ends = ((0.14 * L, middle * W), (0.86 * L, middle * W))
    yield line(((ZERO, middle * W), ends[0], *corners, ends[1], (L, middle * W)), ZERO, 1.7, PLAIN)


def _dashpot(low: float = -0.5, high: float = 0.5) -> Iterator[Form]:
    """A damper: a cup from one end, and the piston of the other in it."""
    middle, half = (low + high) / 2, (high - low) / 2
    top, bottom, axis = (middle + half) * W, (middle - half) * W, middle * W
    left, right = 0.5 * L - 0.9 * half * W, 0.5 * L + 1.3 * half * W
    yield line(((ZERO, axis), (left, axis)), ZERO, 1.7, PLAIN)
    yield line(((right, top), (left, top), (left, bottom), (right, bottom)), ZERO, 1.7, PLAIN)
    inner = 0.5 * L + 0.2 * half * W
    plate = ((inner, axis + 0.7 * half * W), (inner, axis - 0.7 * half * W))
    yield line(plate, ZERO, 2.4, PLAIN)
    yield line(((inner, axis), (L, axis)), ZERO, 1.7, PLAIN)


def _spring_and_damper(extra: float) -> Iterator[Form]:
    """Both side by side between two bars across."""
    for x in (0.06 * L, 0.94 * L):
        yield line(((x, -0.3 * W), (x, 0.3 * W)), ZERO, 1.7, PLAIN)
    for end, x in ((ZERO, 0.06 * L), (L, 0.94 * L)):
        yield line(((end, ZERO), (x, ZERO)), ZERO, 1.7, PLAIN)
    for forms in (_zigzag(extra or 5, 0.1, 0.5), _dashpot(-0.5, -0.1)):
        for form in forms:
            inside = tuple((_between(x), y) for x, y in form.points)
            yield replace(form, points=inside)


def _between(x: Measure) -> Measure:
    """A place along the length, moved between the bars across."""
    parts = dict(x.terms)
    share = parts.pop(0, 0.0)
    return (0.06 + 0.88 * share) * L + Measure(tuple(parts.items()))


def _guide(extra: float) -> Iterator[Form]:
    """A line beside the axis, hatched on its far side, with `extra` hatches."""
    y, deep, count = -RAIL * W, (0.5 - RAIL) * W, max(2, round(extra))
    for i in range(count):
        x = (i + 0.8) / count * L
        yield line(((x, y), (x - deep, y - deep)), ZERO, 1.0, HATCH)
    yield line(((ZERO, y), (L, y)), ZERO, THIN, HATCH)


def _gear_end(extra: float) -> Iterator[Form]:
    """A wheel with as many teeth as `extra` says, and a mark from which its turns are seen."""
    teeth = max(6, round(extra or 20))
    inner = 0.5 * (1 - 3 / (teeth + 6))
    flank = ((0.0, inner), (0.2, inner), (0.35, 0.5), (0.65, 0.5), (0.8, inner))
    rim = (
        ((i + part) * 2 * math.pi / teeth, radius) for i in range(teeth) for part, radius in flank
    )
    yield solid("line", *((r * math.cos(a) * W, r * math.sin(a) * W) for a, r in rim))
    yield line((ORIGIN, (inner * W, ZERO)), ZERO, 1.2, EDGE)


_Forms: TypeAlias = "tuple[Form, ...] | Callable[[float], Iterator[Form]]"
_TOP = 0.5 * EXTRA  # of a cone
_PIN = (disc(), Form("disc", (ORIGIN,), (0.75, 0.75), radius=1 / 6 * W))
_RING = Form("disc", (ORIGIN,), HOLLOW, PLAIN, ZERO, 1.6, radius=0.5 * W)
_RIBS = tuple(math.cos(i * math.pi / 8) / 2 * W for i in range(1, 8))
_BODY = (Form("bar", _SIDE, PLAIN, EDGE, ZERO, 1.2, radius=0.5 * W),)
_BLOCK = ((-0.5 * L, -0.5 * W), (0.5 * L, 0.5 * W))


def _quarter(start: float) -> Form:
    """A quarter of a circle from an angle on."""
    arc = (start + i * math.pi / 16 for i in range(9))
    rim = ((0.5 * math.cos(a) * W, 0.5 * math.sin(a) * W) for a in arc)
    return Form("line", (ORIGIN, *rim), PLAIN)


def _spoke(angle: float) -> Form:
    c, s = 0.42 * math.cos(angle), 0.42 * math.sin(angle)
    return line(((-c * W, -s * W), (c * W, s * W)), ZERO, 1.2, EDGE)


#: Solids seen from their side.
_SIDES: dict[str, _Forms] = {
    "box": (solid("bar", *_SIDE),),
    "beam": _BODY,
    "link": _BODY,
    "cylinder": (solid("bar", *_SIDE),),
    "pipe": (solid("bar", *_SIDE),),
    "sphere": (solid("oval", *_SIDE),),
    "cone": (solid("line", (ZERO, -0.5 * W), (L, -_TOP), (L, _TOP), (ZERO, 0.5 * W)),),
    "gearwheel": (
        solid("bar", *_SIDE),
        *(line(((ZERO, y), (L, y)), ZERO, 1.2, EDGE) for y in _RIBS),
    ),
    "spring": _zigzag,
    "damper": tuple(_dashpot()),
    "springDamper": _spring_and_damper,
    "block": (solid("bar", *_BLOCK),),
    "guide": _guide,
    "barrel": (
        solid("bar", *_SIDE),
        line(((0.94 * L, -0.5 * W), (0.94 * L, 0.5 * W)), ZERO, 1.2, EDGE),
    ),
    "rod": (solid("bar", *_SIDE),),
}
#: The same seen from their end.
_ENDS: dict[str, _Forms] = {
    "box": (solid("bar", *_END),),
    "beam": _PIN,
    "cylinder": _PIN,
    "sphere": (disc(),),
    "cone": (disc(),),
    "pipe": (disc(0.5 * EXTRA),),
    "spring": (disc(0.4 * W),),
    "gearwheel": _gear_end,
    "pin": (_RING,),
    "motor": (
        replace(_RING, line=PLAIN, least=2.2),
        Form("label", (ORIGIN,), PLAIN, radius=0.62 * W, text="M"),
    ),
    "mass": (
        replace(_RING, line=None),
        _quarter(0.0),
        _quarter(math.pi),
        replace(_RING, fill=None, least=1.3),
    ),
    "wheel": (
        disc(),
        replace(disc(), fill=None, radius=0.42 * W),
        _spoke(0.0),
        _spoke(math.pi / 2),
    ),
}
#: Shapes that are measured by `extra`: its bounds, and what stands for 0.
_VARY = {
    (Kind.SHAPE, "cone", False): (0.0, 1.0, 0.0),
    (Kind.SHAPE, "pipe", True): (0.02, 0.98, 0.7),
}
