"""Blocks that tick: loops of them against the same loops in words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planarc

PLANT = """
  import Modelica.Clocked.{ClockSignals, RealSignals};
  import Modelica.Clocked.RealSignals.Sampler;
  Real x(start=1, fixed=true);
"""


def run(body: str, stop: float = 1.0, **options: Any) -> planarc.Result:
    return planarc.load(f"model M\n{PLANT}{body}\nend M;").simulate(stop, **options)


def at(found: planarc.Result, name: str, times: np.ndarray) -> list[float]:
    """A signal behind the events at some instants."""
    return [float(found[name][np.flatnonzero(found["time"] <= t + 1e-9)[-1]]) for t in times]


@pytest.mark.parametrize(
    ("clock", "interval"),
    [
        ("PeriodicRealClock clock(period=0.125)", 0.125),
        ("PeriodicExactClock clock(factor=50)", 0.05),
        ("PeriodicExactClock clock(factor=2, resolution=Modelica.Clocked.Types.Resolution.s)", 2),
        (
            "PeriodicExactClock clock(factor=1, resolution=Modelica.Clocked.Types.Resolution.m)",
            60,
        ),
    ],
)
def test_a_controller_of_blocks(clock: str, interval: float) -> None:
    """A plant x' = u under a PI controller and a hold."""
    blocks = run(
        f"""
  ClockSignals.Clocks.{clock};
  Sampler.SampleClocked sensor;
  RealSignals.NonPeriodic.PI controller(k=-{0.4 / interval}, T={3 * interval});
  Sampler.Hold actuator(y_start=0.5);
equation
  connect(clock.y, sensor.clock);
  connect(sensor.y, controller.u);
  connect(controller.y, actuator.u);
  sensor.u = x;
  der(x) = actuator.y;
""",
        8 * interval,
        tolerance=1e-10,
    )
    state, integral, expected = 1.0, 0.0, []
    for _ in range(9):
        integral += state / 3
        push = -0.4 / interval * (state + integral)
        expected.append((state, push))
        state += interval * push
    times = interval * np.arange(9)
    np.testing.assert_allclose(at(blocks, "x", times), [x for x, _ in expected], atol=1e-7)
    np.testing.assert_allclose(at(blocks, "actuator.y", times), [u for _, u in expected], rtol=1e-7)


def test_a_wheel_of_teeth_ticks_and_what_ticks_integrates() -> None:
    found = run(
        """
  ClockSignals.Clocks.EventClock clock(
    startInterval=0.1, useSolver=true, solverMethod="ExplicitEuler");
  Sampler.SampleClocked sensor;
  Real sum(start=2);
equation
  der(x) = 1;
  clock.u = sin(20*x) > 0;
  connect(clock.y, sensor.clock);
  sensor.u = x;
  der(sum) = sensor.y - sum;
""",
        tolerance=1e-10,
    )
    teeth = [1, *(2 * np.pi * k / 20 for k in range(4, 7))]  # the condition is true at the start
    value, before, y = 2.0, teeth[0], teeth[0]
    for tooth in teeth[1:]:
        value += (tooth - before) * (y - value)
        before = y = tooth
    assert found["sensor.y"][-1] == pytest.approx(teeth[-1], abs=1e-7)
    assert found["sum"][-1] == pytest.approx(value, abs=1e-7)


def test_signals_go_from_clock_to_clock() -> None:
    found = run(
        """
  ClockSignals.Clocks.PeriodicExactClock clock(factor=100);
  ClockSignals.Clocks.PeriodicExactClock slow(factor=300);
  Sampler.SampleClocked sensor;
  Sampler.SubSample every(factor=3);
  Sampler.SuperSample again(inferFactor=false, factor=6), found;
  Sampler.ShiftSample later(shiftCounter=1, resolution=2);
  Sampler.BackSample back(backCounter=1, resolution=4, y_start=-1);
  Sampler.AssignClock assigned;
  RealSignals.NonPeriodic.UnitDelay before(y_start=-2);
  Real both = found.y + sensor.y;
equation
  der(x) = 1;
  connect(clock.y, sensor.clock);
  sensor.u = x;
  connect(sensor.y, every.u);
  connect(every.y, again.u);
  connect(sensor.y, later.u);
  connect(later.y, back.u);
  connect(sensor.y, before.u);
  connect(slow.y, assigned.clock);
  assigned.u = every.y + 1;
  connect(every.y, found.u);
"""
    )
    times = np.array([0, 0.05, 0.1, 0.16, 0.3, 0.33, 0.37, 0.64, 0.95])
    fast = 1 + np.floor(10 * times + 1e-9) / 10
    slow = 1 + np.floor(10 * times / 3 + 1e-9) * 0.3
    assert at(found, "sensor.y", times) == pytest.approx(fast)
    assert at(found, "every.y", times) == pytest.approx(slow)
    assert at(found, "again.y", times) == pytest.approx(slow)
    assert at(found, "found.y", times) == pytest.approx(slow)
    assert at(found, "both", times) == pytest.approx(fast + slow)
    assert at(found, "assigned.y", times) == pytest.approx(slow + 1)
    shifted = 1 + np.floor(10 * (times - 0.05) + 1e-9) / 10
    assert at(found, "later.y", times)[1:] == pytest.approx(shifted[1:])
    assert at(found, "before.y", times)[2:] == pytest.approx((fast - 0.1)[2:])
    assert at(found, "before.y", times)[0] == -2
    behind = at(found, "back.y", np.array([0.03, 0.12, 0.13, 0.22, 0.23]))
    assert behind == pytest.approx([-1, -1, 1, 1, 1.1])  # at 0.025, 0.125 ... what `later` has
