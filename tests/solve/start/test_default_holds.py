"""A start that a library holds by itself gives way to the one that somebody wrote."""

from __future__ import annotations

import pytest

import planarc

DRIVEN = """model Driven
  inner PlanarMultiBody.World world;
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed motor(w_fixed=20MOTOR);
  PlanarMultiBody.Joints.Revolute hinge(drivenFlange=trueHINGE);
  PlanarMultiBody.Parts.BodyShape crank(r={0.2, 0}, m=1, I=0.01);
equation
  connect(motor.flange, hinge.axis);
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, crank.frame_a);
end Driven;
"""


def start_of(motor: str, hinge: str) -> float:
    model = planarc.load(DRIVEN.replace("MOTOR", motor).replace("HINGE", hinge))
    return float(model.simulate(0.1)["hinge.phi"][0])


@pytest.mark.parametrize(
    "motor, hinge, start",
    [
        ("", "", 0.0),
        ("", ", phi(start=0.3, fixed=true)", 0.3),
        ("", ", phi(start=0.3)", 0.3),
        (", phi(start=0.2)", "", 0.2),
        (", phi(start=0.2, fixed=true)", ", phi(start=0.3)", 0.2),
    ],
)
def test_who_says_where_a_shaft_starts(motor: str, hinge: str, start: float) -> None:
    assert start_of(motor, hinge) == pytest.approx(start)


def test_two_that_somebody_wrote_must_agree() -> None:
    with pytest.raises(planarc.PlanarcError, match="are held at starts that disagree"):
        start_of(", phi(start=0.2, fixed=true)", ", phi(start=0.3, fixed=true)")
