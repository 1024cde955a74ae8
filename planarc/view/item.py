"""A drawn thing, in one form for every kind, so that any viewer can show it."""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from typing import Any

import numpy as np
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.evaluate.record import single
from planarc.ir.insight import Track


class Kind(StrEnum):
    SHAPE = "shape"
    ARROW = "arrow"
    DOUBLE_ARROW = "doubleArrow"
    FRAME = "frame"
    CURVE = "curve"
    TEXT = "text"


class Item(Data):
    """A drawn thing. Lengths in m, angles in rad, colour 0 to 255.

    `shape` is the kind of solid (`box`, `cylinder` ...) of a SHAPE; `upright` shows its end,
    centred at (x, y). An ARROW or DOUBLE_ARROW runs from (x, y) along `angle` for `length`. A
    FRAME has two axes of `length` with `labels`. A CURVE runs through `points`, which are fixed
    in the frame (x, y, angle); it is filled where they close, unless it is a `line`. The corners
    of a `plate` are fixed so, too, and the place of another solid. A TEXT writes `labels[0]` at
    (x, y), `width` high.
    """

    component: str
    kind: Kind
    x: Track
    y: Track
    angle: Track
    length: Track
    width: Track
    color: tuple[Track, Track, Track]
    height: float = 0.0  # what is higher covers what is lower
    shape: str = ""
    upright: bool = False
    extra: Track = 0.0
    labels: tuple[str, ...] = ()
    points: tuple[tuple[float, float], ...] = ()
    parts: tuple[str, ...] = ()  # components that one shape stands for

    @property
    def tracks(self) -> tuple[Track, ...]:
        """All quantities that may change."""
        return (*(getattr(self, name) for name in _TRACKS), *self.color)

    def mapped(self, to: Callable[[Track], Track]) -> Item:
        """The item with another value for each quantity that may change."""
        red, green, blue = map(to, self.color)
        others = {name: to(getattr(self, name)) for name in _TRACKS}
        return replace(self, color=(red, green, blue), **others)


_TRACKS = ("x", "y", "angle", "length", "width", "extra")


def plain(value: Any) -> Track:
    """An array where it has rows, else a Python number."""
    return single(value) if getattr(value, "ndim", 0) == 0 else value


def smooth(angle: Any) -> Track:
    """An angle without jumps of whole turns."""
    value = plain(angle)
    if isinstance(value, float) or not np.all(np.isfinite(value)):
        return value
    if type(value) is np.ndarray and np.abs(value[1:] - value[:-1]).max(initial=0.0) < np.pi:
        return value  # most angles: `unwrap` would take ten times as long to find so
    unwrapped: Track = np.unwrap(value)
    return unwrapped
