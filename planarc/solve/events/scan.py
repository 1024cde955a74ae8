"""Instants at which relations of time alone switch, found before the run.

In:   Truth   of a relation, at many times at once
Out:  the instants, ascending; None where they are more than a run can follow

An integrator looks at relations at the ends of its steps, and a step goes by the states: it
leaps over `sin(1e6*time) > 0`. What depends on time alone can be asked beforehand. The run is
asked at twice as many times again and again, until that finds no more switches; the times lie by
chance, so that no period hides between them. Then the instants are found by halving.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Times: TypeAlias = NDArray[np.float64]
    Truth: TypeAlias = Callable[[Times], NDArray[np.bool_]]

#: Times of the first look, and of the last one.
FEWEST, MOST = 1 << 10, 1 << 22
#: Times that are asked at once.
PIECE = 1 << 16
#: Halvings of the way between two times: as many as a number has digits.
HALVINGS = 60


def switches(truth: Truth, start: float, stop: float) -> Times | None:
    import numpy as np

    count, before = FEWEST, -1
    while count <= MOST:
        times = _times(start, stop, count)
        pieces = np.array_split(times, 1 + count // PIECE)
        now = np.concatenate([truth(piece) for piece in pieces])
        places = np.flatnonzero(now[1:] != now[:-1])
        if len(places) == before:
            found: Times = _halve(truth, times[places], times[places + 1], now[places])
            return found
        count, before = 2 * count, len(places)
    return None


def _times(start: float, stop: float, count: int) -> Times:
    """Both ends, and a time in each of so many parts: by chance, though always the same."""
    import numpy as np

    parts = np.arange(count) + np.random.default_rng(count).random(count)
    return np.concatenate(([start], start + parts * ((stop - start) / count), [stop]))


def _halve(truth: Truth, low: Times, high: Times, first: NDArray[np.bool_]) -> Times:
    import numpy as np

    for _ in range(HALVINGS if len(low) else 0):
        middle = low + (high - low) / 2
        same = truth(middle) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return high
