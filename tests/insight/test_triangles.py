"""Hinges of a rigid triangle are told where one side was put together, and no truss is."""

from __future__ import annotations

import planarc

FOUR_BAR = """model FourBar
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute A(phi(start=1, fixed=true), w(fixed=true));
  Joints.Revolute B, C, D;
  Parts.BodyShape crank(r={0.3, 0}, m=1, I=0.01);
  Parts.BodyShape coupler(r={0.8, 0}, m=1, I=0.05);
  Parts.BodyShape rocker(r={0.6, 0}, m=1, I=0.03);
  Parts.FixedTranslation bed(r={0.9, 0});
equation
  connect(world.frame_b, A.frame_a);
  connect(A.frame_b, crank.frame_a);
  connect(crank.frame_b, B.frame_a);
  connect(B.frame_b, coupler.frame_a);
  connect(coupler.frame_b, C.frame_a);
  connect(C.frame_b, rocker.frame_b);
  connect(rocker.frame_a, D.frame_a);
  connect(D.frame_b, bed.frame_b);
  connect(bed.frame_a, WHERE);
end FourBar;
"""
JIB = """model Jib
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute base(phi(start=0.3, fixed=true), w(fixed=true));
  Joints.Revolute A, B, C;
  Parts.BodyShape mast(r={0, 0.5}, m=1, I=0.02);
  Parts.BodyShape lower(r={1, 0}, m=1, I=0.08);
  Parts.BodyShape upper(r={1.118, 0}, m=1, I=0.1);
equation
  connect(world.frame_b, base.frame_a);
  connect(base.frame_b, mast.frame_a);
  connect(mast.frame_a, A.frame_a);
  connect(A.frame_b, lower.frame_a);
  connect(mast.frame_b, B.frame_a);
  connect(B.frame_b, upper.frame_a);
  connect(upper.frame_b, C.frame_a);
  connect(C.frame_b, lower.frame_b);
end Jib;
"""


def told(text: str) -> list[str]:
    return [w.message for w in planarc.load(text).warnings]


def test_a_bed_on_the_moving_side_of_the_crank_is_told() -> None:
    assert told(FOUR_BAR.replace("WHERE", "A.frame_b")) == [
        "`B`, `C` and `D` cannot turn: their loop is a rigid triangle, of which `crank` and `bed` "
        "are one side"
    ]
    assert told(FOUR_BAR.replace("WHERE", "A.frame_a")) == []


def test_a_truss_that_turns_is_not_told() -> None:
    assert told(JIB) == []
