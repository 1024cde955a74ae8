"""The marks of a picture, each in the axes of the item that it belongs to.

Lengths in metres, y upwards; colours 0 to 255 with an opacity 0 to 1. A printer of marks
(`svg`, `raster`) knows nothing of mechanisms.
"""

from __future__ import annotations

from typing import TypeAlias

from planarc.core.data import Data

Point: TypeAlias = tuple[float, float]


class Paint(Data):
    red: float
    green: float
    blue: float
    opacity: float = 1.0

    def towards(self, other: float, share: float) -> Paint:
        """The paint mixed with black (0) or white (255)."""
        red, green, blue = (c + (other - c) * share for c in (self.red, self.green, self.blue))
        return Paint(red, green, blue, self.opacity)

    def on_dark(self) -> Paint:
        """The paint for a dark ground, where dark colours would be lost."""
        bright = 0.3 * self.red + 0.59 * self.green + 0.11 * self.blue
        return self.towards(255.0, (155.0 - bright) / 255.0) if bright < 150.0 else self

    @property
    def code(self) -> str:
        """The paint as `#rrggbb`."""
        channels = (min(255, max(0, round(c))) for c in (self.red, self.green, self.blue))
        return "#" + "".join(f"{c:02x}" for c in channels)


class Style(Data):
    """Fill and line of a mark; `width` is that of the line."""

    fill: Paint | None = None
    line: Paint | None = None
    width: float = 0.0


class Outline(Data):
    """Straight lines through points, closed or not; joints and ends of lines are round."""

    style: Style
    points: tuple[Point, ...]
    closed: bool = True


class Bar(Data):
    """A rectangle around the x-axis, from `left` to `right`, its corners rounded by `radius`.

    `low` and `high` are its lower and upper edge.
    """

    style: Style
    left: float
    right: float
    low: float
    high: float
    radius: float = 0.0


class Disc(Data):
    style: Style
    x: float
    y: float
    radius: float


class Label(Data):
    """A text that stays upright, centred at (x, y)."""

    style: Style
    x: float
    y: float
    height: float
    text: str


Mark: TypeAlias = Outline | Bar | Disc | Label
