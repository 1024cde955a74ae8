"""Ways to a root where Newton's steps find none, by functions whose roots are known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from planarc.solve.rescue.ladder import climb, follow, newton

Vector = np.ndarray


class Formula:
    """A function of one or more unknowns, its slopes by complex steps."""

    def __init__(self, formula: Callable[[Vector], list[complex]]) -> None:
        self._formula = formula

    def __call__(self, x: Vector) -> Vector | None:
        with np.errstate(all="ignore"):
            found = np.array(self._formula(x), dtype=complex).real
        return found if np.isfinite(found).all() else None

    def slopes(self, x: Vector) -> Vector | None:
        steps = 1e-30j * np.eye(len(x))
        with np.errstate(all="ignore"):
            found = np.array([self._formula(x + step) for step in steps]).imag.T / 1e-30
        return found if np.isfinite(found).all() else None


def first(formula: Callable[[Vector], list[complex]], *guess: float) -> tuple[Vector, str]:
    found = next(climb(Formula(formula), np.array(guess)))
    return found.point, found.way


def test_a_slope_of_zero_at_the_guess_is_left() -> None:
    point, way = first(lambda x: [x[0] ** 2 - 9], 0.0)
    assert point.tolist() == pytest.approx([3.0], rel=1e-15)
    assert way == "a guess beside the start"


def test_steps_that_grow_without_end_are_cut() -> None:
    """|x| > 1.39 makes Newton's steps on atan(x) grow."""
    point, way = first(lambda x: [np.arctan(x[0] - 2)], 50.0)
    assert point.tolist() == pytest.approx([2.0], rel=1e-12)
    assert way == "a line search"


def test_unknowns_of_any_size_are_as_exact() -> None:
    """A diode behind 1e9 Ohm: the current counts though it is 2e-8 A."""
    point, _ = first(
        lambda x: [22 - 1e9 * x[0] - x[1], x[0] - 1e-12 * (np.exp(x[1] / 0.025) - 1)], 0.0, 0.0
    )
    assert 1e9 * point[0] + point[1] == pytest.approx(22, rel=1e-12)
    assert point[1] == pytest.approx(0.025 * np.log(point[0] / 1e-12 + 1), rel=1e-9)


def test_a_curve_is_followed_through_its_folds() -> None:
    """x^3 - 3*x = 10 from x = -3: the curve turns back at -1 and at 1, the root is 2.61."""
    cubic = Formula(lambda x: [x[0] ** 3 - 3 * x[0] - 10])
    guess = np.array([-3.0])
    here = cubic(guess)
    assert here is not None
    end = follow(cubic, guess, here, np.array([1.0]), False)
    assert end is not None
    root = newton(cubic, end)
    assert root is not None
    assert root[0] == pytest.approx(2.6128878647, rel=1e-9)


def test_the_nearest_root_comes_first_and_each_but_once() -> None:
    found = [f.point[0] for f in climb(Formula(lambda x: [np.sin(x[0])]), np.array([3.0]))]
    assert found[0] == pytest.approx(np.pi, rel=1e-12)
    assert len({round(x / np.pi) for x in found}) == len(found)


def test_where_nothing_vanishes_there_is_no_root() -> None:
    assert not list(climb(Formula(lambda x: [x[0] ** 2 + 1]), np.array([0.5])))


def test_points_without_value_are_stepped_back_from() -> None:
    def formula(x: Vector) -> list[complex]:
        return [np.log(x[0]) + 3 if x[0].real > 0 else np.nan]

    point, _ = first(formula, 50.0)
    assert point.tolist() == pytest.approx([np.exp(-3)], rel=1e-12)


def test_a_root_far_away_comes_after_those_nearer() -> None:
    """At x = 0 the slope of cos(x) vanishes: a step from beside it leads a thousand away."""
    point, _ = first(lambda x: [np.cos(x[0])], 0.0)
    assert abs(point.tolist()[0]) == pytest.approx(np.pi / 2)
