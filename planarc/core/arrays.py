"""The types of arrays, of any number of axes; imported while running they bring numpy."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

Array: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[Any]]
Vector: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]


def spread(count: int, most: int) -> Array:
    """At most `most` (2 or more) of the rows 0 ... count - 1, spread evenly, with both ends."""
    return np.linspace(0, count - 1, min(count, most)).astype(int)
