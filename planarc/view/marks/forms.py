"""Marks whose size is not known yet, of which shapes are made.

In:   places and widths as `Measure`: sums of the item's length, its width, pixels and metres
Out:  Form

Example: a thin line along the item, `line((ORIGIN, (L, ZERO)), ZERO, THIN, EDGE)`
"""

from __future__ import annotations

from typing import Literal, TypeAlias

from planarc.core.data import Data
from planarc.view.marks.measure import ZERO, Measure, W

#: The share of black (below 0) or white (above) in the item's colour, on light and dark ground.
Tint: TypeAlias = tuple[float, float]
Place: TypeAlias = tuple[Measure, Measure]

PLAIN: Tint = (0.0, 0.0)
EDGE: Tint = (-0.4, -0.4)
HATCH: Tint = (-0.4, 0.0)
FAINT: Tint = (0.3, -0.1)
INK: Tint = (-0.4, 0.75)
HOLLOW: Tint = (1.0, -0.85)

ORIGIN = (ZERO, ZERO)


class Form(Data):
    """A mark whose size is not known yet.

    line      straight through `points`, `closed` or not
    bar       between two opposite corners, its ends rounded by `radius` and longer by that
    oval      in the rectangle between two corners
    disc      about a point, with a `hole`
    label     a text that stays upright, centred at a point, `radius` high
    """

    kind: Literal["line", "bar", "oval", "disc", "label"]
    points: tuple[Place, ...]
    fill: Tint | None = None
    line: Tint | None = None
    width: Measure = ZERO  # of the line
    least: float = 0.0  # its least width in pixels
    radius: Measure = ZERO
    hole: Measure = ZERO
    closed: bool = True
    text: str = ""


def solid(kind: Literal["line", "bar", "oval", "disc"], *points: Place) -> Form:
    return Form(kind, points, PLAIN, EDGE, ZERO, 1.2)


def line(points: tuple[Place, ...], width: Measure, least: float, tint: Tint) -> Form:
    return Form("line", points, None, tint, width, least, closed=False)


def disc(hole: Measure = ZERO) -> Form:
    return Form("disc", (ORIGIN,), PLAIN, EDGE, ZERO, 1.2, radius=0.5 * W, hole=hole)
