"""Reads variables of a result by component, with rates and integrals over its rows."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.ir.insight import Track
    from planarc.ir.result import Result

    Vector = NDArray[np.float64]


class Values:
    """The variables of a run. Rows at one time (an event) are never differenced."""

    def __init__(self, result: Result) -> None:
        self.result = result
        self.time = result.time
        self._rates: dict[tuple[int, int], Any] = {}

    def has(self, owner: str, *names: str) -> bool:
        columns = self.result.columns
        return all(f"{owner}.{name}" in columns for name in names)

    def get(self, name: str) -> Track:
        """A number where it never changes; KeyError if there is none."""
        column = self.result.columns[name]
        if column.slot not in self.result.stored:
            return float(column.sign * self.result.constants[column.slot])
        return self.result[name]

    def pair(self, owner: str, name: str) -> tuple[Track, Track]:
        """A vector of the plane, as its two components."""
        return self.get(f"{owner}.{name}[1]"), self.get(f"{owner}.{name}[2]")

    def rate(self, name: str) -> Track:
        """The derivative by differences; equal variables share it."""
        column = self.result.columns[name]
        if column.slot not in self.result.stored:
            return 0.0
        key = column.slot, column.sign
        if key not in self._rates:
            self._rates[key] = rate(self.time, self.result[name])
        known: Track = self._rates[key]
        return known

    def full(self, value: Track) -> Vector:
        """As many rows as the result has."""
        import numpy as np

        return np.full(len(self.time), value) if isinstance(value, float) else value


def rate(time: Vector, values: Vector) -> Vector:
    """d(values)/d(time), second order, on each side of an event by itself."""
    import numpy as np

    found = np.zeros(len(time))
    jumps = np.flatnonzero(np.diff(time) <= 0) + 1
    edges = [0, *jumps.tolist(), len(time)]
    for start, end in pairwise(edges):
        piece = slice(start, end)
        if end - start > 2:
            found[piece] = np.gradient(values[piece], time[piece], edge_order=2)
        elif end - start == 2:
            found[piece] = (values[end - 1] - values[start]) / (time[end - 1] - time[start])
    return found


def integral(time: Vector, values: Vector) -> Vector:
    """The integral from the first row, by cubics through values and slopes (order four)."""
    import numpy as np

    slopes = rate(time, values)
    h = np.diff(time)
    pieces = h / 2 * (values[1:] + values[:-1]) + h**2 / 12 * (slopes[:-1] - slopes[1:])
    return np.concatenate([[0.0], np.cumsum(pieces)])
