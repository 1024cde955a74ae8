"""Pulses in the tables and functions of inputs are seen, and smooth ones stay cheap."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model
from planarc.api.corners import corners


@pytest.fixture(scope="module")
def integral() -> Model:
    return planarc.load(
        "model U input Real u; Real x(start=0, fixed=true); equation der(x) = u; end U;"
    )


#: Points of a measured signal, and their times.
MANY = 10_000
TIMES = np.linspace(0, 10, MANY)


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"tolerance": 1e-9},
        {"solver": "cvode-adams"},
        {"solver": "lsoda"},
        {"solver": "scipy-bdf"},
        {"solver": "rk4", "fixed_step": 0.05},
    ],
    ids=str,
)
def test_a_pulse_is_not_stepped_over(integral: Model, how: dict[str, Any]) -> None:
    pulse = [0, 5, 5.01, 5.02, 10], [0, 0, 100, 0, 0]
    result = integral.simulate(10, inputs={"u": pulse}, **how)
    assert result["x"][-1] == pytest.approx(1, abs=1e-4)
    assert not result.events
    assert len(result) == len(integral.simulate(10))


@pytest.mark.parametrize("begin", [0.013, 5.0, 5.0137, 9.97])
@pytest.mark.parametrize("solver", ["auto", "lsoda", "scipy-bdf"])
def test_what_the_rows_show_of_a_function_is_felt(
    integral: Model, begin: float, solver: str
) -> None:
    """A pulse as long as the rows are apart, over which steps would pass without a word."""
    result = integral.simulate(
        10, inputs={"u": lambda t: 100.0 if begin <= t < begin + 0.02 else 0.0}, solver=solver
    )
    assert result["u"].max() == 100
    assert result["x"][-1] == pytest.approx(2, abs=1e-3)


def test_a_fixed_step_looks_at_a_function_when_it_is_told_to() -> None:
    """Steps of Euler's method by der(x) = -x multiply x by 1 - h."""
    model = planarc.load(
        "model D input Real u; Real x(start=1, fixed=true); equation der(x) = u - x; end D;"
    )
    how: dict[str, Any] = {"solver": "euler", "fixed_step": 0.1}
    found = model.simulate(1, inputs={"u": lambda t: 1e-9 * math.sin(30 * t)}, **how)["x"][-1]
    assert found == pytest.approx(0.9**10, rel=1e-6)


def test_a_function_that_fails_is_told_when_the_run_comes_by(integral: Model) -> None:
    def root(t: float) -> float:
        return math.sqrt(2 - t)

    x = integral.simulate(1, inputs={"u": root})["x"][-1]
    assert x == pytest.approx(2 / 3 * (2**1.5 - 1), rel=1e-4)
    with pytest.raises(planarc.UsageError, match="fails at t = 2"):
        integral.simulate(10, inputs={"u": root})


def test_a_fixed_step_is_not_longer_behind_a_corner() -> None:
    """Steps of Euler's method by der(x) = -x multiply x by 1 - h."""
    model = planarc.load(
        "model D input Real u; Real x(start=1, fixed=true); equation der(x) = u - x; end D;"
    )
    table = [0, 0.22, 1], [0, 1e-9, 0]
    found = model.simulate(0.5, inputs={"u": table}, solver="euler", fixed_step=0.1)["x"][-1]
    assert found == pytest.approx(0.9**2 * 0.98 * 0.9**2 * 0.92, rel=1e-6)


@pytest.mark.parametrize(
    "values",
    [
        100.0 * (np.arange(MANY) % 1000 == 503),
        np.sin(TIMES) + 30.0 * (np.arange(MANY) == 5003),
        np.exp(-(((TIMES - 5.003) / 0.01) ** 2)),
        1e-3 * (np.arange(MANY) == 7001) + (np.arange(MANY) == 2001),
    ],
    ids=["pulses", "on a curve", "a smooth one", "a small one"],
)
def test_a_pulse_in_a_long_table_is_not_stepped_over(integral: Model, values: Any) -> None:
    x = integral.simulate(10, inputs={"u": (TIMES, values)}, tolerance=1e-8)["x"]
    exact = np.sum((values[1:] + values[:-1]) / 2 * np.diff(TIMES))
    assert x[-1] == pytest.approx(exact, abs=1e-6 * np.ptp(values))


