"""A run in which nothing moves is told, and no other one."""

from __future__ import annotations

import pytest

import planarc

HINGED = """model Hinged
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world;
  Joints.Revolute hinge(phi(start=PHI, fixed=true), w(start=SPEED, fixed=true));
  Parts.Body body(m=1, I=0.1, r_CM={ARM, 0});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, body.frame_a);
end Hinged;
"""


def told(text: str) -> list[str]:
    warnings = planarc.load(text).simulate(2.0).warnings
    return [w.message for w in warnings if w.code == "R451"]


def hinged(phi: float = 0.5, w: float = 0.0, r: float = 0.0) -> str:
    return HINGED.replace("PHI", repr(phi)).replace("SPEED", repr(w)).replace("ARM", repr(r))


def test_a_weight_on_the_axis_turns_nothing() -> None:
    (message,) = told(hinged())
    assert message == "nothing moves from t = 0 to 2 s: `hinge`, `body` stand still"


@pytest.mark.parametrize("values", [{"w": 1e-6}, {"r": 1e-3}, {"phi": 1.57, "r": 0.3}])
def test_what_moves_ever_so_little_is_not_told(values: dict[str, float]) -> None:
    assert told(hinged(**values)) == []


def test_what_only_others_drive_is_not_told() -> None:
    driven = """model Driven
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world(g=0);
  Joints.Prismatic belt(n={1, 0}, drivenFlange=true);
  Modelica.Mechanics.Translational.Sources.ConstantSpeed speed(v_fixed=1);
  Joints.Revolute hinge(phi(fixed=true), w(fixed=true));
  Parts.Body body(m=1, I=0.1);
equation
  connect(speed.flange, belt.axis);
  connect(world.frame_b, belt.frame_a);
  connect(belt.frame_b, hinge.frame_a);
  connect(hinge.frame_b, body.frame_a);
end Driven;
"""
    assert told(driven) == []


def test_a_model_without_mechanics_is_not_meant() -> None:
    assert (
        told("model Rest\n  Real x(start=1, fixed=true);\nequation\n  der(x) = 0;\nend Rest;\n")
        == []
    )
