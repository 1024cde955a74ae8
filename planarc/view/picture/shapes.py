"""The marks of an item, in its own axes: metres, x along its length, y to its left.

`pixel` is the size of a pixel in metres, so that lines stay as thin at any scale. The look
is that of the page (`report/paint.js`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from planarc.core.data import Data
from planarc.view.picture.marks import Bar, Disc, Label, Mark, Outline, Paint, Point, Style
from planarc.view.scene import Item, Kind

_LINE = 1.2  # pixels: the edge of a solid
_THIN = 1.6  # pixels: the least width of what is only a line


class _Look(Data):
    """An item at an instant, with its paints."""

    length: float
    width: float
    extra: float
    paint: Paint
    pixel: float

    @property
    def solid(self) -> Style:
        return Style(self.paint, self.paint.towards(0.0, 0.4), _LINE * self.pixel)

    def plain(self, paint: Paint) -> Style:
        return Style(paint)

    def line(self, width: float, paint: Paint | None = None) -> Style:
        return Style(None, paint or self.paint, max(width, _THIN * self.pixel))


def marks_of(item: Item, pixel: float, dark: bool = False) -> tuple[Mark, ...]:
    """Of an item at an instant, from the lowest to the highest; none if it has no size yet."""
    paint = Paint(*(float(c) for c in item.color))
    look = _Look(
        float(item.length),
        float(item.width),
        float(item.extra),
        paint.on_dark() if dark else paint,
        pixel,
    )
    return tuple(_MAKERS[item.kind](item, look))


def visible(item: Item) -> bool:
    """Whether an item at an instant has a place at all."""
    return all(math.isfinite(v) for v in (item.x, item.y, item.angle, item.length, item.width))


def _shape(item: Item, look: _Look) -> Iterator[Mark]:
    if item.shape == "ground":
        yield from _ground(look)
    elif item.upright:
        yield from _ENDS.get(item.shape, _box_end)(look)
    elif look.length and look.width:
        yield from _SIDES.get(item.shape, _box)(look)


# Solids seen from their side ----------------------------------------------------------------


def _box(look: _Look, round_by: float = 0.0) -> Iterator[Mark]:
    left, right = sorted((0.0, look.length))
    half = look.width / 2
    yield Bar(look.solid, left - round_by, right + round_by, -half, half, round_by)


def _beam(look: _Look) -> Iterator[Mark]:
    yield from _box(look, abs(look.width) / 2)


def _cylinder(look: _Look) -> Iterator[Mark]:
    """Round things are light on one side and dark on the other."""
    yield from _box(look)
    left, right = sorted((0.0, look.length))
    w, paint = look.width, look.paint
    for share, low, high in ((-0.25, -0.46, -0.22), (0.3, 0.02, 0.26)):
        shade = paint.towards(255.0 if share > 0 else 0.0, abs(share))
        yield Bar(look.plain(shade), left, right, low * w, high * w)


def _sphere(look: _Look) -> Iterator[Mark]:
    a, b = abs(look.length) / 2, abs(look.width) / 2
    if math.isclose(a, b, rel_tol=1e-6):
        yield Disc(look.solid, look.length / 2, 0.0, a)
        return
    points = ((look.length / 2 + a * c, b * s) for c, s in _circle(48))
    yield Outline(look.solid, tuple(points))


def _cone(look: _Look) -> Iterator[Mark]:
    half, top = look.width / 2, look.width / 2 * min(1.0, max(0.0, look.extra))
    l = look.length  # noqa: E741
    yield Outline(look.solid, ((0.0, -half), (l, -top), (l, top), (0.0, half)))


def _gear_side(look: _Look) -> Iterator[Mark]:
    yield from _box(look)
    for i in range(1, 8):
        y = look.width / 2 * math.cos(i * math.pi / 8)
        yield Outline(
            Style(None, look.solid.line, look.solid.width), ((0.0, y), (look.length, y)), False
        )


def _spring(look: _Look) -> Iterator[Mark]:
    """A coil from its side: a wave of as many turns as `extra` says, and straight ends."""
    turns = max(1, round(look.extra or 5))
    steps = 16 * turns
    wave = (
        (
            look.length * (0.1 + 0.8 * i / steps),
            look.width / 2 * math.sin(2 * math.pi * turns * i / steps),
        )
        for i in range(steps + 1)
    )
    points = ((0.0, 0.0), *wave, (look.length, 0.0))
    yield Outline(look.line(max(1.8 * look.pixel, look.width / 14)), points, False)


# Solids seen from their end -----------------------------------------------------------------


def _box_end(look: _Look) -> Iterator[Mark]:
    half = look.width / 2
    yield Bar(look.solid, -half, half, -half, half)


def _disc_end(look: _Look) -> Iterator[Mark]:
    yield Disc(look.solid, 0.0, 0.0, abs(look.width) / 2)


def _pin(look: _Look) -> Iterator[Mark]:
    yield from _disc_end(look)
    yield Disc(look.plain(look.paint.towards(255.0, 0.75)), 0.0, 0.0, abs(look.width) / 6)


def _ring(look: _Look, hole: float) -> Iterator[Mark]:
    outer = abs(look.width) / 2
    inner = outer * min(0.98, max(0.02, hole))
    edge = Style(None, look.solid.line, look.solid.width)
    yield Disc(Style(None, look.paint, outer - inner), 0.0, 0.0, (outer + inner) / 2)
    yield Disc(edge, 0.0, 0.0, outer)
    yield Disc(edge, 0.0, 0.0, inner)


def _pipe_end(look: _Look) -> Iterator[Mark]:
    yield from _ring(look, look.extra or 0.7)


def _spring_end(look: _Look) -> Iterator[Mark]:
    yield from _ring(look, 0.8)


def _gear_end(look: _Look) -> Iterator[Mark]:
    """A wheel with as many teeth as `extra` says, and a mark from which its turns are seen."""
    teeth = max(6, round(look.extra or 20))
    outer = look.width / 2
    inner = outer * (1 - 3 / (teeth + 6))
    flank = ((0.0, inner), (0.2, inner), (0.35, outer), (0.65, outer), (0.8, inner))
    points = []
    for i in range(teeth):
        for part, radius in flank:
            angle = (i + part) * 2 * math.pi / teeth
            points.append((radius * math.cos(angle), radius * math.sin(angle)))
    yield Outline(look.solid, tuple(points))
    yield Outline(Style(None, look.solid.line, look.solid.width), ((0.0, 0.0), (inner, 0.0)), False)


# What is no solid ---------------------------------------------------------------------------


def _ground(look: _Look) -> Iterator[Mark]:
    """A bearing: a triangle under its point, on hatched ground."""
    w, base = look.width, -0.62 * look.length
    yield Outline(look.solid, ((0.0, 0.0), (0.36 * w, base), (-0.36 * w, base)))
    edge = look.paint.towards(0.0, 0.4)
    yield Outline(look.line(0.0, edge), ((-0.55 * w, base), (0.55 * w, base)), False)
    for i in range(6):
        x = w * (0.2 * i - 0.5)
        end = (x - 0.13 * w, base - 0.25 * look.length)
        yield Outline(Style(None, edge, 1.1 * look.pixel), ((x, base), end), False)


def _head(look: _Look, tip: Point, back: Point, size: float) -> Outline:
    """The head of an arrow whose tip points away from `back`, a unit vector."""
    (x, y), (u, v) = tip, back
    low = x + size * u - 0.36 * size * v, y + size * v + 0.36 * size * u
    high = x + size * u + 0.36 * size * v, y + size * v - 0.36 * size * u
    return Outline(look.plain(look.paint), (tip, low, high))


def _arrow(look: _Look, along: Point, heads: int) -> Iterator[Mark]:
    """From the origin by `length` along a unit vector."""
    if not look.length:
        return
    shaft = max(look.width, _THIN * look.pixel)
    size = min(abs(look.length), 4.5 * shaft)
    u, v = along
    back = (-u, -v) if look.length > 0 else (u, v)

    def on(distance: float) -> Point:
        """The point so far behind the tip."""
        return look.length * u + distance * back[0], look.length * v + distance * back[1]

    yield Outline(look.line(shaft), ((0.0, 0.0), on(0.8 * size)), False)
    for i in range(heads):
        yield _head(look, on(0.8 * size * i), back, size)


def _frame(item: Item, look: _Look) -> Iterator[Mark]:
    for i, along in enumerate(((1.0, 0.0), (0.0, 1.0))):
        yield from _arrow(look, along, 1)
        reach = look.length + 10 * look.pixel
        if i < len(item.labels):
            place = along[0] * reach, along[1] * reach
            yield Label(look.plain(look.paint), *place, 13 * look.pixel, item.labels[i])


def _single(item: Item, look: _Look) -> Iterator[Mark]:
    yield from _arrow(look, (1.0, 0.0), 1)


def _double(item: Item, look: _Look) -> Iterator[Mark]:
    yield from _arrow(look, (1.0, 0.0), 2)


def _curve(item: Item, look: _Look) -> Iterator[Mark]:
    yield Outline(look.line(look.width), item.points, False)


def _text(item: Item, look: _Look) -> Iterator[Mark]:
    yield Label(look.plain(look.paint), 0.0, 0.0, look.width, item.labels[0])


def _circle(count: int) -> Iterator[Point]:
    for i in range(count):
        yield math.cos(2 * math.pi * i / count), math.sin(2 * math.pi * i / count)


_SIDES: dict[str, Callable[[_Look], Iterator[Mark]]] = {
    "box": _box,
    "beam": _beam,
    "cylinder": _cylinder,
    "pipe": _cylinder,
    "sphere": _sphere,
    "cone": _cone,
    "gearwheel": _gear_side,
    "spring": _spring,
}
_ENDS: dict[str, Callable[[_Look], Iterator[Mark]]] = {
    "box": _box_end,
    "beam": _pin,
    "cylinder": _pin,
    "sphere": _disc_end,
    "cone": _disc_end,
    "pipe": _pipe_end,
    "spring": _spring_end,
    "gearwheel": _gear_end,
}
_MAKERS: dict[Kind, Callable[[Item, _Look], Iterator[Mark]]] = {
    Kind.SHAPE: _shape,
    Kind.ARROW: _single,
    Kind.DOUBLE_ARROW: _double,
    Kind.FRAME: _frame,
    Kind.CURVE: _curve,
    Kind.TEXT: _text,
}
