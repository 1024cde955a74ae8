"""Linear algebra of full matrices, beside NumPy's and beside what defines it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
import scipy.linalg as sl
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from planarc.runtime import external
from planarc.runtime.external import linear

Array = NDArray[np.float64]
GENERATOR = np.random.default_rng(7)
#: Neither square nor with an eigenvalue alone.
WIDE, HIGH = GENERATOR.normal(size=(3, 5)), GENERATOR.normal(size=(5, 3))
SQUARE = GENERATOR.normal(size=(4, 4))
ROUND = np.array([[0.0, -2.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 3.0]])


def row(*parts: Any) -> list[float]:
    return [x for part in parts for x in np.asarray(part, dtype=float).ravel().tolist()]


def taken(found: Sequence[float], *shapes: tuple[int, ...]) -> list[Array]:
    """Results of these shapes; all numbers are used up."""
    sizes = [int(np.prod(shape)) for shape in shapes]
    assert sum(sizes) == len(found)
    parts = np.split(np.array(found), np.cumsum(sizes)[:-1])
    return [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]


def swapped(pivots: Array, n: int) -> Array:
    """The rows of the unit matrix as pivots, counted from 1, exchange them."""
    rows = np.eye(n)
    for i, k in enumerate(pivots.astype(int) - 1):
        rows[[i, k]] = rows[[k, i]]
    return rows


@settings(max_examples=50, deadline=None)
@given(n=st.integers(1, 6), m=st.integers(1, 3), seed=st.integers(0, 10**6))
def test_solutions_and_factors(n: int, m: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    a, b = generator.normal(size=(n, n)) + 3 * np.eye(n), generator.normal(size=(n, m))
    x, info = taken(linear.solution(row(n, m, a, b)), (n, m), ())
    assert info == 0
    assert np.allclose(a @ x, b)
    lu, pivots, info = taken(linear.factors(row(n, n, a)), (n, n), (n,), ())
    lower, upper = np.tril(lu, -1) + np.eye(n), np.triu(lu)
    assert info == 0
    assert np.allclose(lower @ upper, swapped(pivots, n) @ a)
    x2, info = taken(linear.solution_by_factors(row(n, m, lu, pivots, b)), (n, m), ())
    assert np.allclose(x2, x)
    inverse, info = taken(linear.inverse_by_factors(row(n, lu, pivots)), (n, n), ())
    assert np.allclose(inverse @ a, np.eye(n))


def test_what_has_no_solution() -> None:
    singular = [[1, 2], [2, 4]]
    assert linear.solution(row(2, 1, singular, [1, 2]))[-1] > 0
    assert linear.factors(row(2, 2, singular))[-1] > 0
    assert linear.cholesky(row(2, True, [[1, 2], [2, 1]]))[-1] > 0


def test_conditions_are_about_right() -> None:
    lu, *_ = taken(linear.factors(row(4, 4, SQUARE)), (4, 4), (4,), ())
    for of_rows, order in ((False, 1), (True, np.inf)):
        norm = np.linalg.norm(SQUARE, order)
        found, info = linear.reciprocal_condition(row(4, lu, norm, of_rows))
        assert info == 0
        assert found == pytest.approx(1 / np.linalg.cond(SQUARE, order), rel=0.5)


@pytest.mark.parametrize("upper", [False, True])
def test_triangles_of_positive_matrices(upper: bool) -> None:
    a = SQUARE @ SQUARE.T
    found, info = taken(linear.cholesky(row(4, upper, a)), (4, 4), ())
    factor = np.triu(found).T if upper else np.tril(found)
    assert info == 0
    assert np.allclose(factor @ factor.T, a)


@pytest.mark.parametrize("a", [WIDE, HIGH], ids=["wide", "high"])
def test_least_squares(a: Array) -> None:
    m, n = a.shape
    b = GENERATOR.normal(size=(m, 2))
    found, info, rank = taken(linear.least_squares(row(m, n, 2, 0.0, a, b)), (max(m, n), 2), (), ())
    assert (info, rank) == (0, 3)
    assert np.allclose(found[:n], np.linalg.lstsq(a, b, rcond=None)[0])


def test_least_squares_of_what_hangs_together() -> None:
    found = linear.least_squares(row(3, 2, 1, 1e-10, [[1, 1], [2, 2], [3, 3]], [1, 2, 3]))
    assert found[:2] == pytest.approx([0.5, 0.5])
    assert found[-1] == 1


def test_least_squares_with_a_condition() -> None:
    """On the line x = y the least sum of squares is where its derivative is zero: t = 16/29."""
    a, c = [[1, 1], [1, 2], [1, 3]], [1, 2, 2]
    found = linear.constrained_least_squares(row(3, 2, 1, a, c, [[1, -1]], [0]))
    assert found == pytest.approx([16 / 29, 16 / 29, 0])


@pytest.mark.parametrize("a", [SQUARE, ROUND], ids=["any", "turning"])
def test_eigenvalues(a: Array) -> None:
    n = len(a)
    real, imaginary, vectors, info = taken(linear.eigenvalues(row(n, a)), (n,), (n,), (n, n), ())
    assert info == 0
    values, columns, k = real + 1j * imaginary, np.zeros((n, n), dtype=complex), 0
    while k < n:
        columns[:, k] = vectors[:, k]
        if imaginary[k] != 0:
            columns[:, k : k + 2] = np.stack(
                (vectors[:, k] + 1j * vectors[:, k + 1], vectors[:, k] - 1j * vectors[:, k + 1]), 1
            )
            k += 1
        k += 1
    assert np.allclose(a @ columns, columns * values)
    b = np.diag(np.arange(1.0, n + 1))
    real, imaginary, beta, *_, info = taken(
        linear.general_eigenvalues(row(n, a, b)), (n,), (n,), (n,), (n, n), (n, n), ()
    )
    found = np.sort_complex((real + 1j * imaginary) / beta)
    assert np.allclose(found, np.sort_complex(sl.eigvals(a, b)))


@pytest.mark.parametrize("a", [WIDE, HIGH], ids=["wide", "high"])
def test_singular_values(a: Array) -> None:
    m, n = a.shape
    sigma, u, vt, info = taken(linear.singular_values(row(m, n, a)), (3,), (m, m), (n, n), ())
    assert info == 0
    assert np.allclose(u[:, :3] * sigma @ vt[:3], a)
    assert np.allclose(u @ u.T, np.eye(m))


@pytest.mark.parametrize("exchanged", [False, True])
def test_orthogonal_factors(exchanged: bool) -> None:
    m, n = HIGH.shape
    qr, tau, order, _ = taken(
        linear.orthogonal_factors(row(m, n, exchanged, HIGH)), (m, n), (n,), (n,), ()
    )
    q, _ = taken(linear.orthogonal(row(m, n, qr, tau)), (m, n), ())
    columns = order.astype(int) - 1
    assert sorted(columns) == [0, 1, 2]
    assert exchanged or columns.tolist() == [0, 1, 2]
    assert np.allclose(q @ np.triu(qr[:n]), HIGH[:, columns])
    assert np.allclose(q.T @ q, np.eye(n))


def test_schur_forms_and_their_order() -> None:
    t, z, real, _, info = taken(linear.schur(row(4, SQUARE)), (4, 4), (4, 4), (4,), (4,), ())
    assert info == 0
    assert np.allclose(z @ t @ z.T, SQUARE)
    chosen = real < 0
    t2, z2, real2, _, count, *_, info = taken(
        linear.reordered_schur(row(4, chosen, t, z)),
        (4, 4), (4, 4), (4,), (4,), (), (), (), (),
    )  # fmt: skip
    assert info == 0
    assert 0 < count == chosen.sum() < 4
    assert (real2[: int(count)] < 0).all() and (real2[int(count) :] >= 0).all()
    assert np.allclose(z2 @ t2 @ z2.T, SQUARE)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("turned", [(False, False), (True, False), (False, True)])
def test_sylvester(turned: tuple[bool, bool], sign: int) -> None:
    a, b = np.triu(SQUARE[:3, :3]) + 5 * np.eye(3), np.triu(SQUARE[:2, :2]) + np.eye(2)
    c = GENERATOR.normal(size=(3, 2))
    x, scale, info = taken(linear.sylvester(row(3, 2, *turned, sign, a, b, c)), (3, 2), (), ())
    left, right = (m.T if turn else m for m, turn in zip((a, b), turned, strict=True))
    assert info == 0
    assert np.allclose(left @ x + sign * x @ right, scale * c)


@pytest.mark.parametrize("function", [linear.solution, linear.eigenvalues])
def test_rows_that_are_too_short_have_no_value(
    function: Callable[[Sequence[float]], list[float]],
) -> None:
    with pytest.raises((ValueError, IndexError)):
        function([2.0, 1.0, 1.0])
    name = {linear.solution: "planarc_solution", linear.eigenvalues: "planarc_eigenvalues"}[
        function
    ]
    assert np.isnan(external.number(name, 0, [2.0, 1.0, 1.0]))
