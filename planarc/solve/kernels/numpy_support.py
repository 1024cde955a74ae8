"""What the generated NumPy text calls: functions on Python floats, and small solves.

Python floats and `math` are three times faster than NumPy scalars, so NumPy itself
only solves systems above `SMALLEST_ARRAY` unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from planarc.ir.newton import SINGULAR

SMALLEST_ARRAY = 7


def sign(x: float) -> float:
    return float((x > 0.0) - (x < 0.0))


def floor(x: float) -> float:
    return float(math.floor(x))


def ceil(x: float) -> float:
    return float(math.ceil(x))


def div(x: float, y: float) -> float:
    return float(math.trunc(x / y))


def mod(x: float, y: float) -> float:
    return x - math.floor(x / y) * y


def rem(x: float, y: float) -> float:
    return x - math.trunc(x / y) * y


def safe(function: Callable[..., float], *args: float) -> float:
    """The value, or nan outside the domain: for formulas whose use is conditional."""
    try:
        return function(*args)
    except (ArithmeticError, ValueError):
        return math.nan


def safe_div(a: float, b: float) -> float:
    return a / b if b != 0.0 else math.nan


_MATH = "sin cos tan asin acos atan atan2 sinh cosh tanh exp log log10 sqrt pow inf nan"

#: The only names that the generated text can reach.
NAMESPACE: dict[str, Any] = {
    "__builtins__": {},
    **{name: getattr(math, name) for name in _MATH.split()},
    **{f.__name__: f for f in (abs, min, max, sign, floor, ceil, div, mod, rem, safe, safe_div)},
    "range": range,
}

Rows = Sequence[Sequence[float]]


def solve_linear(matrix: Rows, right: Sequence[float]) -> list[float] | None:
    """x with matrix*x = right, or None where the matrix is singular."""
    n = len(right)
    if n == 1:
        pivot = matrix[0][0]
        return [right[0] / pivot] if pivot != 0.0 and pivot - pivot == 0.0 else None
    if n < SMALLEST_ARRAY:
        return _eliminate(matrix, right)
    return _solve_array(matrix, right)


def _eliminate(matrix: Rows, right: Sequence[float]) -> list[float] | None:
    """Gaussian elimination; pivots are compared relative to the size of their rows."""
    rows = [[*row, r] for row, r in zip(matrix, right, strict=True)]
    n = len(rows)
    sizes = [max(map(abs, row[:n])) for row in rows]
    if not all(0.0 < s < math.inf for s in sizes):
        return None
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(rows[i][k]) / sizes[i])
        if not abs(rows[best][k]) > SINGULAR * sizes[best]:
            return None
        rows[k], rows[best] = rows[best], rows[k]
        sizes[k], sizes[best] = sizes[best], sizes[k]
        pivot_row = rows[k]
        for row in rows[k + 1 :]:
            if row[k] != 0.0:
                factor = row[k] / pivot_row[k]
                for j in range(k + 1, n + 1):
                    row[j] -= factor * pivot_row[j]
    x = [0.0] * n
    for k in reversed(range(n)):
        row = rows[k]
        total = row[n]
        for j in range(k + 1, n):
            total -= row[j] * x[j]
        x[k] = total / row[k]
    return x


def _solve_array(matrix: Rows, right: Sequence[float]) -> list[float] | None:
    import warnings

    import numpy as np
    from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

    a = np.array(matrix, dtype=float)
    sizes = np.abs(a).max(axis=1)
    if not (np.isfinite(sizes).all() and (sizes > 0).all()):
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", LinAlgWarning)
        lu, pivots = lu_factor(a / sizes[:, None], overwrite_a=True, check_finite=False)
    if np.abs(np.diagonal(lu)).min() <= SINGULAR:
        return None
    x: list[float] = lu_solve((lu, pivots), np.array(right) / sizes, check_finite=False).tolist()
    return x
