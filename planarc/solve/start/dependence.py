"""Which conditions on positions follow from others wherever the mechanism can be.

In:   System at consistent start values; rows that it has besides those of its blocks
Out:  the rows that may be left out: the others hold the same positions

The rows of the loops' conditions are dependent in one position only, as where a four-bar lies
flat, or in all of them. So the mechanism is moved along each direction that seems to be free, and
its loops are closed again. Where more rows are independent than before, that place is looked at
instead. Rows are redundant when their rank stays the same all around, and all free directions are
motions; two bars in one line, which meet by accident, leave a direction free in which nothing
moves. Where no direction is free, as many rows are too many everywhere.

Example: a parallelogram with a third bar: four rows of rank three, one may be left out.

Promises:  of rows that may be left out, those besides the blocks' own are preferred, then the
           first; what stays is well conditioned (complete pivoting).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planarc.core.data import Data
from planarc.runtime.differences import central
from planarc.solve.start import newton
from planarc.solve.start.stage import solve_stage
from planarc.solve.start.system import System
from planarc.solve.states.pivoting import choose_columns

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Singular values below this part of the largest count as zero.
RANK = 1e-7
#: Steps of differences, relative to max(1, |x|): of second order, they err by about 1e-10.
_STEP = 1e-5
#: Way by which the mechanism is moved (radians, metres), and the part of it that must be seen.
_MOVE, _SEEN = 0.05, 0.5
#: Moves along all free directions at once, for a place that is like no other.
_WIDE = (0.07, -0.19, 0.31)
#: Rows up to which the one that does not fit is looked for.
_MOST = 60
#: Rounds of going to a better place.
_ROUNDS = 4


class _Place(Data):
    """The slopes of the rows, made comparable, at one point."""

    point: Vector  # of all candidates
    left: Vector  # singular vectors over the rows
    free: Vector  # motions that keep all rows, one in each row
    rank: int


def dependent_rows(system: System, values: Vector, others: Sequence[int]) -> tuple[int, ...]:
    """Numbers of rows of the system, ascending."""
    found: list[int] = []
    for group in _groups(system, values, others):
        found.extend(_dependent(group, values, others))
    return tuple(sorted(found))


def _groups(system: System, values: Vector, others: Sequence[int]) -> list[_Group]:
    """Rows and candidates that belong together: blocks, and rows that tie some of them."""
    found = [
        _Group(system, system.block_rows[i], range(b.first, b.first + len(b.tears)))
        for i, b in system.blocks
        if b.height > 1
    ]
    columns = [c for group in found for c in group.columns]
    for row, slopes in zip(others, _slopes(system, values, others, columns), strict=True):
        tied = {c for c, s in zip(columns, slopes, strict=True) if not abs(s) <= RANK}
        inside = [g for g in found if not tied.isdisjoint(g.columns)]
        rows = [*(r for g in inside for r in g.rows), row]
        found = [g for g in found if g not in inside]
        found.append(_Group(system, rows, sorted(c for g in inside for c in g.columns)))
    return [g for g in found if g.rows]


def _dependent(group: _Group, values: Vector, others: Sequence[int]) -> list[int]:
    best = group.look(values)
    if best is None or best.rank == len(group.rows):
        return []
    places: list[_Place | None] = []
    for _ in range(_ROUNDS):
        places = group.beside(best)
        better = max((p for p in places if p is not None), key=lambda p: p.rank, default=best)
        if better.rank <= best.rank:
            break
        best = better
    dependent = best.left[:, best.rank :].T
    if None in places or not len(dependent):
        return []
    classes = [0 if row in others else 1 for row in group.rows]
    chosen = choose_columns(dependent.tolist(), classes, 2)
    return [group.rows[k] for k in chosen or ()]


class Misfit(Data):
    """A row that is not met, and by how much."""

    row: int
    off: float


def least_misfit(system: System, guess: Vector, others: Sequence[int]) -> Misfit | None:
    """The row that is nearest to being met, where all others are met near a guess. None where
    no single row is too many."""
    blocks = [(i, b) for i, b in system.blocks if b.height > 1]
    rows = [*(r for i, _ in blocks for r in system.block_rows[i]), *others]
    columns = [c for _, b in blocks for c in range(b.first, b.first + len(b.tears))]
    found = []
    for row in rows if len(rows) <= _MOST else ():
        root = solve_stage(system, guess, [r for r in rows if r != row], columns)
        values = system(root.point) if root.converged else None
        if values is not None and abs(values[row]) > RANK:
            found.append(Misfit(row, float(values[row])))
    return min(found, key=lambda f: abs(f.off), default=None)


class _Group(Data):
    system: System
    rows: Sequence[int]
    columns: Sequence[int]

    def look(self, point: Vector) -> _Place | None:
        """None where the rows have no value."""
        import numpy as np

        slopes = _slopes(self.system, point, self.rows, self.columns)
        if not np.all(np.isfinite(slopes)):
            return None
        left, sizes, right = np.linalg.svd(newton.level_rows(slopes)[0])
        rank = int(np.sum(sizes > RANK * np.max(sizes, initial=1.0)))
        return _Place(point, left, right[rank:], rank)

    def beside(self, place: _Place) -> list[_Place | None]:
        """Around a place; None for a direction in which nothing moves."""
        import numpy as np

        wide = np.cos(np.arange(len(place.free))) @ place.free
        found = [p for step in _WIDE if (p := self._moved(place, wide, step)) is not None]
        return [*found, *(self._moved(place, direction, _MOVE) for direction in place.free)]

    def _moved(self, place: _Place, direction: Vector, step: float) -> _Place | None:
        columns = list(self.columns)
        moved = place.point.copy()
        moved[columns] += step * direction
        root = solve_stage(self.system, moved, self.rows, columns)
        seen = self.look(root.point) if root.converged else None
        way = float((root.point - place.point)[columns] @ direction) / step
        return seen if seen is not None and (seen.rank > place.rank or way > _SEEN) else None


def _slopes(system: System, point: Vector, rows: Sequence[int], columns: Sequence[int]) -> Vector:
    """The slopes by central differences; not finite where the rows have no value."""
    import numpy as np

    def moved(z: Vector) -> Vector:
        there = point.copy()
        there[list(columns)] = z
        found = system(there)
        return np.full(len(rows), np.nan) if found is None else found[list(rows)]

    z = point[list(columns)]
    return central(moved, z, [_STEP * max(1.0, abs(v)) for v in z])
