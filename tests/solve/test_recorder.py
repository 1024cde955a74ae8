"""The rows of a result: room for as many as come, and the way back."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from planarc.solve.recorder import Recorder, constants

COLUMNS = [SimpleNamespace(slot=s, constant=s == 0) for s in (2, 0, 1, 2)]


@pytest.mark.parametrize("make", [list, np.array], ids=["list", "array"])
def test_rows_grow_and_are_taken_back(make: Any) -> None:
    program: Any = SimpleNamespace(columns=COLUMNS)
    kernel: Any = SimpleNamespace(w=make([9.0, 0.0, 0.0]))
    recorder = Recorder(program, kernel, np.linspace(0.0, 1.0, 5))
    assert recorder.stored == {2: 0, 1: 1}  # each slot once, and no constant
    for k in range(100):
        kernel.w[1], kernel.w[2] = float(k), -float(k)
        recorder.take(0.01 * k)
    assert recorder.edition > 0  # the arrays are others now
    times, rows = recorder.rows()
    assert times.tolist() == [0.01 * k for k in range(100)]
    assert rows.tolist() == [[-float(k), float(k)] for k in range(100)]
    assert recorder.last() == {2: -99.0, 1: 99.0}
    recorder.back(3, 1)
    assert len(recorder.rows()[0]) == 3


@pytest.mark.parametrize("make", [list, np.array], ids=["list", "array"])
def test_constants_stay_what_they_were(make: Any) -> None:
    program: Any = SimpleNamespace(columns=COLUMNS)
    kernel: Any = SimpleNamespace(w=make([9.0, 1.0, 2.0]))
    found = constants(program, kernel)
    kernel.w[0] = 8.0
    assert found == {0: 9.0} and found.get(1) is None
    assert isinstance(found[0], float)


def test_rows_that_are_due() -> None:
    program: Any = SimpleNamespace(columns=COLUMNS)
    kernel: Any = SimpleNamespace(w=[0.0] * 3)
    recorder = Recorder(program, kernel, np.array([0.0, 0.5, 1.0]))
    assert recorder.due(0.4) == 0.0
    recorder.pass_by(0.5 - recorder.near / 2)  # an event so near takes the row's place
    assert recorder.due(0.9) is None
    assert recorder.due(1.0) == 1.0


def test_rows_without_a_finite_number_are_found_once() -> None:
    program: Any = SimpleNamespace(columns=COLUMNS)
    kernel: Any = SimpleNamespace(w=[0.0] * 3)
    recorder = Recorder(program, kernel, np.array([0.0, 0.5, 1.0]))
    for k, value in enumerate([1.0, 2.0, np.nan, np.inf]):
        kernel.w[1] = value
        recorder.take(0.1 * k)
        if k == 1:
            assert recorder.first_not_finite() is None
    assert recorder.first_not_finite() == 2
    assert recorder.first_not_finite() is None  # these were looked at
    recorder.cut(1)
    recorder.take(0.2)  # in the place of one that was looked at
    assert recorder.first_not_finite() == 1


def test_rows_of_huge_numbers_are_finite() -> None:
    """Their sum is not."""
    program: Any = SimpleNamespace(columns=COLUMNS)
    kernel: Any = SimpleNamespace(w=[0.0, 1.7e308, 1.7e308])
    recorder = Recorder(program, kernel, np.array([0.0, 1.0]))
    recorder.take(0.0)
    assert recorder.first_not_finite() is None
    kernel.w[1:] = [np.inf, -np.inf]
    recorder.take(1.0)
    assert recorder.first_not_finite() == 1


def test_a_short_last_interval_bounds_what_is_near() -> None:
    program: Any = SimpleNamespace(columns=COLUMNS)
    kernel: Any = SimpleNamespace(w=[0.0] * 3)
    assert Recorder(program, kernel, np.array([0.0, 0.5, 1.0, 1.1])).near == pytest.approx(1e-10)
    assert Recorder(program, kernel, np.array([0.0])).near == 0.0
