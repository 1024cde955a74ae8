"""Jacobians of functions by differences: a column for each argument that is moved.

    one_sided   one evaluation a column, errors of about the root of a rounding error
    central     two or four, of order two or four, for smooth functions

`steps` are how far each argument is moved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planarc.core.arrays import Vector


def one_sided(
    f: Callable[[Vector], Any],
    x: Vector | Sequence[float],
    steps: Sequence[float],
    here: Any = None,
    *,
    either: bool = False,
) -> Vector | None:
    """A Jacobian by differences to one side; None where f gives None. `here` is f(x), where that is
    known; with `either`, only where it does on both sides."""
    import numpy as np

    x = np.array(x, dtype=float)
    here = f(x) if here is None else here
    if here is None:
        return None
    jacobian = np.empty((len(here), len(x)))
    for j, step in enumerate(steps):
        for h in (step, -step) if either else (step,):
            moved = x.copy()
            moved[j] += h
            beside = f(moved)
            if beside is not None:
                jacobian[:, j] = (np.asarray(beside) - np.asarray(here)) / (moved[j] - x[j])
                break
        else:
            return None
    return jacobian


def central(
    f: Callable[[Vector], Vector], x: Vector, steps: Sequence[float], order: int = 2
) -> Vector:
    import numpy as np

    columns = []
    for j, step in enumerate(steps):
        h = np.zeros(len(x))
        h[j] = step
        near = f(x + h) - f(x - h)
        if order == 2:
            columns.append(near / (2 * step))
        else:
            columns.append((8 * near - (f(x + 2 * h) - f(x - 2 * h))) / (12 * step))
    return np.array(columns).T if columns else np.zeros((len(f(x)), 0))
