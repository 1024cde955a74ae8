"""Icons as SVG.

In:   Icon   primitives with the y-axis upwards, connectors with their places
Out:  str    one `svg` element, in which every text is escaped

Example: a rectangle with extent {{-90,-60},{90,60}} becomes
    <rect x="-90" y="-60" width="180" height="120" .../>

The y-axis is turned here, number by number, so that texts stay upright.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator
from itertools import pairwise

from planarc.catalog.handbook.pages import Color, Graphic, Icon, Placed, Point

_MARGIN = 10.0
_HEAD = 18.0  # length of the head of an arrow without width
_PIXELS = 4.0  # for a millimetre of line width, at any size of the icon


def icon_svg(icon: Icon, title: str, size: int) -> str:
    """An icon about `size` pixels large; `title` is read out in its place."""
    left, top, width, height = _frame(icon)
    scale = size / max(width, height)
    body = "".join((*map(_graphic, icon.graphics), *map(_placed, icon.connectors)))
    box = " ".join(map(_number, (left, top, width, height)))
    return (
        f'<svg class="icon" role="img" aria-label="{html.escape(title)}" viewBox="{box}" '
        f'width="{_number(width * scale)}" height="{_number(height * scale)}">{body}</svg>'
    )


def _frame(icon: Icon) -> tuple[float, float, float, float]:
    """Left, top, width and height of what is drawn, at least the usual square."""
    points = [(-100.0, -100.0), (100.0, 100.0), *_all_points(icon)]
    xs, ys = [p[0] for p in points], [-p[1] for p in points]
    left, top = min(xs) - _MARGIN, min(ys) - _MARGIN
    return left, top, max(xs) + _MARGIN - left, max(ys) + _MARGIN - top


def _all_points(icon: Icon) -> Iterator[Point]:
    for graphic in icon.graphics:
        yield from graphic.points
    for placed in icon.connectors:
        x, y = placed.origin
        for corner in placed.extent:
            yield corner[0] + x, corner[1] + y


def _graphic(graphic: Graphic) -> str:
    match graphic.shape:
        case "line" if len(graphic.points) > 1:
            heads = "".join(_head(graphic, *ends) for ends in _arrow_ends(graphic))
            if graphic.smooth and len(graphic.points) > 2:
                path = _bent(graphic.points)
                return f'<path d="{path}" {_stroke(graphic)} fill="none"/>{heads}'
            points = _points(graphic.points)
            return f'<polyline points="{points}" {_stroke(graphic)} fill="none"/>{heads}'
        case "polygon" if graphic.smooth and len(graphic.points) > 2:
            return f'<path d="{_bent(graphic.points)}Z" {_paint(graphic)}/>'
        case "polygon" if len(graphic.points) > 1:
            return f'<polygon points="{_points(graphic.points)}" {_paint(graphic)}/>'
        case "rectangle" if len(graphic.points) == 2:
            x, y, w, h = _box(graphic.points)
            round_ = f' rx="{_number(graphic.radius)}"' if graphic.radius else ""
            place = f'x="{x}" y="{y}" width="{w}" height="{h}"{round_}'
            return f"<rect {place} {_paint(graphic)}/>"
        case "ellipse" if len(graphic.points) == 2:
            (x1, y1), (x2, y2) = graphic.points
            place = (
                f'cx="{_number((x1 + x2) / 2)}" cy="{_number(-(y1 + y2) / 2)}" '
                f'rx="{_number(abs(x2 - x1) / 2)}" ry="{_number(abs(y2 - y1) / 2)}"'
            )
            return f"<ellipse {place} {_paint(graphic)}/>"
        case "text" if len(graphic.points) == 2:
            return _text(graphic)
    return ""


def _bent(points: tuple[Point, ...]) -> str:
    """Parabolas from middle to middle of the edges, straight at both ends."""
    middles = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pairwise(points)]
    steps = [f"M{_points(points[:1])} L{_points(middles[:1])}"]
    for corner, end in zip(points[1:-1], middles[1:], strict=True):
        steps.append(f"Q{_points((corner, end))}")
    return " ".join([*steps, f"L{_points(points[-1:])}"])


def _arrow_ends(graphic: Graphic) -> Iterator[tuple[Point, Point]]:
    """The tips of heads, and the points from which their lines come."""
    first, last = graphic.arrows
    if first:
        yield graphic.points[0], graphic.points[1]
    if last:
        yield graphic.points[-1], graphic.points[-2]


def _head(graphic: Graphic, tip: Point, tail: Point) -> str:
    dx, dy = tip[0] - tail[0], tip[1] - tail[1]
    length = math.hypot(dx, dy)
    if length == 0:
        return ""
    ux, uy = dx / length, dy / length
    long = _HEAD * (1 + graphic.width / 2)
    x, y = tip[0] - long * ux, tip[1] - long * uy
    side = long / 3
    corners = (tip, (x - side * uy, y + side * ux), (x + side * uy, y - side * ux))
    return f'<polygon points="{_points(corners)}" fill="{_color(graphic.line)}"/>'


def _text(graphic: Graphic) -> str:
    (x1, y1), (x2, y2) = graphic.points
    # As high as its extent, but no wider: a letter is about 0.55 of its height.
    high = min(abs(y2 - y1) * 0.8, abs(x2 - x1) / (0.55 * max(len(graphic.text), 1)))
    return (
        f'<text x="{_number((x1 + x2) / 2)}" y="{_number(-(y1 + y2) / 2)}" '
        f'font-size="{_number(high)}" text-anchor="middle" dominant-baseline="central" '
        f'fill="{_color(graphic.line)}">{html.escape(graphic.text)}</text>'
    )


def _placed(placed: Placed) -> str:
    """A connector's icon, whose own square is shown in its extent (which may mirror it)."""
    (x1, y1), (x2, y2) = placed.extent
    x, y = placed.origin
    turned = f"translate({_number(x)} {_number(-y)}) rotate({_number(-placed.rotation)}) "
    steps = (
        f"{turned if x or y or placed.rotation else ''}"
        f"translate({_number((x1 + x2) / 2)} {_number(-(y1 + y2) / 2)}) "
        f"scale({_number((x2 - x1) / 200)} {_number((y2 - y1) / 200)})"
    )
    # A connector's own name would be too small to be read.
    body = "".join(_graphic(g) for g in placed.graphics if g.shape != "text")
    return f'<g transform="{steps}">{body}</g>'


def _paint(graphic: Graphic) -> str:
    fill = "none" if graphic.fill is None else _color(graphic.fill)
    return f'{_stroke(graphic)} fill="{fill}"'


def _stroke(graphic: Graphic) -> str:
    dashes = ' stroke-dasharray="8 6"' if graphic.dashed else ""
    width = _number(graphic.width * _PIXELS)
    thick = "" if width == "1" else f' stroke-width="{width}"'  # as without
    return f'stroke="{_color(graphic.line)}"{thick}{dashes}'


def _box(points: tuple[Point, ...]) -> tuple[str, str, str, str]:
    (x1, y1), (x2, y2) = points
    numbers = (min(x1, x2), min(-y1, -y2), abs(x2 - x1), abs(y2 - y1))
    x, y, w, h = map(_number, numbers)
    return x, y, w, h


def _points(points: Iterable[Point]) -> str:
    return " ".join(f"{_number(x)},{_number(-y)}" for x, y in points)


def _color(color: Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*(min(max(c, 0), 255) for c in color))


def _number(value: float) -> str:
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
