"""The marks of an item at an instant, as pictures draw them.

`pixel` is the size of a pixel in metres, so that lines stay as thin at any scale.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

from msgspec.structs import replace

from planarc.view.item import Item, Kind
from planarc.view.marks.forms import Form, Tint
from planarc.view.marks.marks import Bar, Disc, Label, Mark, Outline, Paint, Style
from planarc.view.marks.measure import sizes_of
from planarc.view.marks.shapes import bounded_extra, shape_of

_OVAL = 48  # points of an oval that is no circle
_ARROWS = (Kind.ARROW, Kind.DOUBLE_ARROW)
_LEAST = 2.0  # pixels of an arrow that can be seen as one


def marks_of(item: Item, pixel: float, dark: bool = False) -> tuple[Mark, ...]:
    """The marks of an item, from the lowest to the highest; none if it has no size yet."""
    return _marks(
        replace(item, component="", parts=(), x=0.0, y=0.0, angle=0.0, height=0.0), pixel, dark
    )


@lru_cache(maxsize=2000)  # most things only move
def _marks(item: Item, pixel: float, dark: bool) -> tuple[Mark, ...]:
    length, width = float(item.length), float(item.width)
    shape = shape_of(item)
    if ("l" in shape.needs and not length) or ("w" in shape.needs and not width):
        return ()
    if item.kind in _ARROWS and abs(length) < _LEAST * pixel:
        return ()
    paint = Paint(*(float(c) for c in item.color))
    artist = _Artist(
        sizes_of(length, width, float(bounded_extra(item)), pixel),
        paint.on_dark() if dark else paint,
        dark,
    )
    return tuple(mark for form in shape.forms for mark in artist.marks(form))


def visible(item: Item) -> bool:
    """True for an item that has a place at an instant."""
    return all(math.isfinite(v) for v in (item.x, item.y, item.angle, item.length, item.width))


class _Artist:
    """Turns forms into marks, for one item at one instant."""

    def __init__(self, sizes: tuple[float, ...], paint: Paint, dark: bool) -> None:
        self._sizes, self._paint, self._dark = sizes, paint, dark
        self._paints: dict[float, Paint] = {0.0: paint}

    def marks(self, form: Form) -> Iterator[Mark]:
        points = tuple((x.of(self._sizes), y.of(self._sizes)) for x, y in form.points)
        style = self._style(form)
        radius = abs(form.radius.of(self._sizes))
        match form.kind:
            case "line":
                yield Outline(style, points, form.closed)
            case "label":
                yield Label(style, *points[0], form.radius.of(self._sizes), form.text)
            case "disc":
                yield from _disc(style, *points[0], radius, abs(form.hole.of(self._sizes)))
            case _:
                (left, right), (low, high) = (sorted(v) for v in zip(*points, strict=True))
                yield from self._box(form, style, left - radius, right + radius, low, high, radius)

    def _box(
        self, form: Form, style: Style, left: float, right: float, low: float, high: float, r: float
    ) -> Iterator[Mark]:
        if form.kind == "oval":
            yield from _oval(style, left, right, low, high)
            return
        yield Bar(style, left, right, low, high, r)

    def _tinted(self, tint: Tint | None) -> Paint | None:
        if tint is None:
            return None
        share = tint[self._dark]
        if share not in self._paints:
            self._paints[share] = self._paint.towards(255.0 if share > 0 else 0.0, abs(share))
        return self._paints[share]

    def _style(self, form: Form) -> Style:
        _, _, pixel, *_ = self._sizes
        width = max(form.width.of(self._sizes), form.least * pixel)
        return Style(self._tinted(form.fill), self._tinted(form.line), width if form.line else 0.0)


def _disc(style: Style, x: float, y: float, outer: float, inner: float) -> Iterator[Mark]:
    if not inner:
        yield Disc(style, x, y, outer)
        return
    edge = Style(None, style.line, style.width)
    yield Disc(Style(None, style.fill, outer - inner), x, y, (outer + inner) / 2)
    yield Disc(edge, x, y, outer)
    yield Disc(edge, x, y, inner)


def _oval(style: Style, left: float, right: float, low: float, high: float) -> Iterator[Mark]:
    a, b, x, y = (right - left) / 2, (high - low) / 2, (left + right) / 2, (low + high) / 2
    if math.isclose(a, b, rel_tol=1e-6):
        yield Disc(style, x, y, a)
        return
    turns = (2 * math.pi * i / _OVAL for i in range(_OVAL))
    yield Outline(style, tuple((x + a * math.cos(t), y + b * math.sin(t)) for t in turns))
