"""The past of delayed signals."""

from __future__ import annotations

import math

import pytest

from planarc.runtime.history import History, Memory


def test_pieces_are_polynomials_and_their_derivatives() -> None:
    history = History(2)
    history.start(1.0, [5.0, 7.0])
    history.append(1.0, 3.0, [[5, 2, 0, 8, 0, 0], [7, 0, 0, 0, 0, 32]])
    x = 0.25  # at t = 1.5
    assert history.value(0, 0, 1.5) == pytest.approx(5 + 2 * x + 8 * x**3)
    assert history.value(0, 1, 1.5) == pytest.approx((2 + 24 * x**2) / 2)
    assert history.value(0, 2, 1.5) == pytest.approx(48 * x / 4)
    assert history.value(1, 5, 1.5) == pytest.approx(32 * 120 / 2**5)
    assert history.value(1, 6, 1.5) == 0


def test_constant_before_and_tangent_behind() -> None:
    history = History(1)
    history.start(0.0, [4.0])
    history.append(0.0, 2.0, [[4, 0, 1, 0, 0, 0]])
    assert history.value(0, 0, -10) == 4
    assert history.value(0, 1, -10) == 0
    assert history.value(0, 0, 3) == pytest.approx(5 + 1)  # slope 2*x/2 = 1 at the end


def test_bounds_choose_the_side_of_a_jump() -> None:
    history = History(1)
    history.start(0.0, [1.0])
    history.append(0.0, 1.0, [[1, 0, 0, 0, 0, 0]])
    history.append(1.0, 2.0, [[9, 0, 0, 0, 0, 0]])
    history.bounds[1] = 1 - 1e-12
    assert history.value(0, 0, 1.0) == 1
    history.bounds[:] = type(history.bounds)("d", [1 + 1e-12, math.inf])
    assert history.value(0, 0, 1.0) == 9


def test_what_is_old_is_forgotten() -> None:
    history = History(1)
    history.start(0.0, [0.0])
    for i in range(5000):
        history.append(i, i + 1, [[i, 1, 0, 0, 0, 0]])
        history.forget(i - 10)
    assert history.size < 1100
    assert history.memory[Memory.PIECES] == history.size
    assert history.value(0, 0, 4995.5) == 4995.5
