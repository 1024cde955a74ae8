"""Newton's method: order of convergence, the near branch, and points that have no value."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from planarc.solve.start.newton import LONGEST, derivative, solve

Vector = np.ndarray


def test_roots_are_exact_to_rounding() -> None:
    root = solve(lambda z: np.array([z[0] ** 2 - 2, z[0] * z[1] - 1]), np.array([1.0, 1.0]))
    assert root.converged
    assert np.allclose(root.point, [np.sqrt(2), 1 / np.sqrt(2)], rtol=0, atol=4e-16)


def test_undetermined_unknowns_stay() -> None:
    root = solve(lambda z: np.array([z[0] - 3.0]), np.array([1.0, 7.0]))
    assert root.point.tolist() == [3.0, 7.0]
    # Two unknowns, one equation: the nearest point of the line.
    root = solve(lambda z: np.array([z[0] + z[1] - 1.0]), np.array([0.0, 0.0]))
    assert np.allclose(root.point, [0.5, 0.5])


def test_consistent_surplus_equations_are_met() -> None:
    root = solve(lambda z: np.array([z[0] - 1, 2 * z[0] - 2, z[0] ** 2 - 1]), np.array([3.0]))
    assert root.converged
    assert root.point[0] == pytest.approx(1.0, abs=1e-12)


def test_contradictions_are_no_roots() -> None:
    root = solve(lambda z: np.array([z[0] - 1, z[0] - 2]), np.array([0.0]))
    assert not root.converged
    assert root.point[0] == pytest.approx(1.5, abs=1e-6)


def test_a_flat_tangent_does_not_throw_an_angle_whole_turns_away() -> None:
    root = solve(lambda z: np.array([np.cos(z[0]) - 0.5]), np.array([0.01]))
    assert root.converged
    assert root.point[0] == pytest.approx(np.pi / 3, abs=1e-12)


def test_linear_unknowns_go_to_their_root_however_far_it_is() -> None:
    """A torque of 10^4 N.m beside its own filter: thousands of steps of LONGEST away."""
    root = solve(lambda z: np.array([z[0] - 2e4, 3 * (z[0] - z[1])]), np.zeros(2), iterations=5)
    assert root.converged
    assert root.point == pytest.approx([2e4, 2e4], rel=1e-14)


def test_a_point_without_a_value_is_stepped_back_from() -> None:
    def f(z: Vector) -> Vector | None:
        return None if z[0] < 0 else np.array([np.sqrt(z[0]) - 0.01])

    root = solve(f, np.array([0.3]))
    assert root.converged
    assert root.point[0] == pytest.approx(1e-4, rel=1e-9)


def test_a_guess_without_a_value_is_left() -> None:
    root = solve(lambda z: None if z[0] == 0 else np.array([z[0] - 1]), np.array([0.0]))
    assert root.converged
    assert root.point[0] == 1.0


def test_a_singular_guess_is_left_by_damping() -> None:
    """At (1, 0) both columns vanish."""
    f: Callable[[Vector], Vector] = lambda z: np.array([(z[0] - 1) * z[1] - 0.1, z[1] ** 2 - 0.04])  # noqa: E731
    root = solve(f, np.array([1.2, 0.05]))
    assert root.converged
    assert np.allclose(np.abs(root.point - [1, 0]), [0.5, 0.2])


def test_differences_are_taken_on_the_side_that_has_a_value() -> None:
    def f(z: Vector) -> Vector | None:
        return None if z[0] > 1 else np.array([np.exp(2 * z[0])])

    for at in (0.3, 1.0):
        z = np.array([at])
        jacobian = derivative(f, z, np.exp(2 * z))
        assert jacobian is not None
        assert jacobian[0, 0] == pytest.approx(2 * np.exp(2 * at), rel=1e-6)
    assert derivative(lambda z: None, np.array([0.0]), np.array([1.0])) is None


def test_on_a_curve_no_step_is_longer_than_allowed() -> None:
    calls: list[float] = []

    def f(z: Vector) -> Vector:
        calls.append(float(z[0]))
        return np.array([z[0] + 0.5 * np.sin(z[0])])

    assert solve(f, np.array([20.0])).converged
    reached = [a for a, b in pairwise(calls) if 0 < abs(b - a) < 1e-6]  # for the derivative
    assert len(reached) > 30
    assert max(abs(b - a) for a, b in pairwise(reached)) <= LONGEST + 1e-6
