"""Line forces: oscillation and decay in closed form, action and reaction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Run = Callable[..., Any]

HANGING = """
  Joints.Prismatic slide(n={{0, -1}}, s(start=0.5, fixed=true), v(fixed=true));
  Parts.Body load(m=2, I=0.1);
  {elements}
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, load.frame_a);
  {connections}
"""


def hang(run: Run, *elements: str) -> Any:
    names = [element.split()[1].split("(")[0] for element in elements]
    return run(
        HANGING.format(
            elements=" ".join(f"{element};" for element in elements),
            connections=" ".join(
                f"connect(world.frame_b, {n}.frame_a); connect({n}.frame_b, load.frame_a);"
                for n in names
            ),
        )
    )


def test_a_mass_on_a_spring_oscillates(run: Run) -> None:
    result = hang(run, "Forces.Spring spring(c=200, s_unstretched=0.4)")
    rest, omega = 0.4 + 2 * 9.81 / 200, 10.0
    expected = rest + (0.5 - rest) * np.cos(omega * result.time)
    np.testing.assert_allclose(result["slide.s"], expected, atol=1e-7)
    np.testing.assert_allclose(result["spring.f"], 200 * (expected - 0.4), atol=1e-5)


def test_a_mass_on_a_damper_reaches_its_speed(run: Run) -> None:
    result = hang(run, "Forces.Damper damper(d=6)")
    expected = 2 * 9.81 / 6 * (1 - np.exp(-3 * result.time))
    np.testing.assert_allclose(result["slide.v"], expected, atol=1e-7)
    np.testing.assert_allclose(result["damper.lossPower"], 6 * expected**2, atol=1e-5)


def test_a_spring_damper_is_a_spring_and_a_damper(run: Run) -> None:
    one = hang(run, "Forces.SpringDamperParallel both(c=200, d=3, s_unstretched=0.4)")
    two = hang(run, "Forces.Spring spring(c=200, s_unstretched=0.4)", "Forces.Damper damper(d=3)")
    np.testing.assert_allclose(one["slide.s"], two["slide.s"], atol=1e-7)
    np.testing.assert_allclose(one["both.f"], two["spring.f"] + two["damper.f"], atol=1e-5)


def test_two_bodies_on_a_spring_keep_momentum_and_energy(run: Run) -> None:
    start = "r(start={{{}, {}}}, each fixed=true), v(start={{{}, {}}}, each fixed=true)"
    result = run(
        f"""
  Parts.Body a(m=1, I=0.1, r_CM={{0.1, 0}}, enforceStates=true, phi(fixed=true),
    w(start=1, fixed=true), {start.format(0, 0, 0.5, 0)});
  Parts.Body b(m=3, I=0.2, r_CM={{0, 0.2}}, enforceStates=true, phi(start=1, fixed=true),
    w(start=-2, fixed=true), {start.format(1, 0.5, 0, -0.3)});
  Forces.Spring spring(c=30, s_unstretched=0.8);
equation
  connect(a.frame_a, spring.frame_a);
  connect(spring.frame_b, b.frame_a);
""",
        stop=3.0,
        world="gravityType=Types.GravityTypes.NoGravity",
    )
    bodies = (("a", 1.0, 0.1), ("b", 3.0, 0.2))
    turning = 0.0
    energy = 15 * (result["spring.s"] - 0.8) ** 2
    for i in (1, 2):
        momentum = sum(m * result[f"{n}.v_CM[{i}]"] for n, m, _ in bodies)
        np.testing.assert_allclose(momentum, momentum[0], atol=1e-6)
    for n, m, inertia in bodies:
        x, y, u, v = (result[f"{n}.{q}"] for q in ("r_0CM[1]", "r_0CM[2]", "v_CM[1]", "v_CM[2]"))
        turning = turning + m * (x * v - y * u) + inertia * result[f"{n}.w"]
        energy = energy + m / 2 * (u**2 + v**2) + inertia / 2 * result[f"{n}.w"] ** 2
    np.testing.assert_allclose(turning, turning[0], atol=1e-6)
    np.testing.assert_allclose(energy, energy[0], atol=1e-6)
