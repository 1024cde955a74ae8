"""Images of a motion, drawn by Pillow several times too large and scaled down, so that slanted
edges show no steps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

from planarc.view.item import Item
from planarc.view.marks.draw import marks_of, visible
from planarc.view.marks.marks import Bar, Disc, Label, Mark, Outline, Paint, Point
from planarc.view.picture.camera import Camera
from planarc.view.picture.motion import Motion, item_at
from planarc.view.picture.svg import DARK_PAPER, PAPER

if TYPE_CHECKING:
    from PIL.Image import Image

#: The factor by which images are drawn too large, in each direction.
_FINER = 3
#: Points of a round corner, a quarter of a circle.
_CORNER = 6

_Color: TypeAlias = tuple[int, ...]
Span: TypeAlias = tuple[float, float]


def render_images(motion: Motion, camera: Camera, dark: bool = False) -> Iterator[Image]:
    """One image a frame, in RGB."""
    from PIL import Image

    fine = camera.larger(_FINER)
    # Whatever lies below the first thing that moves is drawn once.
    first = next((n for n, item in enumerate(motion.items) if _moves(item)), len(motion.items))
    ground = Image.new("RGB", (fine.width, fine.height), _color(DARK_PAPER if dark else PAPER))
    _paint(ground, motion.items[:first], 0, fine, dark)
    image, still = ground.copy(), ground.reduce(_FINER)
    for frame in range(len(motion.times)):
        image.paste(ground)
        spans = _paint(image, motion.items[first:], frame, fine, dark)
        small = still.copy()
        for top, low in _strips(spans, fine.height):
            small.paste(image.reduce(_FINER, (0, top, fine.width, low)), (0, top // _FINER))
        yield small


def _moves(item: Item) -> bool:
    return not all(isinstance(t, (int, float)) for t in item.tracks)


def _paint(
    image: Image, items: Sequence[Item], frame: int, camera: Camera, dark: bool
) -> list[Span]:
    """Draw the items; the rows of pixels that each mark may reach."""
    from PIL import ImageDraw

    pen, spans = ImageDraw.Draw(image, "RGBA"), list[Span]()
    for moving in items:
        if _is_away(moving, frame):
            continue
        item = item_at(moving, frame)
        if visible(item):
            place = _Place(item, camera, spans)
            for mark in marks_of(item, _FINER / camera.scale, dark):
                _DRAW[type(mark)](pen, mark, place)
    return spans


def _strips(spans: Sequence[Span], height: int) -> Iterator[tuple[int, int]]:
    """Rows of pixels, by multiples of `_FINER`, that hold all spans; no row twice."""
    done = 0
    for top, low in sorted(spans):
        if low > done:
            begin = int(max(done, min(top, height))) // _FINER * _FINER
            done = min(height, (int(min(low, height)) // _FINER + 1) * _FINER)
            if begin < done:
                yield begin, done


def _is_away(item: Item, frame: int) -> bool:
    """Whether the item has no place, as most texts of the time: known before it is looked at."""
    return not isinstance(item.x, (int, float)) and math.isnan(item.x[frame])


class _Place:
    """The way from the axes of an item to pixels; notes in `spans` which rows are reached."""

    def __init__(self, item: Item, camera: Camera, spans: list[Span]) -> None:
        self.scale, self.spans = camera.scale, spans
        self.origin = camera(item.x, item.y)  # type: ignore[arg-type]
        self.cos, self.sin = math.cos(item.angle), math.sin(item.angle)

    def __call__(self, points: Sequence[Point], reach: float) -> list[Point]:
        """Points that something is drawn about, as far as `reach` in the item's unit."""
        (ox, oy), c, s = self.origin, self.scale * self.cos, self.scale * self.sin
        found = [(ox + c * x - s * y, oy - s * x - c * y) for x, y in points]
        rows, far = [y for _, y in found], self.scale * reach + _FINER
        self.spans.append((min(rows) - far, max(rows) + far))
        return found


def _outline(pen: Any, mark: Outline, place: _Place) -> None:
    style = mark.style
    points = place(mark.points, style.width / 2)
    if mark.closed and style.fill:
        pen.polygon(points, fill=_color(style.fill))
    if style.line:
        _line(
            pen,
            [*points, points[0]] if mark.closed else points,
            style.line,
            place.scale * style.width,
        )


def _line(pen: Any, points: Sequence[Point], paint: Paint, width: float) -> None:
    color, thick = _color(paint), max(1, round(width))
    pen.line(points, fill=color, width=thick, joint="curve")
    radius = thick / 2
    if radius > 1:
        for x, y in (points[0], points[-1]):
            pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=color)


def _bar(pen: Any, mark: Bar, place: _Place) -> None:
    corners = _rounded(mark.left, mark.right, mark.low, mark.high, mark.radius)
    _outline(pen, Outline(mark.style, corners), place)


def _rounded(left: float, right: float, low: float, high: float, r: float) -> tuple[Point, ...]:
    if not r:
        return (left, low), (right, low), (right, high), (left, high)
    middles = (
        (right - r, high - r),
        (left + r, high - r),
        (left + r, low + r),
        (right - r, low + r),
    )
    return tuple(
        (x + r * math.cos(a), y + r * math.sin(a))
        for quarter, (x, y) in enumerate(middles)
        for a in ((quarter + i / _CORNER) * math.pi / 2 for i in range(_CORNER + 1))
    )


def _disc(pen: Any, mark: Disc, place: _Place) -> None:
    style = mark.style
    ((x, y),) = place([(mark.x, mark.y)], mark.radius + style.width / 2)
    half = place.scale * style.width / 2 if style.line else 0.0
    r = place.scale * mark.radius
    if style.line:
        outer = r + half
        width = max(1, round(2 * half))
        fill = _color(style.fill) if style.fill else None
        box = (x - outer, y - outer, x + outer, y + outer)
        pen.ellipse(box, fill=fill, outline=_color(style.line), width=width)
    elif style.fill:
        pen.ellipse((x - r, y - r, x + r, y + r), fill=_color(style.fill))


def _label(pen: Any, mark: Label, place: _Place) -> None:
    (at,) = place([(mark.x, mark.y)], mark.height)
    size = place.scale * mark.height
    if mark.style.fill and mark.text and size >= 1:
        mask, (left, top) = _letters(mark.text.translate(_PLAIN), round(size))
        pen.bitmap((round(at[0]) + left, round(at[1]) + top), mask, _color(mark.style.fill))


#: Signs that the font of Pillow draws as empty boxes.
_PLAIN = str.maketrans("µ−×→⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "u-x>0123456789-")

_DRAW: dict[type[Mark], Any] = {Outline: _outline, Bar: _bar, Disc: _disc, Label: _label}


@lru_cache(maxsize=256)
def _letters(text: str, size: int) -> tuple[Image, tuple[int, int]]:
    """A text as a mask, the same in all frames; and its corner, from the middle of the text."""
    from PIL import Image, ImageDraw

    font = _font(size)
    left, top, right, low = font.getbbox(text, anchor="mm")
    corner = math.floor(left), math.floor(top)
    mask = Image.new("L", (math.ceil(right) - corner[0], math.ceil(low) - corner[1]))
    ImageDraw.Draw(mask).text((-corner[0], -corner[1]), text, 255, font, anchor="mm")
    return mask, corner


@lru_cache(maxsize=8)
def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size)


@lru_cache(maxsize=256)
def _color(paint: Paint) -> _Color:
    channels = (paint.red, paint.green, paint.blue, 255 * paint.opacity)
    return tuple(min(255, max(0, round(c))) for c in channels)
