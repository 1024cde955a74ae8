"""Sliding parts: closed forms, signs of sources and sensors, lengths of rods."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

HEAD = """
  import T = Modelica.Mechanics.Translational;
"""


@pytest.fixture
def slide(run: Callable[..., Any]) -> Callable[..., Any]:
    return lambda body, **options: run(HEAD + body, **options)


def test_damped_oscillation(slide: Callable[..., Any]) -> None:
    result = slide(
        """
  T.Components.Fixed wall(s0=-0.5);
  T.Components.Spring spring(c=8, s_rel0=0.3);
  T.Components.Damper damper(d=0.4);
  T.Components.Mass mass(m=0.5, L=0.2, s(start=0.6, fixed=true), v(start=0, fixed=true));
equation
  connect(wall.flange, spring.flange_a);
  connect(wall.flange, damper.flange_a);
  connect(spring.flange_b, mass.flange_a);
  connect(damper.flange_b, mass.flange_a);
""",
        stop=3.0,
    )
    t, rest = result.time, -0.5 + 0.3 + 0.1
    decay, w0 = 0.4 / (2 * 0.5), np.sqrt(8 / 0.5)
    w = np.sqrt(w0**2 - decay**2)
    motion = np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    np.testing.assert_allclose(result["mass.s"], rest + 0.7 * motion, atol=1e-7)
    lost = 0.4 * result["mass.v"] ** 2
    np.testing.assert_allclose(result["damper.lossPower"], lost, atol=1e-12)


def test_a_spring_and_damper_in_one_is_both(slide: Callable[..., Any]) -> None:
    parts = """
  T.Components.SpringDamper both(c=8, d=0.4, s_rel0=0.3);
  T.Components.Mass mass(m=0.5, s(start=0.6, fixed=true), v(start=1, fixed=true));
  T.Components.Fixed wall;
equation
  connect(wall.flange, both.flange_a);
  connect(both.flange_b, mass.flange_a);
"""
    result = slide(parts)
    force = 8 * (result["mass.s"] - 0.3) + 0.4 * result["mass.v"]
    np.testing.assert_allclose(result["both.f"], force, atol=1e-10)
    np.testing.assert_allclose(-0.5 * result["mass.a"], force, atol=1e-9)


def test_a_rod_passes_forces_and_keeps_its_length(slide: Callable[..., Any]) -> None:
    result = slide(
        """
  T.Sources.ConstantForce push(f_constant=3);
  T.Components.Rod rod(L=0.4);
  T.Sensors.ForceSensor force;
  T.Components.Mass mass(m=2, L=0.2, s(start=0, fixed=true), v(start=0, fixed=true));
equation
  connect(push.flange, rod.flange_a);
  connect(rod.flange_b, force.flange_a);
  connect(force.flange_b, mass.flange_a);
"""
    )
    np.testing.assert_allclose(result["mass.s"], 0.75 * result.time**2, atol=1e-8)
    np.testing.assert_allclose(result["push.s"], result["mass.s"] - 0.1 - 0.4, atol=1e-9)
    np.testing.assert_allclose(result["force.f"], 3, atol=1e-9)


@pytest.mark.parametrize(
    ("source", "signal", "way"),
    [
        ("T.Sources.Position drive(exact=true)", "s_ref", lambda t: t**3),
        ("T.Sources.Speed drive(exact=true)", "v_ref", lambda t: t**4 / 4),
        ("T.Sources.Accelerate drive", "a_ref", lambda t: t**5 / 20),
    ],
)
def test_prescribed_motion(
    slide: Callable[..., Any], source: str, signal: str, way: Callable[[Any], Any]
) -> None:
    result = slide(
        f"""
  {source};
  T.Components.Mass mass(m=2);
  T.Sensors.MultiSensor load;
equation
  drive.{signal} = time^3;
  connect(drive.flange, load.flange_a);
  connect(load.flange_b, mass.flange_a);
"""
    )
    np.testing.assert_allclose(result["mass.s"], way(result.time), atol=1e-7)
    np.testing.assert_allclose(result["load.f"], 2 * result["mass.a"], atol=1e-7)
    power = result["load.f"] * result["mass.v"]
    np.testing.assert_allclose(result["load.power"], power, atol=1e-7)


def test_forces_have_the_sign_of_the_motion_that_they_cause(slide: Callable[..., Any]) -> None:
    result = slide(
        """
  T.Sources.Force2 between;
  T.Components.Mass a(m=1, s(start=0, fixed=true), v(start=0, fixed=true));
  T.Components.Mass b(m=2, s(start=0, fixed=true), v(start=0, fixed=true));
  T.Sources.ForceStep step(stepForce=4, startTime=0.5);
  T.Components.Mass c(m=2, s(start=0, fixed=true), v(start=0, fixed=true));
  T.Sources.QuadraticSpeedDependentForce drag(f_nominal=-1, ForceDirection=false, v_nominal=1);
  T.Components.Mass d(m=1, s(start=0, fixed=true), v(start=1, fixed=true));
equation
  between.f = 6;
  connect(between.flange_a, a.flange_a);
  connect(between.flange_b, b.flange_a);
  connect(step.flange, c.flange_a);
  connect(drag.flange, d.flange_a);
"""
    )
    t = result.time
    np.testing.assert_allclose(result["a.v"], -6 * t, atol=1e-8)
    np.testing.assert_allclose(result["b.v"], 3 * t, atol=1e-8)
    np.testing.assert_allclose(result["c.v"], 2 * np.maximum(t - 0.5, 0), atol=1e-7)
    np.testing.assert_allclose(result["d.v"], 1 / (1 + t), atol=1e-7)


def test_sensors_measure_without_load(slide: Callable[..., Any]) -> None:
    result = slide(
        """
  T.Components.Mass a(m=1, s(start=0, fixed=true), v(start=2, fixed=true));
  T.Components.Mass b(m=1, s(start=1, fixed=true), v(start=5, fixed=true));
  T.Sensors.PositionSensor position;
  T.Sensors.SpeedSensor speed;
  T.Sensors.RelPositionSensor relPosition;
  T.Sensors.RelSpeedSensor relSpeed;
equation
  connect(a.flange_a, position.flange);
  connect(a.flange_a, speed.flange);
  connect(a.flange_b, relPosition.flange_a);
  connect(b.flange_a, relPosition.flange_b);
  connect(a.flange_b, relSpeed.flange_a);
  connect(b.flange_a, relSpeed.flange_b);
"""
    )
    measured = {"position.s": 2, "speed.v": 2, "relPosition.s_rel": 4, "relSpeed.v_rel": 3}
    for name, value in measured.items():
        assert result[name][-1] == pytest.approx(value, abs=1e-8), name
