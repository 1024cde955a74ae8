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

#: The least width (pixels) of what is only a line.
THIN = 1.6
#: The length of an arrow's head over the thickness of its shaft.
_HEAD = 4.5
BASIS = "lwpshxi"


class Measure(Data):
    """A sum of multiples of the basis above, by their places in it."""

    terms: tuple[tuple[int, float], ...]

    def __add__(self, other: Measure) -> Measure:
        parts = dict(self.terms)
        for place, factor in other.terms:
            parts[place] = parts.get(place, 0.0) + factor
        return Measure(tuple((p, f) for p, f in sorted(parts.items()) if f))

    def __sub__(self, other: Measure) -> Measure:
        return self + -other

    def __neg__(self) -> Measure:
        return -1.0 * self

    def __rmul__(self, factor: float) -> Measure:
        return Measure(tuple((p, factor * f) for p, f in self.terms if factor))

    def of(self, sizes: tuple[float, ...]) -> float:
        """The length in metres, by the sizes of the basis."""
        total = 0.0
        for place, factor in self.terms:
            total += factor * sizes[place]
        return total


ZERO = Measure(())
L, W, PIXEL, SHAFT, HEAD, EXTRA, METRE = (Measure(((p, 1.0),)) for p in range(len(BASIS)))


def sizes_of(length: float, width: float, extra: float, pixel: float) -> tuple[float, ...]:
    """The basis in metres."""
    shaft = max(width, THIN * pixel)
    head = math.copysign(min(abs(length), _HEAD * shaft), length)
    return length, width, pixel, shaft, head, width * extra, 1.0
