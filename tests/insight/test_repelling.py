"""Control laws of the wrong sign are told, and no law that a user may well mean."""

from __future__ import annotations

import pytest

import planarc

CART = """model Cart
  import PlanarMultiBody.*;
  import Modelica.Mechanics.Translational;
  parameter Real k=400, d=80, s_ref=2;
  inner World world;
  Joints.Prismatic rail(n={1,0}, drivenFlange=true, s(start=0, fixed=true), v(fixed=true));
  Parts.Body trolley(m=2, I=0);
  Joints.Revolute hinge(phi(start=1.5, fixed=true), w(fixed=true));
  Parts.BodyShape pole(r={0.5,0}, m=0.1, I=0.002);
  Translational.Sources.Force motor;
  MORE
equation
  LAW
  connect(world.frame_b, rail.frame_a);
  connect(motor.flange, rail.axis);
  connect(rail.frame_b, trolley.frame_a);
  connect(rail.frame_b, hinge.frame_a);
  connect(hinge.frame_b, pole.frame_a);
end Cart;
"""


def told(law: str, more: str = "") -> list[str]:
    text = CART.replace("LAW", law).replace("MORE", more)
    return [w.message for w in planarc.load(text).warnings if w.code == "S325"]


@pytest.mark.parametrize(
    ("law", "more"),
    [
        ("motor.f = k*(rail.s - s_ref) - d*rail.v;", ""),
        ("motor.f = -k*(s_ref - rail.s) - d*rail.v;", ""),
        ("motor.f = k*rail.s - k*s_ref;", ""),
        ("motor.f = k*(rail.axis.s - goal.y);", "Modelica.Blocks.Sources.Step goal;"),
        ("e = rail.s - s_ref; u = k*e; motor.f = u - d*rail.v;", "Real e, u;"),
        (
            "motor.f = k*(sensor.s - s_ref); connect(sensor.flange, rail.axis);",
            "Translational.Sensors.PositionSensor sensor;",
        ),
    ],
)
def test_a_force_that_grows_with_its_coordinate_is_told(law: str, more: str) -> None:
    (message,) = told(law, more)
    assert message.startswith("`motor.f` drives `") and "away from where it is to go" in message


@pytest.mark.parametrize(
    ("law", "more"),
    [
        ("motor.f = k*(s_ref - rail.s) - d*rail.v;", ""),  # the right sign
        ("e = s_ref - rail.s; motor.f = k*e;", "Real e;"),
        ("motor.f = k*rail.s - d*rail.v;", ""),  # a spring that pushes, by itself
        ("motor.f = k*(rail.s - s_ref) + 90*(hinge.phi - 1.57);", ""),  # a pole that is held
        ("motor.f = k*(rail.s - s_ref)^3;", ""),  # no number says how it grows
        ("motor.f = -k*(rail.s - s_ref) + d*rail.v;", ""),  # what makes up for friction
        ("motor.f = k*(hinge.phi - 1.57);", ""),  # of another joint
    ],
)
def test_what_may_be_meant_is_not_told(law: str, more: str) -> None:
    assert told(law, more) == []
