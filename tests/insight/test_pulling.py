"""A contact that pulls is told where `inContact` tells it to the model alone."""

from __future__ import annotations

import math

import pytest

import planarc

#: A disc of radius 1 cm turns about a point e off its centre, under a flat tappet of 1 kg. Its
#: height is R + e*sin(w*t), so that it is pressed on where g > e*w^2*sin(w*t).
TAPPET = """model M
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute shaft(drivenFlange=true, phi(start=0, fixed=true));
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed belt(w_fixed=10, useSupport=false);
  Parts.FixedTranslation arm(r={0.005, 0});
  Joints.CurveCurveJoint tappet(
    redeclare Curves.Circle curve1(R=0.01),
    redeclare Curves.StraightLine curve2(s_min=-0.1, s_max=0.1),
    detectSeparation=DETECT, s1(start=0.03));
  Joints.Prismatic guide(n={0, 1}, s(start=0.01));
  Parts.Body valve(m=1, I=0);
equation
  connect(world.frame_b, shaft.frame_a);
  connect(belt.flange, shaft.axis);
  connect(shaft.frame_b, arm.frame_a);
  connect(arm.frame_b, tappet.frame_a);
  connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, tappet.frame_b);
  connect(guide.frame_b, valve.frame_a);
  MORE
end M;
"""


def told(speed: float, detect: str = "true", more: str = "", turns: float = 1.0) -> list[str]:
    text = TAPPET.replace("DETECT", detect).replace("MORE", more)
    text = text.replace("w_fixed=10", f"w_fixed={speed!r}")
    run = planarc.load(text).simulate(2 * math.pi * turns / speed, intervals=2000)
    return [w.message for w in run.warnings if w.code == "R455"]


def test_the_share_is_that_of_the_closed_form() -> None:
    """sin > g/(e*w^2) for pi - 2*asin(g/(e*w^2)) of each turn; `e*w^2` is 2*g here."""
    (message,) = told(math.sqrt(2 * 9.80665 / 0.005))
    assert message.startswith("the contact of `tappet` pulls for 33% of the run, at first at t = ")


@pytest.mark.parametrize(
    "given",
    [
        {"speed": 40.0},  # e*w^2 is below g
        {"speed": 80.0, "detect": "false"},  # its own assertion tells it
        {"speed": 80.0, "turns": 0.0},
        {"speed": 80.0, "more": 'when not tappet.inContact then terminate("off"); end when;'},
    ],
)
def test_what_presses_or_ends_the_run_is_not_told(given: dict[str, object]) -> None:
    assert told(**given) == []  # type: ignore[arg-type]
