"""Joints: closed forms, reactions, signs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]


@pytest.mark.parametrize("axis", ["{1, 0}", "{3, 0}"])
def test_a_block_slides_down_an_incline(run: Run, axis: str) -> None:
    result = run(
        f"""
  Parts.FixedRotation incline(angle=-0.5);
  Joints.Prismatic slide(n={axis}, s(start=0.2, fixed=true), v(start=1, fixed=true));
  Parts.Body load(m=2, I=0.1);
equation
  connect(world.frame_b, incline.frame_a);
  connect(incline.frame_b, slide.frame_a);
  connect(slide.frame_b, load.frame_a);
"""
    )
    t, slope, weight = result.time, 9.81 * np.sin(0.5), 2 * 9.81
    s = 0.2 + t + slope / 2 * t**2
    np.testing.assert_allclose(result["slide.s"], s, atol=1e-8)
    np.testing.assert_allclose(result["slide.a"], slope, atol=1e-9)
    # The ground carries the normal force, and its moment about the foot of the slide.
    normal = weight * np.cos(0.5) * np.array([np.sin(0.5), np.cos(0.5)])
    np.testing.assert_allclose(result["slide.frame_a.f[1]"], normal[0], atol=1e-8)
    np.testing.assert_allclose(result["slide.frame_a.f[2]"], normal[1], atol=1e-8)
    np.testing.assert_allclose(result["slide.frame_a.t"], weight * np.cos(0.5) * s, atol=1e-7)


def test_a_hinge_passes_force_and_no_torque(run: Run) -> None:
    result = run(
        """
  Joints.Revolute hinge(phi(start=-0.4, fixed=true), w(start=3, fixed=true));
  Parts.Body rod(m=2, I=0.1, r_CM={0.5, 0});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
"""
    )
    np.testing.assert_allclose(result["hinge.frame_a.t"], 0, atol=1e-12)
    for i, gravity in ((1, 0.0), (2, 9.81)):
        force = 2 * (result[f"rod.a_CM[{i}]"] + gravity)
        np.testing.assert_allclose(result[f"hinge.frame_a.f[{i}]"], force, atol=1e-7)


def test_mirroring_a_double_pendulum_mirrors_its_motion(run: Run) -> None:
    def swing(side: int) -> Any:
        return run(
            f"""
  Joints.Revolute a(phi(start=-1.5707963267948966 + ({side})*0.9, fixed=true), w(fixed=true));
  Joints.Revolute b(phi(start={0.5 * side}, fixed=true), w(fixed=true));
  Parts.BodyShape upper(r={{0.5, 0}}, r_CM={{0.2, {0.1 * side}}}, m=1.5, I=0.03);
  Parts.BodyShape lower(r={{0.6, 0}}, r_CM={{0.3, {0.05 * side}}}, m=1, I=0.03);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, upper.frame_a);
  connect(upper.frame_b, b.frame_a);
  connect(b.frame_b, lower.frame_a);
"""
        )

    left, right = swing(-1), swing(1)
    np.testing.assert_allclose(left["b.phi"], -right["b.phi"], atol=1e-7)
    np.testing.assert_allclose(left["lower.frame_b.r[1]"], -right["lower.frame_b.r[1]"], atol=1e-7)
    np.testing.assert_allclose(left["a.frame_a.f[2]"], right["a.frame_a.f[2]"], atol=1e-5)


def test_a_rod_with_mass_is_a_point_mass_on_a_rod_between_hinges(run: Run) -> None:
    def crank_slider(rod: str, connections: str) -> Any:
        return run(
            f"""
  Joints.Revolute main(phi(start=1, fixed=true), w(start=2, fixed=true));
  Parts.BodyShape crank(r={{0.3, 0}}, m=1, I=0.01);
  Joints.Prismatic slide(s(start=0.9));
  Parts.Body slider(m=1.5, I=0.01);
  {rod}
equation
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, crank.frame_a);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, slider.frame_a);
  {connections}
"""
        )

    one = crank_slider(
        "Joints.JointRRWithMass rod(L=0.8, m=0.7, lengthFraction=0.3);",
        "connect(crank.frame_b, rod.frame_a); connect(rod.frame_b, slider.frame_a);",
    )
    other = crank_slider(
        """
  Joints.Revolute a(phi(start=-1.3)), b(phi(start=0.3));
  Parts.FixedTranslation near(r={0.24, 0}), far(r={0.56, 0});
  Parts.PointMass mass(m=0.7);
""",
        """
  connect(crank.frame_b, a.frame_a);
  connect(a.frame_b, near.frame_a);
  connect(near.frame_b, mass.frame_a);
  connect(near.frame_b, far.frame_a);
  connect(far.frame_b, b.frame_a);
  connect(b.frame_b, slider.frame_a);
""",
    )
    np.testing.assert_allclose(one["slide.s"], other["slide.s"], atol=1e-6)
    for i in (1, 2):
        force = other[f"a.frame_a.f[{i}]"]
        np.testing.assert_allclose(one[f"rod.frame_a.f[{i}]"], force, atol=1e-4)
