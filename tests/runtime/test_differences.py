"""Differences: their order, their columns, and arguments without a value."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from planarc.runtime.differences import central, one_sided


def curve(z: Any) -> Any:
    return np.array([math.sin(z[0]) * z[1], math.exp(z[1]), z[0]])


AT = np.array([0.3, 0.7])
TRUE = np.array([[math.cos(0.3) * 0.7, math.sin(0.3)], [0.0, math.exp(0.7)], [1.0, 0.0]])


@pytest.mark.parametrize("order", [2, 4])
def test_errors_fall_with_the_order(order: int) -> None:
    errors = [np.max(np.abs(central(curve, AT, [h, h], order) - TRUE)) for h in (0.02, 0.01)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.02)


def test_one_side_is_enough_for_eight_digits() -> None:
    found = one_sided(curve, AT, [1.5e-8, 1.5e-8])
    assert found is not None
    assert np.allclose(found, TRUE, atol=1e-7)


def test_the_other_side_serves_where_there_is_no_value() -> None:
    def rooted(z: Any) -> Any:
        return np.array([math.sqrt(1 - z[0])]) if z[0] <= 1 else None

    at = [1 - 1e-9]
    assert one_sided(rooted, at, [1e-8]) is None
    assert one_sided(rooted, at, [1e-8], either=True) is not None
    assert one_sided(rooted, [1 + 1e-7], [1e-8], either=True) is None


def test_without_arguments_there_are_no_columns() -> None:
    found = central(lambda z: np.ones(3), np.zeros(0), [])
    assert found.shape == (3, 0)
