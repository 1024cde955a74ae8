"""The types of arrays, of any number of axes; imported while running they bring numpy."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

Array: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[Any]]
Vector: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]
