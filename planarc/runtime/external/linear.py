"""Linear algebra of full matrices, by LAPACK.

Arguments come in one row: sizes first, then matrices row by row. Results are one row, too; the last
of them is LAPACK's `info`, 0 where all went well, but for what stands behind it.

Reference: E. Anderson et al., LAPACK Users' Guide, 3rd edition, SIAM 1999.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class _Row:
    """A row of arguments, taken one after the other."""

    def __init__(self, numbers: Sequence[float]) -> None:
        self._numbers, self._place = numbers, 0

    def whole(self) -> int:
        return int(self.number())

    def number(self) -> float:
        self._place += 1
        return self._numbers[self._place - 1]

    def array(self, *shape: int) -> NDArray[np.float64]:
        import numpy as np

        begin, count = self._place, int(np.prod(shape))
        self._place += count
        return np.array(self._numbers[begin : self._place], dtype=float).reshape(shape)


def _lapack() -> Any:
    from scipy.linalg import lapack

    return lapack


def _told(*results: Any) -> list[float]:
    """Results as one row."""
    return [*_numbers(results)]


def _numbers(results: Sequence[Any]) -> Iterator[float]:
    import numpy as np

    for result in results:
        yield from np.asarray(result, dtype=float).ravel().tolist()


def solution(arguments: Sequence[float]) -> list[float]:
    """n, m, A (n x n), B (n x m): X with A*X = B."""
    row = _Row(arguments)
    n, m = row.whole(), row.whole()
    *_, x, info = _lapack().dgesv(row.array(n, n), row.array(n, m))
    return _told(x, info)


def factors(arguments: Sequence[float]) -> list[float]:
    """m, n, A (m x n): L and U in one matrix, and which row each was exchanged with, from 1 on."""
    row = _Row(arguments)
    lu, pivots, info = _lapack().dgetrf(row.array(row.whole(), row.whole()))
    return _told(lu, pivots + 1, info)


def solution_by_factors(arguments: Sequence[float]) -> list[float]:
    """n, m, what `factors` gives, B (n x m): X with A*X = B."""
    row = _Row(arguments)
    n, m = row.whole(), row.whole()
    lu, pivots = row.array(n, n), row.array(n)
    x, info = _lapack().dgetrs(lu, pivots.astype(int) - 1, row.array(n, m))
    return _told(x, info)


def inverse_by_factors(arguments: Sequence[float]) -> list[float]:
    """n, what `factors` gives: the inverse."""
    row = _Row(arguments)
    n = row.whole()
    lu, pivots = row.array(n, n), row.array(n)
    inverse, info = _lapack().dgetri(lu, pivots.astype(int) - 1)
    return _told(inverse, info)


def reciprocal_condition(arguments: Sequence[float]) -> list[float]:
    """n, the factors of A (n x n), the norm of A, whether that is of rows: about 1/condition."""
    row = _Row(arguments)
    n = row.whole()
    lu, norm, of_rows = row.array(n, n), row.number(), row.number()
    return _told(*_lapack().dgecon(lu, norm, norm="I" if of_rows else "1"))


def cholesky(arguments: Sequence[float]) -> list[float]:
    """n, whether the upper triangle counts, A (n x n): its triangular factor, and the rest of A."""
    row = _Row(arguments)
    n, upper = row.whole(), row.number()
    return _told(*_lapack().dpotrf(row.array(n, n), lower=0 if upper else 1, clean=0))


def least_squares(arguments: Sequence[float]) -> list[float]:
    """m, n, k, the least reciprocal condition, A (m x n), B (m x k): X (max(m, n) x k), of which
    the first n rows make A*X - B as small as may be, and the rank behind `info`."""
    import numpy as np

    row = _Row(arguments)
    m, n, k, least = row.whole(), row.whole(), row.whole(), row.number()
    a, b = row.array(m, n), row.array(m, k)
    longest = np.zeros((max(m, n), k))
    longest[:m] = b
    room = max(m * n + 3 * n + 1, 2 * min(m, n) + k) + 64 * (n + 1)
    _, x, _, rank, info = _lapack().dgelsy(a, longest, np.zeros(n, dtype=int), least, room)
    return _told(x, info, rank)


def constrained_least_squares(arguments: Sequence[float]) -> list[float]:
    """m, n, p, A (m x n), c (m), B (p x n), d (p): the x with B*x = d that makes A*x - c as small
    as may be."""
    row = _Row(arguments)
    m, n, p = row.whole(), row.whole(), row.whole()
    a, c, b, d = row.array(m, n), row.array(m), row.array(p, n), row.array(p)
    *_, x, info = _lapack().dgglse(a, b, c, d)
    return _told(x, info)


def eigenvalues(arguments: Sequence[float]) -> list[float]:
    """n, A (n x n): real and imaginary parts, and the right vectors as columns: those of a pair of
    complex values are the real and the imaginary part of its first one."""
    row = _Row(arguments)
    n = row.whole()
    real, imaginary, _, vectors, info = _lapack().dgeev(row.array(n, n), compute_vl=0)
    return _told(real, imaginary, vectors, info)


def general_eigenvalues(arguments: Sequence[float]) -> list[float]:
    """n, A, B (n x n): real and imaginary parts of alpha, beta, left and right vectors, where
    A*v = alpha/beta*B*v."""
    row = _Row(arguments)
    n = row.whole()
    real, imaginary, beta, left, right, _, info = _lapack().dggev(row.array(n, n), row.array(n, n))
    return _told(real, imaginary, beta, left, right, info)


def singular_values(arguments: Sequence[float]) -> list[float]:
    """m, n, A (m x n): sigma, U, V^T with A = U*diag(sigma)*V^T."""
    row = _Row(arguments)
    u, sigma, vt, info = _lapack().dgesvd(row.array(row.whole(), row.whole()))
    return _told(sigma, u, vt, info)


def orthogonal_factors(arguments: Sequence[float]) -> list[float]:
    """m, n, whether columns are exchanged, A (m x n): Q and R in one matrix, the factors of the
    reflections, which column went where, from 1 on."""
    row = _Row(arguments)
    m, n, exchanged = row.whole(), row.whole(), row.number()
    a = row.array(m, n)
    if exchanged:
        qr, pivots, tau, _, info = _lapack().dgeqp3(a)
    else:
        qr, tau, _, info = _lapack().dgeqrf(a)
        pivots = range(1, n + 1)
    return _told(qr, tau, pivots, info)


def orthogonal(arguments: Sequence[float]) -> list[float]:
    """m, n, what `orthogonal_factors` gives of n <= m columns: the columns of Q."""
    row = _Row(arguments)
    m, n = row.whole(), row.whole()
    q, _, info = _lapack().dorgqr(row.array(m, n), row.array(n))
    return _told(q, info)


def schur(arguments: Sequence[float]) -> list[float]:
    """n, A (n x n): T, Z with A = Z*T*Z^T, real and imaginary parts of the eigenvalues."""
    row = _Row(arguments)
    n = row.whole()
    t, _, real, imaginary, z, _, info = _lapack().dgees(lambda *_: None, row.array(n, n))
    return _told(t, z, real, imaginary, info)


def reordered_schur(arguments: Sequence[float]) -> list[float]:
    """n, which eigenvalues come first (n truths), T, Z (n x n): T and Z so ordered, real and
    imaginary parts of the eigenvalues, how many were chosen, and two bounds that are not asked for.
    """
    import numpy as np

    row = _Row(arguments)
    n = row.whole()
    chosen, t, z = row.array(n), row.array(n, n), row.array(n, n)
    asked = np.asarray(chosen != 0, dtype=np.intc)
    t, z, real, imaginary, count, s, sep, info = _lapack().dtrsen(
        asked, t, z, job="N", lwork=max(1, n), liwork=1
    )
    return _told(t, z, real, imaginary, count, s, sep, info)


def sylvester(arguments: Sequence[float]) -> list[float]:
    """m, n, whether A and whether B is transposed, the sign s, A (m x m), B (n x n), C (m x n): X
    with A*X + s*X*B = scale*C, of triangular A and B, and `scale`."""
    row = _Row(arguments)
    m, n = row.whole(), row.whole()
    turned = ["T" if row.number() else "N" for _ in range(2)]
    sign = row.whole()
    a, b, c = row.array(m, m), row.array(n, n), row.array(m, n)
    x, scale, info = _lapack().dtrsyl(a, b, c, trana=turned[0], tranb=turned[1], isgn=sign)
    return _told(x, scale, info)
