"""Derivatives of whole runs by a parameter, from runs with a little more and a little less of it.

In:   Model, present values of the parameters, RunOptions
Out:  Compared    the motion, and its derivatives, at the rows of a run

At an event a row holds the values after it. Where an event moves with the parameter, the runs that
are compared stand on different sides of it at rows close by, and their difference would be the
jump over the change. Such rows are known by what happened before them, other things in each run,
and by values that are not those of a smooth function. The derivative there is one-sided, from
the runs that are on the side of the present one, and NaN where there are none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.options import RunOptions
from planarc.solve.recorder import NEAR
from planarc.solve.settings import resolve

if TYPE_CHECKING:
    from planarc.api.model import Model
    from planarc.api.result import Result

#: Relative changes of a parameter where whole runs are compared, and their tolerance.
STEP, TOLERANCE = 1e-4, 1e-11
#: Values of three runs are those of a smooth function where their second difference is below
#: this part of the first one, or that part of the largest value.
BEND, NOISE = 1e-2, 1e-8


class Compared(Data):
    time: Vector
    names: tuple[str, ...]  # of the variables
    motion: Vector  # rows, variables
    data: Vector  # rows, variables, parameters


class _Rows(Data):
    """Values at the rows asked for, and what happened up to each: events, and their causes."""

    values: Vector  # rows, variables
    happened: Vector  # rows, 2

    def beside(self, other: _Rows) -> NDArray[np.bool_]:
        """The rows, of the shape (rows, 1), at which both stand between the same events."""
        same: NDArray[np.bool_] = np.all(self.happened == other.happened, axis=1, keepdims=True)
        return same


def compare_runs(model: Model, present: dict[str, float], options: RunOptions) -> Compared:
    grid = resolve(model.program, options).grid
    options = replace(options, tolerance=min(TOLERANCE, options.tolerance or 1.0))
    names = tuple(c.name for c in model.program.columns if not c.name.startswith("$"))

    def run(changed: dict[str, float]) -> _Rows:
        result = model.run(replace(options, values={**options.values, **changed}))
        return _rows(result, names, grid)

    base = run({})
    found = [
        _derivative(base, lambda by, n=n, v=v: run({n: v + by}), STEP * (abs(v) or 1.0))  # type: ignore[misc]
        for n, v in present.items()
    ]
    return Compared(grid, names, base.values, np.stack(found, axis=-1))


def _rows(result: Result, names: tuple[str, ...], grid: Vector) -> _Rows:
    time = result.time
    until = grid + 2 * NEAR * np.min(np.diff(grid), initial=np.inf)
    at = np.maximum(np.searchsorted(time, until, "right") - 1, 0)
    events = np.concatenate([[0], np.cumsum(np.diff(time) == 0)])[at]
    causes = np.concatenate([[0], np.cumsum([len(e.causes) for e in result.events])])
    past = causes[np.searchsorted([e.time for e in result.events], until, "right")]
    return _Rows(np.array([result[n][at] for n in names]).T, np.stack([events, past], axis=1))


def _derivative(base: _Rows, displaced: Callable[[float], _Rows], h: float) -> Vector:
    above, below = displaced(h), displaced(-h)
    found: Vector = (above.values - below.values) / (2 * h)
    apart = ~(base.beside(above) & base.beside(below))
    doubtful = apart & ~_smooth(below.values, base.values, above.values)
    found[doubtful] = np.nan
    for near, by in ((above, h), (below, -h)):
        wanted = doubtful & base.beside(near) & np.isnan(found)
        if wanted.any():
            found[wanted] = _one_sided(base, near, displaced(2 * by), by)[wanted]
    return found


def _smooth(below: Vector, middle: Vector, above: Vector) -> NDArray[np.bool_]:
    size = np.max(np.abs(middle), axis=0, initial=0.0)
    bend = np.abs(above - 2 * middle + below)
    smooth: NDArray[np.bool_] = bend <= BEND * np.abs(above - below) + NOISE * size
    return smooth


def _one_sided(base: _Rows, near: _Rows, far: _Rows, by: float) -> Vector:
    """Of second order in the change where the third run, too, is on this side of events."""
    first = (near.values - base.values) / by
    second = (4 * near.values - 3 * base.values - far.values) / (2 * by)
    found: Vector = np.where(base.beside(far), second, first)
    return found
