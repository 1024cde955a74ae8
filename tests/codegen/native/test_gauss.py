"""Elimination in machine code, small systems in registers and larger ones in loops."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from planarc.codegen.native import gauss
from tests.codegen.native.engine import compiled

Solve = Callable[[np.ndarray, np.ndarray], tuple[int, np.ndarray, np.ndarray]]


@cache
def engine() -> Any:
    return compiled(*gauss.solve_functions())


@pytest.fixture
def solve() -> Solve:
    """The flag, the solution, and the sizes of the rows."""
    shape = ctypes.CFUNCTYPE(ctypes.c_int, *[ctypes.c_void_p] * 5, ctypes.c_int64)
    function = shape(engine().get_function_address("pc_solve"))

    def call(matrix: np.ndarray, right: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
        m = len(right)
        given = [matrix.copy(), right.copy(), np.zeros(m), np.zeros(m), np.zeros(3 * m, np.int64)]
        flag = function(*(a.ctypes.data for a in given), m)
        again(matrix, right, *given[2:4], given[4][:m], flag)
        return flag, given[2], given[3]

    return call


def again(
    matrix: np.ndarray, right: np.ndarray, x: np.ndarray, sizes: np.ndarray, order: np.ndarray,
    flag: int,
) -> None:  # fmt: skip
    """In the order of the last time there are the same bits, and in another one no solution."""
    shape = ctypes.CFUNCTYPE(ctypes.c_int, *[ctypes.c_void_p] * 6, *[ctypes.c_int64] * 3)
    function = shape(engine().get_function_address("pc_again"))
    m = len(right)
    wide, columns = np.full((m, m + 2), np.nan), np.arange(m) + 1
    wide[:, 1 : m + 1] = matrix

    def call(order: np.ndarray) -> tuple[int, list[np.ndarray]]:
        found = [np.zeros(m), np.zeros(m)]
        given = (wide, right, *found, order.copy(), columns)
        return function(*(a.ctypes.data for a in given), 1, m, m + 2), found

    there, found = call(order)
    assert there == (gauss.MORE if flag == gauss.MORE and m <= gauss.SMALL else gauss.DONE)
    if there == gauss.MORE:
        assert [a.tolist() for a in found] == [x.tolist(), sizes.tolist()]
        assert m == 1 or call(np.roll(order, 1))[0] == gauss.DONE
    assert m == 1 or call(np.zeros(m, np.int64))[0] == gauss.DONE  # before there was one


SIZES = pytest.mark.parametrize("m", range(1, gauss.SMALL + 4))


@SIZES
def test_solutions_are_exact_whatever_the_scale_of_the_rows(m: int, solve: Solve) -> None:
    random = np.random.default_rng(m)
    for _ in range(40):
        matrix = random.normal(size=(m, m)) * 10.0 ** random.integers(-8, 9, size=(m, 1))
        matrix[random.random((m, m)) < 0.2] = 0.0
        if np.linalg.cond(matrix / abs(matrix).max(axis=1, initial=1e-300, keepdims=True)) > 1e4:
            continue
        wanted = random.normal(size=m)
        flag, found, sizes = solve(matrix, matrix @ wanted)
        assert flag == gauss.MORE
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)
        assert sizes == pytest.approx(abs(matrix).max(axis=1))


@pytest.mark.parametrize("seed", range(5))
def test_what_is_zero_is_passed_over_and_nothing_else(seed: int, solve: Solve) -> None:
    m, random = 60, np.random.default_rng(seed)
    matrix = np.triu(np.tril(random.normal(size=(m, m)), 2), -3)
    matrix[random.permutation(m)[:4]] += random.normal(size=m)  # full rows
    matrix[:, random.permutation(m)[:4]] += random.normal(size=(m, 4))
    matrix[random.random((m, m)) < 0.2] = 0.0
    matrix = matrix[random.permutation(m)] if seed else matrix
    wanted = random.normal(size=m)
    flag, found, _ = solve(matrix, matrix @ wanted)
    assert flag == gauss.MORE
    assert found == pytest.approx(wanted, rel=1e-8, abs=1e-8)


@SIZES
def test_rows_are_exchanged(m: int, solve: Solve) -> None:
    turned = np.roll(np.eye(m), 1, axis=0)
    flag, found, _ = solve(turned, np.arange(1.0, m + 1))
    assert flag == gauss.MORE
    assert (turned @ found).tolist() == list(range(1, m + 1))


@SIZES
def test_a_singular_matrix_is_told(m: int, solve: Solve) -> None:
    matrix = np.ones((m, m)) if m > 1 else np.zeros((1, 1))
    assert solve(matrix, np.ones(m))[0] == gauss.UNSOLVED
    zero_row = np.eye(m)
    zero_row[-1] = 0.0
    assert solve(zero_row, np.ones(m))[0] == gauss.UNSOLVED


@SIZES
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_told(m: int, bad: float, solve: Solve) -> None:
    matrix = np.eye(m)
    matrix[-1, 0] = bad
    assert solve(matrix, np.ones(m))[0] == gauss.NOT_FINITE
    right = np.ones(m)
    right[0] = bad
    assert solve(np.eye(m), right)[0] == gauss.NOT_FINITE
