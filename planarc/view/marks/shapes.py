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
from typing import Literal, TypeAlias

import numpy as np

from planarc.core.data import Data
from planarc.ir.insight import Track
from planarc.view.item import Item, Kind
from planarc.view.marks.measure import (
    EXTRA,
    HEAD,
    METRE,
    PIXEL,
    SHAFT,
    THIN,
    ZERO,
    L,
    Measure,
    W,
)

#: The share of black (below 0) or white (above) in the item's colour, on light and dark ground.
Tint: TypeAlias = tuple[float, float]
Place: TypeAlias = tuple[Measure, Measure]

_PLAIN: Tint = (0.0, 0.0)
_EDGE: Tint = (-0.4, -0.4)
_HATCH: Tint = (-0.4, 0.0)


class Form(Data):
    """A mark whose size is not known yet.

    line      straight through `points`, `closed` or not
    bar       between two opposite corners, its ends rounded by `radius` and longer by that
    tube      the same, light on one side and dark on the other
    oval      in the rectangle between two corners
    disc      about a point, with a `hole`
    label     a text that stays upright, centred at a point, `radius` high
    """

    kind: Literal["line", "bar", "tube", "oval", "disc", "label"]
    points: tuple[Place, ...]
    fill: Tint | None = None
    line: Tint | None = None
    width: Measure = ZERO  # of the line
    least: float = 0.0  # its least width in pixels
    radius: Measure = ZERO
    hole: Measure = ZERO
    closed: bool = True
    text: str = ""


class Shape(Data):
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
            return Shape(tuple(_arrow(_ALONG, 2 if kind is Kind.DOUBLE_ARROW else 1)), "l")
        case Kind.FRAME:
            return Shape(tuple(_frame(labels)), "l")
        case Kind.CURVE:
            path = tuple((x * METRE, y * METRE) for x, y in points)
            return Shape((_line(path, W, THIN, _PLAIN),))
        case Kind.TEXT:
            return Shape((Form("label", ((ZERO, ZERO),), _PLAIN, radius=W, text=labels[0]),))
    if shape == "ground":
        return Shape(tuple(_ground()))
    known = _ENDS if upright else _SIDES
    forms = known.get(shape, known["box"])
    return Shape(tuple(forms(extra)) if callable(forms) else forms, "" if upright else "lw")


def _first(value: Track) -> float:
    """The number of turns or teeth; the first one of a number that changes."""
    number = float(value) if isinstance(value, (int, float)) else float(value[0])
    return number if math.isfinite(number) else 0.0


def _solid(kind: Literal["line", "bar", "tube", "oval", "disc"], *points: Place) -> Form:
    return Form(kind, points, _PLAIN, _EDGE, ZERO, 1.2)


def _line(points: tuple[Place, ...], width: Measure, least: float, line: Tint) -> Form:
    return Form("line", points, None, line, width, least, closed=False)


_ORIGIN = (ZERO, ZERO)
_SIDE = ((ZERO, -0.5 * W), (L, 0.5 * W))
_END = ((-0.5 * W, -0.5 * W), (0.5 * W, 0.5 * W))


def _round(hole: Measure = ZERO) -> Form:
    return Form("disc", (_ORIGIN,), _PLAIN, _EDGE, ZERO, 1.2, radius=0.5 * W, hole=hole)


def _spring(extra: float) -> Iterator[Form]:
    """A coil from its side: a wave of as many turns as `extra` says, and straight ends."""
    turns = max(1, round(extra or 5))
    steps = 16 * turns
    wave = (
        ((0.1 + 0.8 * i / steps) * L, math.sin(2 * math.pi * turns * i / steps) / 2 * W)
        for i in range(steps + 1)
    )
    yield _line((_ORIGIN, *wave, (L, ZERO)), 1 / 14 * W, 1.8, _PLAIN)


