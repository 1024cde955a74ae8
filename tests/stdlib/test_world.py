"""World: gravity as said, whatever the length of its direction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

STONE = """
  Parts.Body stone(m=2, I=0.1, enforceStates=true,
    r(start={1, 2}, each fixed=true), v(start={3, 1}, each fixed=true),
    phi(fixed=true), w(start=4, fixed=true));
"""

Run = Callable[..., Any]


def test_a_body_falls_on_a_parabola(run: Run) -> None:
    result = run(STONE)
    t = result.time
    np.testing.assert_allclose(result["stone.r[1]"], 1 + 3 * t, atol=1e-8)
    np.testing.assert_allclose(result["stone.r[2]"], 2 + t - 9.81 / 2 * t**2, atol=1e-8)
    np.testing.assert_allclose(result["stone.phi"], 4 * t, atol=1e-8)


def test_without_gravity_a_body_keeps_its_velocity(run: Run) -> None:
    result = run(STONE, world="gravityType=Types.GravityTypes.NoGravity")
    np.testing.assert_allclose(result["stone.r[2]"], 2 + result.time, atol=1e-8)


def test_the_direction_of_gravity_need_not_be_a_unit_vector(run: Run) -> None:
    result = run(STONE, world="g=5, n={6, 8}")
    np.testing.assert_allclose(result["stone.a[1]"], 3.0, atol=1e-8)
    np.testing.assert_allclose(result["stone.a[2]"], 4.0, atol=1e-8)


def test_point_gravity_follows_the_inverse_square(run: Run) -> None:
    result = run(STONE, stop=0.1, world="gravityType=Types.GravityTypes.PointGravity, mu=20")
    r = np.array([result["stone.r[1]"], result["stone.r[2]"]])
    a = np.array([result["stone.a[1]"], result["stone.a[2]"]])
    np.testing.assert_allclose(a, -20 * r / np.hypot(*r) ** 3, rtol=1e-9)


def test_a_model_may_bring_its_own_gravity(run: Run) -> None:
    result = run(
        """
  function buoyant
    extends PlanarMultiBody.Interfaces.partialGravityAcceleration;
  algorithm
    gravity := {0, -2*r[2]};
  end buoyant;
  inner World world(redeclare function gravityAcceleration = buoyant);
"""
        + STONE
    )
    height = 2 * np.cos(np.sqrt(2) * result.time) + np.sin(np.sqrt(2) * result.time) / np.sqrt(2)
    np.testing.assert_allclose(result["stone.r[2]"], height, atol=1e-7)


@pytest.mark.parametrize("angle", [0.7, 2.5])
def test_turning_the_whole_model_changes_nothing(run: Run, angle: float) -> None:
    def swing(turn: float) -> Any:
        c, s = np.cos(turn), np.sin(turn)
        return run(
            f"""
  Parts.Fixed bearing(r={{{c}, {s}}}, phi={turn});
  Joints.Revolute hinge(phi(start=0.3, fixed=true), w(start=1, fixed=true));
  Parts.Body rod(m=2, I=0.1, r_CM={{0.4, 0.1}});
equation
  connect(bearing.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
""",
            world=f"n={{{s}, {-c}}}",
        )

    straight, turned = swing(0.0), swing(angle)
    np.testing.assert_allclose(turned["hinge.phi"], straight["hinge.phi"], atol=1e-7)
    force = np.array([straight["hinge.frame_a.f[1]"], straight["hinge.frame_a.f[2]"]])
    c, s = np.cos(angle), np.sin(angle)
    expected = np.array([[c, -s], [s, c]]) @ force
    np.testing.assert_allclose(turned["hinge.frame_a.f[1]"], expected[0], atol=1e-5)
    np.testing.assert_allclose(turned["hinge.frame_a.f[2]"], expected[1], atol=1e-5)
