"""What outlines are made of, in the units of a drawing, as complex numbers x + i*y."""

from __future__ import annotations

from collections.abc import Callable
from math import atan

import numpy as np

from planarc.core.data import Data
from planarc.core.source import Span


class Piece(Data):
    """A line or a curve from `at(0)` to `at(1)`; `bend` is the most that |at''| is."""

    at: Callable[[float], complex]
    bend: float = 0.0


class Outline(Data):
    """Pieces, one after the other; `name` is what the drawing calls it, and may be empty."""

    name: str
    pieces: tuple[Piece, ...]
    closed: bool
    span: Span | None = None


class Drawing(Data):
    """The outlines of a file; `metre` is its unit in m, None where it does not say."""

    outlines: tuple[Outline, ...]
    metre: float | None


def line(a: complex, b: complex) -> Piece:
    return Piece(lambda t: a + (b - a) * t)


def arc(a: complex, b: complex, bulge: float) -> Piece:
    """An arc of a circle from a to b; `bulge` is the tangent of a quarter of its angle, positive
    counter-clockwise."""
    if bulge == 0 or a == b:
        return line(a, b)
    angle = 4 * atan(bulge)
    centre = (a + b) / 2 + (b - a) * 1j * (1 - bulge**2) / (4 * bulge)
    return Piece(
        lambda t: complex(centre + (a - centre) * np.exp(1j * angle * t)),
        abs(a - centre) * angle**2,
    )
