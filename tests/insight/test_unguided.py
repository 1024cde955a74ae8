"""A flat follower that nothing guides is told, and contacts with an open frame; no others are."""

from __future__ import annotations

import pytest

import planarc

CAM = """model Cam
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute shaft(drivenFlange=true);
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed motor(w_fixed=5);
  Parts.Body cam(m=2, I=0.01), plunger(m=0.5, I=1e-3);
  Joints.CurveCurveJoint contact(redeclare Curves.Ellipse curve1(a=0.12, b=0.09),
    redeclare Curves.CURVE curve2, s1(start=0.2));
  MORE
equation
  connect(world.frame_b, shaft.frame_a);
  connect(motor.flange, shaft.axis);
  connect(shaft.frame_b, cam.frame_a);
  connect(shaft.frame_b, contact.frame_a);
  connect(contact.frame_b, plunger.frame_a);
  CONNECT
end Cam;
"""
GUIDE = "connect(world.frame_b, guide.frame_a); connect(guide.frame_b, plunger.frame_a);"

BALL = """model Ball
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body ball(m=1, I=0.01, r(start={0, 1}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact floor(redeclare Contacts.CONTOUR contour1,
    redeclare Contacts.HalfPlane contour2);
equation
  connect(ball.frame_a, floor.frame_a);
  CONNECT
end Ball;
"""


def told(text: str) -> list[str]:
    return [w.message for w in planarc.load(text).warnings if w.code == "S323"]


def cam(curve: str, more: str = "", connect: str = "") -> list[str]:
    return told(CAM.replace("CURVE", curve).replace("MORE", more).replace("CONNECT", connect))


def test_a_flat_plunger_without_a_guide_is_told() -> None:
    (message,) = cam("StraightLine")
    assert message.startswith("`contact` alone holds `plunger`")


@pytest.mark.parametrize(
    ("curve", "more", "connect"),
    [
        ("StraightLine", "Joints.Prismatic guide(n={0, 1});", GUIDE),
        ("Circle(R=0.02)", "", ""),  # a ball that rolls on what turns
    ],
)
def test_what_is_guided_or_round_is_not_told(curve: str, more: str, connect: str) -> None:
    kind, _, modifier = curve.partition("(")
    text = CAM.replace(
        "CURVE curve2", f"{kind} curve2({modifier}" if modifier else f"{kind} curve2"
    )
    assert told(text.replace("MORE", more).replace("CONNECT", connect)) == []


def test_a_contact_with_an_open_frame_is_told_once() -> None:
    corners = "Polygon contour1(vertices=[-0.2,-0.2; 0.2,-0.2; 0.2,0.2; -0.2,0.2])"
    text = BALL.replace("CONTOUR contour1", corners)
    (message,) = told(text.replace("CONNECT", ""))
    assert message.startswith("`floor.frame_b` is connected to nothing")
    assert told(text.replace("CONNECT", "connect(world.frame_b, floor.frame_b);")) == []
