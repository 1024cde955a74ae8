"""The type of arrays of numbers, for annotations; imported while running it brings numpy."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Vector: TypeAlias = NDArray[np.float64]  # of any number of axes
