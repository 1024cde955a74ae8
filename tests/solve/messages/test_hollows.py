"""A roller that does not fit the hollows of its cam is told where it jams."""

from __future__ import annotations

import pytest

import planarc

CAM = """model Cam
  import PlanarMultiBody.*;
  inner World world;
  Joints.Revolute hinge(drivenFlange=true);
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed motor(w_fixed=1);
  Joints.CurveCurveJoint contact(
    redeclare Curves.SinusEllipse curve1(a=0.1, b=0.1, A=%s, k=5), %s, s1(start=0.31));
  Joints.Prismatic slide(n={0, 1}, s(start=%s));
  Parts.Body follower(m=0.5);
equation
  connect(motor.flange, hinge.axis);
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, contact.frame_a);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, follower.frame_a);
  connect(slide.frame_b, contact.frame_b);
end Cam;
"""
STRAIGHT = "redeclare Curves.StraightLine curve2(s_min=-0.1, s_max=0.1)"


@pytest.mark.parametrize(
    ("waves", "roller", "start", "said"),
    [
        (0.1, "curve2(R=0.08)", 0.18, "a radius of 0.08 m, and does not fit the hollows"),
        (0.06, STRAIGHT, 0.102, "is straight and does not fit the hollows"),
    ],
)
def test_too_big(waves: float, roller: str, start: float, said: str) -> None:
    with pytest.raises(planarc.PlanarcError, match="R422") as caught:
        planarc.load(CAM % (waves, roller, start)).simulate(7.0)
    hint = caught.value.diagnostics[-1].hint
    assert hint is not None and said in hint


@pytest.mark.parametrize(
    ("waves", "roller", "start"),
    [(0.1, "curve2(R=0.04)", 0.14), (0.02, STRAIGHT, 0.102)],
)
def test_what_fits_runs(waves: float, roller: str, start: float) -> None:
    planarc.load(CAM % (waves, roller, start)).simulate(7.0)
