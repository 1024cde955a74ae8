"""Lengths in a shape, before the size of the item is known.

    l, w    length and width of the item           p    a pixel
    s       the shaft of an arrow: w, at least 1.6 pixels
    h       its head: 4.5*s, at most l; with the sign of l
    x       w times the item's `extra`             i    one metre

Example: 0.36*W - 0.62*L of an item 2 m long and 0.1 m wide is -1.204 m.
"""

from __future__ import annotations

import math

from planarc.core.data import Data

#: Pixels: the least width of what is only a line.
THIN = 1.6
#: The head of an arrow is so many times as long as its shaft is thick.
_HEAD = 4.5
BASIS = "lwpshxi"


class Measure(Data):
    """A sum of multiples of the basis above."""

    parts: tuple[float, ...]

    def __add__(self, other: Measure) -> Measure:
        return Measure(tuple(a + b for a, b in zip(self.parts, other.parts, strict=True)))

    def __sub__(self, other: Measure) -> Measure:
        return self + -other

    def __neg__(self) -> Measure:
        return -1.0 * self

    def __rmul__(self, factor: float) -> Measure:
        return Measure(tuple(factor * a for a in self.parts))

    def of(self, sizes: tuple[float, ...]) -> float:
        """In metres, by the sizes of the basis."""
        return sum(a * size for a, size in zip(self.parts, sizes, strict=True) if a)


L, W, PIXEL, SHAFT, HEAD, EXTRA, METRE = (
    Measure(tuple(float(n == letter) for n in BASIS)) for letter in BASIS
)
ZERO = 0.0 * L


def sizes_of(length: float, width: float, extra: float, pixel: float) -> tuple[float, ...]:
    """The basis in metres."""
    shaft = max(width, THIN * pixel)
    head = math.copysign(min(abs(length), _HEAD * shaft), length)
    return length, width, pixel, shaft, head, width * extra, 1.0
