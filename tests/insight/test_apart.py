"""Unlike mechanisms are told that do not act on each other; a signal or a force is an action."""

from __future__ import annotations

import pytest

import planarc

CRANE = """model Crane
  import PlanarMultiBody.*;
  inner World world;
  Joints.Prismatic rail(drivenFlange=true, s(fixed=true), v(fixed=true));
  Parts.Body trolley(m=2, I=0.05);
  Modelica.Mechanics.Translational.Sources.Force push;
  Joints.Revolute hinge(phi(start=-1.2, fixed=true), w(fixed=true));
  Parts.BodyShape load(r={0.8, 0}, m=0.3, I=0.016);
  PARTS
equation
  connect(world.frame_b, rail.frame_a);
  connect(rail.frame_b, trolley.frame_a);
  connect(push.flange, rail.axis);
  connect(hinge.frame_b, load.frame_a);
  EQUATIONS
end Crane;
"""
APART = "push.f = 1; connect(world.frame_b, hinge.frame_a);"


def told(equations: str, parts: str = "") -> list[str]:
    text = CRANE.replace("PARTS", parts).replace("EQUATIONS", equations)
    return [w.message for w in planarc.load(text).warnings if w.code == "S327"]


def test_a_load_beside_its_trolley_is_told() -> None:
    (message,) = told(APART)
    assert message == (
        "the mechanism of `hinge` and `load` and that of `rail` and `trolley` do not act on each "
        "other"
    )


@pytest.mark.parametrize(
    ("equations", "parts"),
    [
        ("push.f = 1; connect(trolley.frame_a, hinge.frame_a);", ""),
        ("push.f = -5*hinge.phi; connect(world.frame_b, hinge.frame_a);", ""),
        (
            f"{APART} connect(trolley.frame_a, rope.frame_a); connect(rope.frame_b, load.frame_b);",
            "Forces.Spring rope(c=10, s_unstretched=0.1);",
        ),
        (f"{APART} when load.frame_b.r[1] > rail.s then reinit(rail.v, 0); end when;", ""),
    ],
)
def test_what_acts_on_the_other_is_not_told(equations: str, parts: str) -> None:
    assert told(equations, parts) == []


def test_alike_mechanisms_are_compared_with_each_other() -> None:
    text = """model Two
      import PlanarMultiBody.*;
      inner World world;
      Joints.Revolute one(phi(start=-1.2, fixed=true), w(fixed=true));
      Joints.Revolute two(phi(start=-1.1, fixed=true), w(fixed=true));
      Parts.BodyShape light(r={0.8, 0}, m=0.3, I=0.016), heavy(r={0.8, 0}, m=3, I=0.16);
    equation
      connect(world.frame_b, one.frame_a);
      connect(one.frame_b, light.frame_a);
      connect(world.frame_b, two.frame_a);
      connect(two.frame_b, heavy.frame_a);
    end Two;"""
    assert planarc.load(text).warnings == ()
