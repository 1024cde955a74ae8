"""Some of the conditions at the start, solved for some of the candidates.

In:   System, a guess of all candidates, the rows and columns that take part
Out:  Root    its point is of all candidates

Example: the rows of position solved for the positions that are not held.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from planarc.solve.start import newton
from planarc.solve.start.system import System

if TYPE_CHECKING:
    from planarc.core.arrays import Vector


def solve_stage(
    system: System, u: Vector, rows: Sequence[int], columns: Sequence[int]
) -> newton.Root:
    """A root of some rows as a function of some candidates."""
    point = system.root(u, rows, columns)
    if point is not None and (residuals := system(point)) is not None:
        return newton.Root(point, residuals[list(rows)], True)
    part = Part(system, u, rows, columns)
    root = newton.search(part, u[list(columns)])
    return newton.Root(part.point(root.point), root.residuals, root.converged)


class Part:
    """Some rows as a function of some candidates, the others being as in `u`; and how far
    variables are from where they are pulled to, with a factor."""

    def __init__(
        self,
        system: System,
        u: Vector,
        rows: Sequence[int],
        columns: Sequence[int],
        pulls: Mapping[int, float] | None = None,
        factor: float = 1.0,
    ) -> None:
        import numpy as np

        self._system, self._full = system, u.copy()
        self._columns = list(columns)
        self._slots = tuple(pulls or ())
        self._rows = [*rows, *range(system.rows, system.rows + len(self._slots))]
        self._wanted = np.array(list((pulls or {}).values()))
        self._first, self._factor = len(rows), factor

    def point(self, z: Vector) -> Vector:
        """All candidates."""
        self._full[self._columns] = z
        return self._full.copy()

    def __call__(self, x: Vector) -> Vector | None:
        self._full[self._columns] = x
        found = self._system.values(self._full, self._slots)
        if found is None:
            return None
        values: Vector = found[self._rows]
        if self._slots:
            pulled = values[self._first :]
            pulled -= self._wanted
            pulled *= self._factor
        return values

    def root(self, x: Vector) -> newton.Root | None:
        """The root near a guess, where machine code finds it."""
        self._full[self._columns] = x
        if self._slots:
            return None
        point = self._system.root(self._full, self._rows, self._columns)
        if point is None or (residuals := self._system(point)) is None:
            return None
        return newton.Root(point[self._columns], residuals[self._rows], True)

    def slopes(self, x: Vector) -> Vector | None:
        self._full[self._columns] = x
        found = self._system.slopes(self._full, self._columns, self._slots)
        if found is None:
            return None
        slopes: Vector = found[self._rows]
        if self._slots:
            slopes[self._first :] *= self._factor
        return slopes
