"""Choosing columns and their sensitivities, with literal matrices and exact answers."""

from __future__ import annotations

from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.solve.states import pivoting
from planarc.solve.states.pivoting import GIVE_WAY, choose_columns, largest, sensitivities

NEVER = 9


def test_the_largest_pivot_is_taken() -> None:
    assert choose_columns([[3.0, -4.0]], [1, 1], NEVER) == [1]
    assert choose_columns([[1.0, 0.0, 5.0], [0.0, 2.0, 0.0]], [1, 1, 1], NEVER) == [1, 2]


def test_a_lower_class_comes_first_and_gives_way_to_a_much_larger_pivot() -> None:
    assert choose_columns([[1.0, 2.0]], [0, 1], NEVER) == [0]
    assert choose_columns([[0.9 * GIVE_WAY, 1.0]], [0, 1], NEVER) == [1]
    assert choose_columns([[1.1 * GIVE_WAY, 1.0]], [0, 1], NEVER) == [0]


def test_equal_pivots_are_taken_in_order_whatever_the_rounding() -> None:
    assert choose_columns([[1.0, 1.0 + 1e-15]], [1, 1], NEVER) == [0]


def test_what_may_never_be_chosen_is_not() -> None:
    assert choose_columns([[1.0, 100.0]], [1, NEVER], NEVER) == [0]
    assert choose_columns([[1.0, 2.0]], [NEVER, NEVER], NEVER) is None


@given(st.integers(1, 40), st.integers(1, 4), st.integers(0, 2**32 - 1))
def test_many_rows_are_treated_as_few_are(m: int, extra: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    g = random.normal(size=(m, m + extra)) * random.integers(0, 2, (m, m + extra))
    classes = random.integers(0, 4, m + extra).tolist()
    with mock.patch.object(pivoting, "MANY", 0):
        as_many = choose_columns(g.tolist(), classes, 3)
    with mock.patch.object(pivoting, "MANY", m + 1):
        assert choose_columns(g.tolist(), classes, 3) == as_many


def test_sensitivities_are_those_of_the_linear_system() -> None:
    assert sensitivities([[3.0, -4.0]], [1], [0]) == [[0.75]]
    assert sensitivities([[0.0, 1.0]], [0], [1]) is None


@given(
    st.integers(1, 9),
    st.integers(1, 4),
    st.integers(0, 2**32 - 1),
)
def test_small_and_large_agree_with_linear_algebra(m: int, extra: int, seed: int) -> None:
    g = np.random.default_rng(seed).normal(size=(m, m + extra))
    solved = choose_columns(g.tolist(), [1] * (m + extra), NEVER)
    assert solved is not None
    free = [j for j in range(m + extra) if j not in solved]
    expected = np.abs(np.linalg.solve(g[:, solved], g[:, free]))
    assert np.allclose(sensitivities(g.tolist(), solved, free), expected, rtol=1e-6)
    # Complete pivoting keeps the sensitivities small: that is what it is for.
    assert expected.max() < 2.0**m * 4


def test_exchanging_two_columns_multiplies_the_determinant_by_their_sensitivity() -> None:
    g = np.array([[2.0, 1.0, 3.0, 1.0], [1.0, 4.0, 1.0, 2.0]])
    x = sensitivities(g.tolist(), [0, 1], [2, 3])
    assert x is not None
    before = abs(np.linalg.det(g[:, [0, 1]]))
    assert abs(np.linalg.det(g[:, [2, 1]])) == pytest.approx(x[0][0] * before)
    assert abs(np.linalg.det(g[:, [0, 3]])) == pytest.approx(x[1][1] * before)


def test_largest_looks_in_the_given_columns_only() -> None:
    assert largest([[1.0, 5.0], [2.0, 3.0]], [0, 1]) == (5.0, 0, 1)
    assert largest([[1.0, 5.0], [2.0, 3.0]], [0]) == (2.0, 1, 0)
    assert largest([[1.0]], []) == (-1.0, -1, -1)
