"""The types of arrays, of any number of axes; imported while running they bring numpy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

Array: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[Any]]
Vector: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]


def spread(count: int, most: int) -> Array:
    """At most `most` (2 or more) of the rows 0 ... count - 1, spread evenly, with both ends."""
    return np.linspace(0, count - 1, min(count, most)).astype(int)


def taken(w: Sequence[float], slots: Array) -> Vector:
    """The values of slots, as an array."""
    if isinstance(w, np.ndarray):
        return w.take(slots)
    return np.array([w[slot] for slot in slots.tolist()], dtype=np.float64)
