"""A bound that a reinit does not keep is told, and a bounce is not."""

from __future__ import annotations

import pytest

import planarc

BALL = """model Ball
  Real h(start=1, fixed=true), v(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when CONDITION then
    reinit(v, VALUE);
  end when;
end Ball;
"""


def told(condition: str, value: str, stop: float, backend: str = "native") -> list[str]:
    text = BALL.replace("CONDITION", condition).replace("VALUE", value)
    warnings = planarc.load(text, backend=backend).simulate(stop).warnings
    return [w.message for w in warnings if w.code == "R444"]


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_ball_that_is_stopped_falls_through(backend: str) -> None:
    (message,) = told("h <= 0", "0", 1.0, backend)
    assert message.startswith("`h <= 0` does not switch back after t = 0.45152")


@pytest.mark.parametrize("stop", [0.4, 0.5, 0.8, 1.0, 1.2, 2.0])
@pytest.mark.parametrize("condition", ["h < 0", "h <= 0", "h < 0 and v < 0", "0 > h"])
@pytest.mark.parametrize("value", ["-0.7*pre(v)", "-pre(v)", "2"])
def test_a_ball_that_bounces(condition: str, value: str, stop: float) -> None:
    assert told(condition, value, stop) == []


def test_what_is_slowed_down_on_its_way_lacks_a_minus() -> None:
    (message,) = told("h <= 0", "0.5*pre(v)", 1.0)
    assert "`reinit` of `v` keeps its direction" in message


def test_what_becomes_faster_may_pass() -> None:
    assert told("h <= 0", "2*pre(v)", 1.0) == []