@pytest.mark.parametrize("frequency", [0.5, 6.0])
def test_a_long_smooth_table_costs_about_as_much_as_its_function(
    integral: Model, frequency: float
) -> None:
    table = TIMES, np.sin(frequency * TIMES)
    long = integral.simulate(10, inputs={"u": table}).statistics
    short = integral.simulate(10, inputs={"u": lambda t: math.sin(frequency * t)}).statistics
    assert long.steps < 3 * short.steps


def test_corners_are_the_points_that_stand_out() -> None:
    assert corners(np.array([0.0, 1, 3]), np.array([0.0, 1, 3])).tolist() == [0, 3]
    assert corners(np.array([0.0, 1, 2, 3]), np.array([2.0, 2, 2, 2])).tolist() == []
    line = 3e9 + 0.1 * TIMES + 5.0 * (np.arange(MANY) == 4321)
    found = corners(TIMES, line)
    assert set(TIMES[4320:4323]) <= set(found)
    assert len(found) < 100


def test_a_pulse_that_starts_something_does_so() -> None:
    model = planarc.load(
        "model E input Real u; discrete Real hit(start=0, fixed=true); Real x(start=0, fixed=true);"
        " equation der(x) = u; when u > 50 then hit = time; end when; end E;"
    )
    found = model.simulate(10, inputs={"u": ([0, 5, 5.01, 5.02, 10], [0, 0, 100, 0, 0])})
    assert found["hit"][-1] == pytest.approx(5.005, abs=1e-6)
    assert len(found.events) == 2


@pytest.mark.parametrize("solver", ["auto", "lsoda", "scipy-bdf"])
def test_a_table_may_jump(integral: Model, solver: str) -> None:
    """Between two points at one time; at the ends of the table, too."""
    table = [0, 3, 3, 5, 5, 5, 8, 8, 9], [1, 1, 4, 4, 7, -2, -2, -2, -2]
    x = integral.simulate(10, inputs={"u": table}, solver=solver, tolerance=1e-8)["x"][-1]
    assert x == pytest.approx(3 + 8 - 10, abs=1e-6)
    ends = [2, 2, 6, 6], [1, 0, 0, 3]
    x = integral.simulate(10, inputs={"u": ends}, solver=solver, tolerance=1e-8)["x"][-1]
    assert x == pytest.approx(2 + 12, abs=1e-6)


def test_rows_of_a_run_with_events_drive_another(integral: Model) -> None:
    blow = planarc.load(
        "model B discrete Real f(start=0, fixed=true); equation"
        " when sample(0.7, 1.3) then f = pre(f) + 1; end when; end B;"
    ).simulate(10)
    x = integral.simulate(10, inputs={"u": (blow.time, blow["f"])}, tolerance=1e-8)["x"][-1]
    assert x == pytest.approx(sum(10 - (0.7 + 1.3 * k) for k in range(8)), abs=1e-6)


def test_a_table_that_jumps_has_no_derivative() -> None:
    model = planarc.load("model R input Real u; Real v = der(u); end R;")
    with pytest.raises(planarc.UsageError, match="jumps at t = 1 s, and its derivative is needed"):
        model.simulate(2, inputs={"u": ([0, 1, 1, 2], [0, 0, 1, 1])})
    found = model.simulate(2, inputs={"u": ([0, 1, 1, 2], [0, 3, 3, 4])})["v"]
    assert (found[0], found[-2]) == (3, 1)


def test_a_motion_that_jumps_is_refused() -> None:
    model = planarc.load("PlanarMultiBody.Examples.Elementary.Pendulum")
    motion = [0, 0.5, 1, 1, 2], [0, 0, 0, 1, 1]
    with pytest.raises(planarc.UsageError, match=r"`hinge\.phi` jumps at t = 1 s"):
        model.drive("hinge.phi", motion, stop_time=2)
