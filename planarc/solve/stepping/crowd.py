"""Bodies of a crowd that are near each other, and where they would touch.

In:   the places of circles and round bars
Out:  Meetings   for each end of a bar, or centre of a circle, near another body: the point, the
                 normal and the gap; in the order of the bodies, not of the search

    near    by a tree of the middles: only neighbours are compared, so that the cost grows with
            the number of bodies, not of pairs; what is much larger than most, such as a wall, is
            compared with all
    meet    an end and the nearest point of the other's middle line; ends of one bar and the middle
            line of the other, and the other way round

Example: circles of radius 0.5 with centres (0, 0) and (0, 1.1): normal (0, 1), gap 0.1.

Exported models do the same in the same order (`instance.crowd`): a heap magnifies the last
digit. So lengths are square roots, and sines have the same bits everywhere (`angles`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from planarc.core.data import Data
from planarc.solve.stepping.angles import sine_and_cosine
from planarc.solve.stepping.ports import Column, Ports

if TYPE_CHECKING:
    from planarc.core.arrays import Array, Vector

#: What is so many times larger than most is large.
LARGE = 4.0


class Meetings(Data):
    """`first` has the end that touches, `second` the line that is touched; both are members."""

    first: Array
    second: Array
    end: Array  # which of the two ends
    at: Vector  # points of the first one, in world, in m
    normal: Vector  # from the second one to the first
    gap: Vector


class Crowd:
    """The bodies of one `Crowd`."""

    def __init__(self, ports: Ports, members: Sequence[int]) -> None:
        self._ports = ports
        self.members = chosen = [ports.members[i] for i in members]

        def column(*names: str) -> Column:
            read = [m.read[name] for name in names for m in chosen]
            return Column(ports.program, read, ports.read)

        self._place, self._form = column("x", "y", "phi"), column("radius", "e", "mu")
        self._ends = column("from_x", "from_y", "to_x", "to_y")
        self.port = np.array([m.port for m in chosen], dtype=np.int64)
        self._still = ports.groups[self.port] < 0
        self._begun = False

    def begin(self) -> None:
        """Read what does not change in a run."""
        if self._begun:
            return
        w, n = self._ports.kernel.w, len(self.port)
        self.radius, self.e, self.mu = self._form(w).reshape(3, n)
        self._lines = self._ends(w).reshape(4, n)
        length = length_of(*(self._lines[2:] - self._lines[:2]))
        self._bar, self.bound = length > 0, length / 2 + self.radius
        self._near = Near(self.bound)
        self._begun = True

    def find(self, reach: float) -> Meetings:
        """All that may touch, where gaps are below `reach`."""
        w, n = self._ports.kernel.w, len(self.port)
        x, y, phi = self._place(w).reshape(3, n)
        self.origin = np.stack([x, y], axis=1)
        s, c = sine_and_cosine(phi)
        u, v = self._lines[::2], self._lines[1::2]
        ends = np.stack([x + c * u - s * v, y + s * u + c * v], axis=2)  # (2, n, 2)
        i, j = np.sort(self._near.pairs((ends[0] + ends[1]) / 2, reach)).T
        differ = (self.port[i] != self.port[j]) & ~(self._still[i] & self._still[j])
        return self._meet(ends, i[differ], j[differ], reach)

    def _meet(self, ends: Vector, i: Array, j: Array, reach: float) -> Meetings:
        i, j = np.where(self._bar[i], j, i), np.where(self._bar[i], i, j)  # circles first
        bars = self._bar[i]
        both = (i[bars], j[bars])
        first = np.concatenate([i, both[0], both[1], both[1]])
        second = np.concatenate([j, both[1], both[0], both[0]])
        end = np.repeat([0, 1, 0, 1], [len(i), *[len(both[0])] * 3])
        p, a = ends[end, first], ends[0, second]
        line, way = ends[1, second] - a, p - a
        square = line[:, 0] * line[:, 0] + line[:, 1] * line[:, 1]
        along = way[:, 0] * line[:, 0] + way[:, 1] * line[:, 1]
        along = np.clip(along / np.where(square > 0, square, 1.0), 0.0, 1.0)
        off = p - (a + along[:, None] * line)
        distance = length_of(off[:, 0], off[:, 1])
        gap = distance - self.radius[first] - self.radius[second]
        kept = np.flatnonzero((gap < reach) & (distance > 0))
        kept = kept[np.argsort((first * len(self.port) + second)[kept] * 2 + end[kept])]
        first, second = first[kept], second[kept]
        normal = off[kept] / distance[kept, None]
        at = p[kept] - self.radius[first, None] * normal
        return Meetings(first, second, end[kept], at, normal, gap[kept])


def length_of(x: Vector, y: Vector) -> Vector:
    found: Vector = np.sqrt(x * x + y * y)
    return found


class Near:
    """Pairs of circles that are near each other; their radii are `bounds`."""

    def __init__(self, bounds: Vector) -> None:
        self._bounds = bounds
        large = bounds > LARGE * np.median(bounds)
        self._small = np.flatnonzero(~large)
        self._most = 2 * float(bounds[self._small].max())
        pairs = [np.zeros((0, 2), dtype=np.int64)]
        for k in np.flatnonzero(large).tolist():
            others = np.flatnonzero(~large | (np.arange(len(bounds)) > k))
            pairs.append(np.stack([np.full(len(others), k), others], axis=1))
        self._large = np.concatenate(pairs)

    def pairs(self, middles: Vector, reach: float) -> Array:
        """Pairs (i, j) of circles about `middles` that are less than `reach` apart."""
        from scipy.spatial import cKDTree

        tree = cKDTree(middles[self._small])
        found = tree.query_pairs(self._most + reach, output_type="ndarray")
        found = np.concatenate([self._small[found], self._large])
        (x, y), (i, j) = middles.T, found.T
        apart = self._bounds[i] + self._bounds[j] + reach
        close: Array = found[(x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 < apart**2]
        return close
