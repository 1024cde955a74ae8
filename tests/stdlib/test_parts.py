"""Parts: statics against closed forms, and two constructions of the same thing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Run = Callable[..., Any]


def last(result: Any, *names: str) -> list[float]:
    return [float(result[name][-1]) for name in names]


def test_a_cantilever_carries_weight_and_moment(run: Run) -> None:
    result = run(
        """
  Parts.Fixed wall(r={1, 2}, phi=0.5);
  Parts.FixedTranslation rod(r={2, 1});
  Parts.FixedRotation bend(r={0.5, 0}, angle=0.4);
  Parts.Body load(m=3, I=0.2, r_CM={0.3, -0.2});
equation
  connect(wall.frame_b, rod.frame_a);
  connect(rod.frame_b, bend.frame_a);
  connect(bend.frame_b, load.frame_a);
"""
    )
    turn = lambda phi, v: np.array(  # noqa: E731
        [np.cos(phi) * v[0] - np.sin(phi) * v[1], np.sin(phi) * v[0] + np.cos(phi) * v[1]]
    )
    arm = turn(0.5, [2, 1]) + turn(0.5, [0.5, 0]) + turn(0.9, [0.3, -0.2])
    names = ("load.r_0CM[1]", "load.r_0CM[2]", "load.phi")
    np.testing.assert_allclose(last(result, *names), [*(np.array([1, 2]) + arm), 0.9])
    # What the wall does to the rod: it carries the weight and its moment.
    np.testing.assert_allclose(
        last(result, "rod.frame_a.f[1]", "rod.frame_a.f[2]", "rod.frame_a.t"),
        [0, 3 * 9.81, 3 * 9.81 * arm[0]],
        atol=1e-12,
    )


def test_what_enters_a_connection_leaves_it(run: Run) -> None:
    result = run(
        """
  Joints.Revolute hinge(phi(start=0.3, fixed=true), w(start=2, fixed=true));
  Parts.FixedTranslation rod(r={1, 0});
  Parts.Body near(m=1, I=0.1, r_CM={0.2, 0});
  Parts.Body far(m=2, I=0.1);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(hinge.frame_b, near.frame_a);
  connect(rod.frame_b, far.frame_a);
"""
    )
    for quantity in ("f[1]", "f[2]", "t"):
        meeting = [
            result[f"{c}.{quantity}"] for c in ("hinge.frame_b", "rod.frame_a", "near.frame_a")
        ]
        np.testing.assert_allclose(sum(meeting), 0, atol=1e-9)
        grounded = result[f"world.frame_b.{quantity}"] + result[f"hinge.frame_a.{quantity}"]
        np.testing.assert_allclose(grounded, 0, atol=1e-9)


def test_a_body_shape_is_a_body_and_a_rod(run: Run) -> None:
    start = "phi(start=0.4, fixed=true), w(fixed=true)"
    one = run(
        f"""
  Joints.Revolute a({start}), b({start});
  Parts.BodyShape upper(r={{0.5, 0}}, r_CM={{0.2, 0.1}}, m=1.5, I=0.03);
  Parts.BodyShape lower(r={{0.6, 0}}, m=1, I=0.03);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, upper.frame_a);
  connect(upper.frame_b, b.frame_a);
  connect(b.frame_b, lower.frame_a);
"""
    )
    other = run(
        f"""
  Joints.Revolute a({start}), b({start});
  Parts.FixedTranslation rod(r={{0.5, 0}});
  Parts.Body upper(r_CM={{0.2, 0.1}}, m=1.5, I=0.03);
  Parts.Body lower(r_CM={{0.3, 0}}, m=1, I=0.03);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, upper.frame_a);
  connect(a.frame_b, rod.frame_a);
  connect(rod.frame_b, b.frame_a);
  connect(b.frame_b, lower.frame_a);
"""
    )
    np.testing.assert_allclose(one["b.phi"], other["b.phi"], atol=1e-7)


def test_a_point_mass_is_a_body_without_inertia(run: Run) -> None:
    def swing(mass: str) -> Any:
        return run(
            f"""
  Joints.Revolute hinge(phi(start=0.5, fixed=true), w(fixed=true));
  Parts.FixedTranslation rod(r={{0.7, 0}});
  {mass};
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, mass.frame_a);
"""
        )

    one, other = swing("Parts.PointMass mass(m=2)"), swing("Parts.Body mass(m=2, I=0)")
    np.testing.assert_allclose(one["hinge.phi"], other["hinge.phi"], atol=1e-7)


def test_a_lone_point_mass_falls_with_its_angle_fixed(run: Run) -> None:
    result = run("  Parts.PointMass ball(m=2, fixAngle=true, r(start={0, 1}, each fixed=true));")
    np.testing.assert_allclose(result["ball.r[2]"], 1 - 9.81 / 2 * result.time**2, atol=1e-8)
    np.testing.assert_array_equal(result["ball.frame_a.phi"], 0)


def test_a_swinging_rod_keeps_its_energy(run: Run) -> None:
    result = run(
        """
  Joints.Revolute hinge(phi(start=0, fixed=true), w(fixed=true));
  Parts.Body rod(m=2, I=0.15, r_CM={0.6, 0.2});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
""",
        stop=5.0,
    )
    speed = np.hypot(result["rod.v_CM[1]"], result["rod.v_CM[2]"])
    energy = speed**2 + 0.15 / 2 * result["rod.w"] ** 2 + 2 * 9.81 * result["rod.r_0CM[2]"]
    np.testing.assert_allclose(energy, energy[0], atol=1e-5)
