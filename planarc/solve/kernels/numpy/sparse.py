"""A block's sparse equations as a dense system of its tears (`planarc.ir.sparse`)."""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.sparse import Head, Row, read_rows
from planarc.solve.kernels.numpy.support import Rows


def dense(rows: Sequence[int], values: Sequence[float]) -> tuple[Sequence[float], Rows]:
    """The residuals where all tears are zero, and their matrix."""
    n, read = rows[Head.TEARS], read_rows(rows)
    units = [[float(j == k) for j in range(n)] for k in range(n)]
    columns = [_residuals(read, values, unit, 0.0) for unit in units]
    return _residuals(read, values, [0.0] * n, 1.0), list(zip(*columns, strict=True))


def _residuals(
    rows: Sequence[Row], values: Sequence[float], tears: Sequence[float], constants: float
) -> list[float]:
    """The residuals at the tears; constants count so many times."""
    x = list(tears)
    for constant, entries in rows:
        x.append(constants * values[constant] + sum(values[v] * x[j] for j, v in entries))
    return x[len(rows) :]
