"""What the generated NumPy text calls: functions on Python floats, and small solves.

Python floats and `math` are three times faster than NumPy scalars, so arrays appear
only where LAPACK solves a system of three or more unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from planarc.evaluate.written import NAMES
from planarc.ir.newton import SINGULAR
from planarc.runtime import elementary, external
from planarc.runtime.elimination import clear


def safe(function: Callable[..., float], *args: float) -> float:
    """The value, or nan outside the domain: for formulas whose use is conditional."""
    try:
        return function(*args)
    except (ArithmeticError, ValueError):
        return math.nan


def safe_div(a: float, b: float) -> float:
    return a / b if b != 0.0 else math.nan


def namespace() -> dict[str, Any]:
    """The only names that the generated text can reach."""
    return {
        "__builtins__": {},
        **NAMES,
        **{name: row.value for name, row in elementary.TABLE.items()},
        "pow": math.pow,
        "safe": safe,
        "safe_div": safe_div,
        "external": external.number,
    }


Rows = Sequence[Sequence[float]]


def solve_linear(
    matrix: Rows, right: Sequence[float], lapack: bool = True
) -> Sequence[float] | None:
    """x with matrix*x = right, or None where the matrix is singular. Importing LAPACK takes
    longer than eliminating some systems without it."""
    n = len(right)
    if n == 1:
        pivot = matrix[0][0]
        return (right[0] / pivot,) if pivot != 0.0 and pivot - pivot == 0.0 else None
    if n == 2:
        return solve_pair(*matrix[0], *matrix[1], *right)
    if not lapack:
        return _eliminate(matrix, right)
    factors, _, x, info = _lapack()(matrix, right)
    if info == 0:
        pivots = list(map(abs, factors.diagonal().tolist()))
        if min(pivots) > SINGULAR * max(pivots):
            found: list[float] = x.tolist()
            return found
    return _eliminate(matrix, right)


def solve_pair(
    a: float, b: float, c: float, d: float, p: float, q: float
) -> tuple[float, float] | None:
    """x, y with a*x + b*y = p and c*x + d*y = q: as `_eliminate`, for the most frequent case."""
    first, second = abs(a), abs(c)
    e, f = abs(b), abs(d)
    if not first > e:
        first = e
    if not second > f:
        second = f
    if abs(a) * second < abs(c) * first:
        a, b, p, first, c, d, q, second = c, d, q, second, a, b, p, first
    if not SINGULAR * first < abs(a) < math.inf:
        return None
    factor = c / a
    d -= factor * b
    if not SINGULAR * second < abs(d) < math.inf:
        return None
    y = (q - factor * p) / d
    return (p - b * y) / a, y


@cache
def _lapack() -> Callable[..., Any]:
    """LAPACK's solver itself: NumPy's way to it takes twice the time for small systems."""
    from scipy.linalg.lapack import dgesv

    return dgesv  # type: ignore[no-any-return]


def _eliminate(matrix: Rows, right: Sequence[float]) -> list[float] | None:
    """Gaussian elimination; pivots are compared relative to the size of their rows.

    Slow but careful: for matrices that looked singular, their rows in different units.
    """
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
        clear(rows[k + 1 :], rows[k], k, range(k + 1, n + 1))
    x = [0.0] * n
    for k in reversed(range(n)):
        row = rows[k]
        total = row[n]
        for j in range(k + 1, n):
            total -= row[j] * x[j]
        x[k] = total / row[k]
    return x
