"""Relations of states that switch many times within a step."""

from __future__ import annotations

import math

import pytest

import planarc

#: Rising passages of sin(w*x) through zero while x goes from 0.1 to 1.1.
SWINGS = """
model Swings
  parameter Real w = 1000;
  Real x(start = 0.1, fixed = true);
  Real y(start = 0, fixed = true);
  Integer n(start = 0, fixed = true);
equation
  der(x) = 1;
  der(y) = if sin(w*x) > 0 then 1 else 0;
  when sin(w*x) > 0 then
    n = pre(n) + 1;
  end when;
end Swings;
"""


@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams", "lsoda", "scipy-bdf"])
@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_every_switch_is_met(backend: str, solver: str) -> None:
    run = planarc.load(SWINGS, backend=backend).simulate(1, solver=solver)
    turn = 2 * math.pi
    assert run["n"][-1] == math.floor(1100 / turn) - math.floor(100 / turn)
    # The sine is positive in the first half of each of 159 whole turns, and in what is left of two.
    first, last = 100 % turn, 1100 % turn
    positive = 159 * math.pi + max(math.pi - first, 0) + min(last, math.pi)
    assert run["y"][-1] == pytest.approx(positive / 1000, abs=2e-6)


def test_a_swing_as_slow_as_the_steps_costs_no_more_of_them() -> None:
    model = planarc.load(SWINGS)
    run = model.simulate(20, parameters={"w": 1}, intervals=10)
    assert run["n"][-1] == 3
    assert run.statistics.steps < 300
