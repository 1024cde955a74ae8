"""Curves with fewer points, none of which is missed.

Reference: D. H. Douglas, T. K. Peucker, Cartographica 10(2), 1973, 112-122; here the distance
is taken at equal time, since a moving picture runs through its points by time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Vector = NDArray[np.float64]


def thin_polyline(times: Vector, values: Vector, tolerance: float) -> list[int]:
    """Rows, ascending with both ends, from which straight lines give all others.

    `values` has a row for each of `times`; no row is farther than `tolerance` from the line
    between its neighbours that are kept, at its own time.
    """
    import numpy as np

    keep = {0, len(times) - 1}
    stack = [(0, len(times) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        share = ((times[a + 1 : b] - times[a]) / (times[b] - times[a]))[:, None]
        straight = values[a] + share * (values[b] - values[a])
        off = np.linalg.norm(values[a + 1 : b] - straight, axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = a + 1 + worst
            keep.add(middle)
            stack += [(a, middle), (middle, b)]
    return sorted(keep)
