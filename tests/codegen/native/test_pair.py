"""Blocks of two unknowns: by determinants where that is as exact, else as all others are."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from planarc.codegen.native import gauss, newton, pair
from planarc.ir.frame import ARRAYS, COUNT, FACTOR, NORM, TINY, Number, Record
from tests.codegen.native.engine import compiled

#: Where things stand in the memory of a block of two: behind its numbers, its residuals.
JACOBIAN, CHANGE, ORDER, SHARED = ARRAYS + 2, ARRAYS + 6, ARRAYS + 10, ARRAYS + 20

Run = Callable[..., tuple[int, np.ndarray]]


@cache
def engine() -> Any:
    functions = (*gauss.solve_functions(), *newton.newton_functions(), *pair.pair_functions())
    return compiled(*functions)


@pytest.fixture
def run() -> Run:
    """What a function makes of a block of the top: its flag, and the unknowns behind it."""

    def call(
        name: str, matrix: np.ndarray, residuals: np.ndarray, x: np.ndarray, steps: int = 0
    ) -> tuple[int, np.ndarray]:
        area = np.zeros(SHARED + 6)
        area[[COUNT, FACTOR, NORM, TINY]] = steps, 1.0, 1e300, 0.0
        area[ARRAYS:JACOBIAN] = residuals
        area[JACOBIAN:CHANGE] = matrix.ravel()
        area[CHANGE + 2 : ORDER] = abs(matrix).max(axis=1)
        area[ORDER : ORDER + 2].view(np.int64)[:] = 0, 1
        numbers = np.zeros(Number.FIRST_STATE + 4, np.int64)
        w, accepted = x.copy(), np.zeros(7)
        record = np.zeros(Record.SLOTS + 6, np.int64)
        record[[Record.TEARS, Record.RESIDUALS, Record.TOTAL]] = 2
        record[[Record.SOLVED, Record.SHARED]] = Number.FIRST_STATE, SHARED
        record[Record.SLOTS : Record.SLOTS + 2] = 0, 1
        parts = (w, numbers, accepted, area)
        frame = (ctypes.c_void_p * 4)(*(part.ctypes.data for part in parts))
        function = ctypes.CFUNCTYPE(ctypes.c_int, *[ctypes.c_void_p] * 2)(
            engine().get_function_address(name)
        )
        return function(ctypes.addressof(frame), record.ctypes.data), w

    return call


def near(angle: float, random: np.random.Generator) -> np.ndarray:
    """Rows of any size, and as far apart as the angle says."""
    first = random.uniform(0, 2 * np.pi)
    angles = np.array([first, first + angle])
    return np.column_stack([np.cos(angles), np.sin(angles)]) * 10.0 ** random.integers(-8, 9)


@pytest.mark.parametrize("angle", [1.5, 0.1, 1e-2, 1e-4, 1e-7, 1e-10, 1e-12])
def test_a_linear_block_leaves_rounding_of_its_equations(angle: float, run: Run) -> None:
    random = np.random.default_rng(1)
    for _ in range(300):
        matrix, right = near(angle, random), random.normal(size=2)
        flag, x = run("pc_linear_pair", matrix, right, np.zeros(2))
        assert flag == gauss.DONE
        terms = abs(matrix) @ abs(x) + abs(right)
        assert (abs(matrix @ x + right) <= 1e-12 * terms).all()


def test_rows_that_are_nearly_alike_are_eliminated(run: Run) -> None:
    random = np.random.default_rng(2)
    for _ in range(300):
        given = near(1e-5, random), random.normal(size=2), np.zeros(2)
        pair, general = (run(name, *given)[1] for name in ("pc_linear_pair", "pc_linear"))
        assert pair.tolist() == general.tolist()


@pytest.mark.parametrize("size", [1e-200, 1e-160, 1e-150, 1e-100, 1e100, 1e150, 1e200])
def test_sizes_of_equations_do_not_count(size: float, run: Run) -> None:
    matrix, right = np.array([[1.0, 2.0], [-1.0, 1.0]]) * size, np.array([3.0, 0.0]) * size
    flag, x = run("pc_linear_pair", matrix, right, np.zeros(2))
    assert flag == gauss.DONE
    assert x == pytest.approx([-1.0, -1.0], rel=1e-14)
    flag, x = run("pc_pair", matrix, -right, np.array([5.0, 5.0]))
    assert flag == gauss.MORE
    assert x == pytest.approx([6.0, 6.0], rel=1e-14)


@pytest.mark.parametrize("name", ["pc_linear_pair", "pc_pair"])
@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e308])
def test_what_is_no_finite_number_fails_as_it_does_elsewhere(
    wrong: float, name: str, run: Run
) -> None:
    for place in range(6):
        numbers = np.array([1.0, 2.0, -1.0, 1.0, 3.0, 4.0])
        numbers[place] = wrong
        given = numbers[:4].reshape(2, 2), numbers[4:], np.ones(2)
        flag, x = run(name, *given)
        general, there = run({"pc_pair": "pc_step"}.get(name, "pc_linear"), *given)
        assert flag == general
        assert flag < 0 or x == pytest.approx(there, rel=1e-12, nan_ok=True)


@pytest.mark.parametrize("name", ["pc_linear_pair", "pc_pair"])
def test_rows_that_are_alike_have_no_solution(name: str, run: Run) -> None:
    for matrix in ([[1.0, 2.0], [2.0, 4.0]], [[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [0.0, 2.0]]):
        assert run(name, np.array(matrix), np.array([1.0, 0.5]), np.zeros(2))[0] == gauss.UNSOLVED


def test_steps_are_those_of_other_blocks(run: Run) -> None:
    """Large ones, small ones beside 1 or beside themselves, and ones that lessen nothing."""
    random = np.random.default_rng(3)
    for _ in range(2000):
        matrix = random.normal(size=(2, 2)) * 10.0 ** random.integers(-3, 4, size=(2, 1))
        x = random.normal(size=2) * 10.0 ** random.integers(-9, 4)
        residuals = matrix @ random.normal(size=2) * 10.0 ** random.integers(-12, 2)
        given = matrix, residuals, x, int(random.integers(0, 60))
        (flag, pair), (general, there) = run("pc_pair", *given), run("pc_step", *given)
        assert flag == general
        assert pair == pytest.approx(there, rel=1e-9, abs=1e-12)