def _gear_end(extra: float) -> Iterator[Form]:
    """A wheel with as many teeth as `extra` says, and a mark from which its turns are seen."""
    teeth = max(6, round(extra or 20))
    inner = 0.5 * (1 - 3 / (teeth + 6))
    flank = ((0.0, inner), (0.2, inner), (0.35, 0.5), (0.65, 0.5), (0.8, inner))
    rim = (
        ((i + part) * 2 * math.pi / teeth, radius) for i in range(teeth) for part, radius in flank
    )
    yield _solid("line", *((r * math.cos(a) * W, r * math.sin(a) * W) for a, r in rim))
    yield _line((_ORIGIN, (inner * W, ZERO)), ZERO, 1.2, _EDGE)


# What is no solid ---------------------------------------------------------------------------


def _ground() -> Iterator[Form]:
    """A bearing: a triangle under its point, on hatched ground."""
    base = -0.62 * L
    yield _solid("line", _ORIGIN, (0.36 * W, base), (-0.36 * W, base))
    yield _line(((-0.55 * W, base), (0.55 * W, base)), ZERO, THIN, _HATCH)
    for i in range(6):
        x = (0.2 * i - 0.5) * W
        yield _line(((x, base), (x - 0.13 * W, base - 0.25 * L)), ZERO, 1.1, _HATCH)


_ALONG = (1.0, 0.0)


def _arrow(along: tuple[float, float], heads: int) -> Iterator[Form]:
    """An arrow from the origin by L along a unit vector."""
    u, v = along

    def at(forward: Measure, left: Measure = ZERO) -> Place:
        return u * forward - v * left, v * forward + u * left

    yield _line((_ORIGIN, at(L - 0.8 * HEAD)), SHAFT, 0.0, _PLAIN)
    for i in range(heads):
        tip = L - 0.8 * i * HEAD
        corners = at(tip), at(tip - HEAD, 0.36 * HEAD), at(tip - HEAD, -0.36 * HEAD)
        yield Form("line", corners, _PLAIN)


def _frame(labels: tuple[str, ...]) -> Iterator[Form]:
    for i, (u, v) in enumerate((_ALONG, (0.0, 1.0))):
        yield from _arrow((u, v), 1)
        reach = L + 10.0 * PIXEL
        if i < len(labels):
            place = (u * reach, v * reach)
            yield Form("label", (place,), _PLAIN, radius=13.0 * PIXEL, text=labels[i])


_Forms: TypeAlias = "tuple[Form, ...] | Callable[[float], Iterator[Form]]"
_TOP = 0.5 * EXTRA  # of a cone
_PIN = (_round(), Form("disc", (_ORIGIN,), (0.75, 0.75), radius=1 / 6 * W))
_RIBS = tuple(math.cos(i * math.pi / 8) / 2 * W for i in range(1, 8))
#: Solids seen from their side.
_SIDES: dict[str, _Forms] = {
    "box": (_solid("bar", *_SIDE),),
    "beam": (Form("bar", _SIDE, _PLAIN, _EDGE, ZERO, 1.2, radius=0.5 * W),),
    "cylinder": (_solid("tube", *_SIDE),),
    "pipe": (_solid("tube", *_SIDE),),
    "sphere": (_solid("oval", *_SIDE),),
    "cone": (_solid("line", (ZERO, -0.5 * W), (L, -_TOP), (L, _TOP), (ZERO, 0.5 * W)),),
    "gearwheel": (
        _solid("bar", *_SIDE),
        *(_line(((ZERO, y), (L, y)), ZERO, 1.2, _EDGE) for y in _RIBS),
    ),
    "spring": _spring,
}
#: The same seen from their end.
_ENDS: dict[str, _Forms] = {
    "box": (_solid("bar", *_END),),
    "beam": _PIN,
    "cylinder": _PIN,
    "sphere": (_round(),),
    "cone": (_round(),),
    "pipe": (_round(0.5 * EXTRA),),
    "spring": (_round(0.4 * W),),
    "gearwheel": _gear_end,
}
#: Shapes that are measured by `extra`: its bounds, and what stands for 0.
_VARY = {
    (Kind.SHAPE, "cone", False): (0.0, 1.0, 0.0),
    (Kind.SHAPE, "pipe", True): (0.02, 0.98, 0.7),
}
