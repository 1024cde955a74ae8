"""A drawn thing, in one form for every kind, so that any viewer can show it."""

from __future__ import annotations

from enum import StrEnum
from typing import TYPE_CHECKING, TypeAlias

from planarc.core.data import Data

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

#: A number, or one number for each row of the result.
Track: TypeAlias = "float | NDArray[np.float64]"


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
    in the frame (x, y, angle). A TEXT writes `labels[0]` at (x, y), `width` high.
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
