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


LIFTS = """model Lifts
  import PlanarMultiBody.{Joints, Parts, Forces};
  inner PlanarMultiBody.World worldGRAVITY;
  Joints.Prismatic left(n={0, 1}, s(start=1, fixed=true), v(fixed=true));
  Joints.Prismatic right(AXISs(start=0, fixed=true), v(start=SPEED, fixed=true));
  Parts.Body cabin(m=400, I=60), weight(m=500, I=50);
  Forces.Spring rope(c=2e4, s_unstretched=1.2);
equation
  connect(world.frame_b, left.frame_a);
  connect(left.frame_b, cabin.frame_a);
  connect(world.frame_b, right.frame_a);
  connect(right.frame_b, weight.frame_a);
  connect(world.frame_b, rope.frame_a);
  connect(rope.frame_b, cabin.frame_a);
end Lifts;
"""


def lifts(axis: str = "", speed: float = 0.0, gravity: str = "") -> list[str]:
    text = LIFTS.replace("AXIS", axis).replace("SPEED", repr(speed)).replace("GRAVITY", gravity)
    found = [w for w in planarc.load(text).simulate(1.0).warnings if w.code == "R451"]
    return [f"{w.message}: {w.hint}" for w in found]


def test_a_slide_left_level_is_told_while_others_move() -> None:
    (message,) = lifts()
    assert message.startswith(
        "`right` stands still while others move: its axis is left at n={1, 0}"
    )
    assert "`right(n={0, 1})`" in message


@pytest.mark.parametrize(
    "values",
    [
        {"axis": "n={1, 0}, "},  # as it is written
        {"axis": "n={0, 1}, "},
        {"speed": 0.1},
        {"gravity": "(g=0)"},
        {"gravity": "(n={1, 0})"},
    ],
)
def test_a_slide_that_is_meant_so_is_not_told(values: dict[str, str]) -> None:
    assert lifts(**values) == []  # type: ignore[arg-type]
