"""Weights that show that no impulses end all approach, and none where some do."""

from __future__ import annotations

import numpy as np

from planarc.solve.contact.pinched import find_pinched


def test_a_ball_between_what_does_not_give_way_is_pinched() -> None:
    a = np.array([[1.0, -1.0], [-1.0, 1.0], [0.0, 0.0]])
    y = find_pinched(a, np.array([-1.0, 0.3]))
    assert y is not None
    np.testing.assert_allclose(y / y[0], [1.0, 1.0])
    assert find_pinched(a, np.array([-1.0, 1.1])) is None  # the other one leaves faster


def test_what_moves_nothing_is_pinched_by_itself() -> None:
    y = find_pinched(np.array([[0.5, 0.0], [0.0, 0.0]]), np.array([-3.0, -1.0]))
    assert y is not None and y[0] == 0 < y[1]
    assert find_pinched(np.array([[0.5, 0.0], [0.0, 0.0]]), np.array([-3.0, 1.0])) is None


def test_a_ball_that_is_pressed_aside_is_not_pinched() -> None:
    """Walls that are not parallel: what each presses moves the ball on along the other one, and a
    heavy ram gives way to a light ball at last."""
    normals = np.array([[1.0, 0.1], [-1.0, 0.1]])
    a = normals @ normals.T
    assert find_pinched(a, np.array([-1.0, -1.0])) is None
    ram, ball = 1e-6, 1.0
    heavy = np.array([[ram + ball, -ball], [-ball, ball]])
    assert find_pinched(heavy, np.array([-1.0, 0.0])) is None
