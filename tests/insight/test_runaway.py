"""Speeds that are multiplied in equal times are told, and none that grows otherwise."""

from __future__ import annotations

import math

import pytest

import planarc

MASS = """model M
  Modelica.Mechanics.Translational.Components.Mass mass(m=1, s(start=S, fixed=true), v(fixed=true));
  Modelica.Mechanics.Translational.Sources.Force force;
equation
  force.f = LAW;
  connect(force.flange, mass.flange_a);
end M;
"""


def told(law: str, stop: float, s: float = 0.1) -> list[str]:
    result = planarc.load(MASS.replace("LAW", law).replace("S,", f"{s},")).simulate(stop)
    return [w.message for w in result.warnings if w.code == "R448"]


def test_the_number_is_that_of_the_closed_form() -> None:
    """s = cosh(t)/10: each second e times as fast."""
    (message,) = told("mass.s", 10.0)
    assert f"grows {math.e:.2g} times every 1 s, to {math.sinh(10) / 10:.3g} m/s" in message


def test_growth_above_the_speeds_of_satellites_is_told() -> None:
    (message,) = told("mass.s", 15.0)
    assert f"grows {math.exp(1.5):.2g} times every 1.5 s" in message


def test_what_is_faster_than_light_is_told_with_the_time() -> None:
    """s = cosh(30 t)/10 has the speed 1e9 m/s at t = ln(2e9/3)/30."""
    (message,) = told("900*mass.s", 2.0)
    assert f"at t = {math.log(2e9 / 3) / 30:.2g}" in message and "above 1e+09 m/s" in message
    assert f"ten times as much every {math.log(10) / 30:.2g} s" in message


@pytest.mark.parametrize(
    ("law", "stop"),
    [
        ("mass.s", 5.0),  # 7 m/s
        ("20", 30.0),  # constant acceleration, 600 m/s
        ("1000", 30.0),  # 30,000 m/s
        ("2e7", 10.0),  # a probe of an accelerator, 200,000 km/s
        ("-4e14/(mass.s + 4e7)^2", 1e4),  # falls from a high orbit, 2,100 m/s at the end
        ("time^2", 10.0),  # 333 m/s, and (10/9)^3 times in the last tenth
        ("5000*cos(10*time)", 10.0),
        ("if time < 9.9 then 0 else 1e4", 10.0),  # at once
    ],
)
def test_other_growth_is_not_told(law: str, stop: float) -> None:
    assert told(law, stop) == []
