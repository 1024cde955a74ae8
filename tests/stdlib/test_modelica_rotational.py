"""Shafts: closed forms of oscillators and gears, balance of power, signs of sources and sensors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

HEAD = """
  import R = Modelica.Mechanics.Rotational;
"""


@pytest.fixture
def shaft(run: Callable[..., Any]) -> Callable[..., Any]:
    return lambda body, **options: run(HEAD + body, **options)


def test_damped_oscillation(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Components.Fixed wall(phi0=0.2);
  R.Components.SpringDamper spring(c=8, d=0.4, phi_rel0=0.1);
  R.Components.Inertia wheel(J=0.5, phi(start=1, fixed=true), w(start=0, fixed=true));
equation
  connect(wall.flange, spring.flange_a);
  connect(spring.flange_b, wheel.flange_a);
""",
        stop=3.0,
    )
    t, rest, amplitude = result.time, 0.3, 0.7
    decay, w0 = 0.4 / (2 * 0.5), np.sqrt(8 / 0.5)
    w = np.sqrt(w0**2 - decay**2)
    motion = np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    np.testing.assert_allclose(result["wheel.phi"], rest + amplitude * motion, atol=1e-7)
    lost = 0.4 * result["wheel.w"] ** 2
    np.testing.assert_allclose(result["spring.lossPower"], lost, atol=1e-12)


def test_two_inertias_turn_about_their_common_rest(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Components.Inertia a(J=1, phi(start=0.3, fixed=true), w(start=0, fixed=true));
  R.Components.Spring spring(c=6);
  R.Components.Inertia b(J=2, phi(start=0, fixed=true), w(start=0, fixed=true));
equation
  connect(a.flange_b, spring.flange_a);
  connect(spring.flange_b, b.flange_a);
""",
        stop=2.0,
    )
    w = np.sqrt(6 * (1 / 1 + 1 / 2))
    np.testing.assert_allclose(result["spring.phi_rel"], -0.3 * np.cos(w * result.time), atol=1e-7)
    np.testing.assert_allclose(result["a.w"] + 2 * result["b.w"], 0, atol=1e-8)


def test_a_gear_keeps_power_and_loads_its_housing(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Sources.ConstantTorque motor(tau_constant=2);
  R.Components.IdealGear gear(ratio=-4, useSupport=true);
  R.Components.Inertia load(J=8, phi(start=0, fixed=true), w(start=0, fixed=true));
  R.Components.Fixed housing;
equation
  connect(motor.flange, gear.flange_a);
  connect(gear.flange_b, load.flange_a);
  connect(gear.support, housing.flange);
"""
    )
    np.testing.assert_allclose(result["load.w"], -4 * 2 / 8 * result.time, atol=1e-8)
    np.testing.assert_allclose(result["motor.w"], -4 * result["load.w"], atol=1e-8)
    power = 2 * result["motor.w"] - result["load.a"] * 8 * result["load.w"]
    np.testing.assert_allclose(power, 0, atol=1e-8)
    taken = result["gear.flange_a.tau"] + result["gear.flange_b.tau"]
    np.testing.assert_allclose(result["housing.flange.tau"], taken, atol=1e-12)
    np.testing.assert_allclose(taken, 2 + 4 * 2, atol=1e-12)


def test_a_planetary_gear_shares_torque_by_its_teeth(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Sources.ConstantSpeed sun(w_fixed=6);
  R.Sources.ConstantSpeed ring(w_fixed=-1);
  R.Components.IdealPlanetary gear(ratio=2);
  R.Components.Damper load(d=3);
  R.Components.Fixed wall;
equation
  connect(sun.flange, gear.sun);
  connect(ring.flange, gear.ring);
  connect(gear.carrier, load.flange_a);
  connect(load.flange_b, wall.flange);
"""
    )
    w = (6 + 2 * -1) / 3
    assert result["load.w_rel"][-1] == pytest.approx(-w)
    assert result["gear.carrier.tau"][-1] == pytest.approx(-3 * w)
    torques = [result[f"gear.{flange}.tau"][-1] for flange in ("sun", "ring", "carrier")]
    assert torques == pytest.approx([w, 2 * w, -3 * w])
    assert np.dot(torques, [6, -1, w]) == pytest.approx(0)


def test_backlash_passes_no_torque_until_it_is_used_up(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Components.Inertia a(J=1, phi(start=0, fixed=true), w(start=1, fixed=true));
  R.Components.ElastoBacklash mesh(c=100, d=0, b=0.4);
  R.Components.Inertia b(J=1, phi(start=0, fixed=true), w(start=0, fixed=true));
equation
  connect(a.flange_b, mesh.flange_a);
  connect(mesh.flange_b, b.flange_a);
""",
        stop=0.8,
    )
    # The gap is used up after 0.2 s; half a period of the contact later the wheels have swapped.
    half = np.pi / np.sqrt(2 * 100)
    touch, part = 0.2, 0.2 + half
    instants = [event.time for event in result.events]
    assert instants[0] == pytest.approx(touch, abs=1e-8)
    assert min(abs(t - part) for t in instants) < 1e-6
    free = result.time < touch - 1e-6
    assert np.all(result["mesh.tau"][free] == 0)
    after = (result.time > part + 1e-3) & (result.time < part + 0.3)
    np.testing.assert_allclose(result["a.w"][after], 0, atol=1e-6)
    np.testing.assert_allclose(result["b.w"][after], 1, atol=1e-6)


@pytest.mark.parametrize(
    ("source", "signal", "angle"),
    [
        ("R.Sources.Position drive(exact=true)", "phi_ref", lambda t: t**3),
        ("R.Sources.Speed drive(exact=true)", "w_ref", lambda t: t**4 / 4),
        ("R.Sources.Accelerate drive", "a_ref", lambda t: t**5 / 20),
    ],
)
def test_prescribed_motion(
    shaft: Callable[..., Any], source: str, signal: str, angle: Callable[[Any], Any]
) -> None:
    result = shaft(
        f"""
  {source};
  R.Components.Inertia wheel(J=2);
  R.Sensors.TorqueSensor torque;
equation
  drive.{signal} = time^3;
  connect(drive.flange, torque.flange_a);
  connect(torque.flange_b, wheel.flange_a);
"""
    )
    np.testing.assert_allclose(result["wheel.phi"], angle(result.time), atol=1e-7)
    np.testing.assert_allclose(result["torque.tau"], 2 * result["wheel.a"], atol=1e-7)


def test_a_filtered_position_follows_with_the_critical_frequency(
    shaft: Callable[..., Any],
) -> None:
    result = shaft(
        """
  R.Sources.Position drive(f_crit=5);
  R.Components.Inertia wheel(J=2);
equation
  drive.phi_ref = if time < 0.1 then 0 else 1;
  connect(drive.flange, wheel.flange_a);
"""
    )
    assert result["wheel.phi"][-1] == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(result["wheel.phi"][result.time < 0.1], 0, atol=1e-9)
    # Bessel: the overshoot is below one percent.
    assert 1 < np.max(result["wheel.phi"]) < 1.01


def test_known_motion_needs_no_derivative(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Sources.Move drive;
  R.Components.Inertia wheel(J=2);
equation
  drive.u = {sin(time), cos(time), -sin(time)};
  connect(drive.flange, wheel.flange_a);
"""
    )
    np.testing.assert_allclose(result["wheel.flange_a.tau"], -2 * np.sin(result.time), atol=1e-9)


def test_speed_dependent_torques_brake_both_ways(shaft: Callable[..., Any]) -> None:
    kinds = {
        "R.Sources.LinearSpeedDependentTorque": lambda w: -2 * w / 10,
        "R.Sources.QuadraticSpeedDependentTorque": lambda w: -2 * w * abs(w) / 100,
    }
    for kind, law in kinds.items():
        for speed in (5, -5):
            result = shaft(
                f"""
  {kind} load(tau_nominal=-2, w_nominal=10, TorqueDirection=false);
  R.Sources.ConstantSpeed drive(w_fixed={speed});
equation
  connect(drive.flange, load.flange);
"""
            )
            assert result["load.tau"][-1] == pytest.approx(law(speed))


def test_the_reaction_of_a_source_goes_to_its_support(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Sources.ConstantTorque motor(tau_constant=3, useSupport=true);
  R.Components.Inertia rotor(J=1, phi(start=0, fixed=true), w(start=0, fixed=true));
  R.Components.Inertia stator(J=2, phi(start=0, fixed=true), w(start=0, fixed=true));
equation
  connect(motor.flange, rotor.flange_a);
  connect(motor.support, stator.flange_a);
"""
    )
    np.testing.assert_allclose(result["rotor.w"], 3 * result.time, atol=1e-8)
    np.testing.assert_allclose(result["stator.w"], -1.5 * result.time, atol=1e-8)


def test_sensors_measure_without_load(shaft: Callable[..., Any]) -> None:
    result = shaft(
        """
  R.Components.Inertia a(J=1, phi(start=0, fixed=true), w(start=2, fixed=true));
  R.Components.Inertia b(J=1, phi(start=1, fixed=true), w(start=5, fixed=true));
  R.Sensors.AngleSensor angle;
  R.Sensors.SpeedSensor speed;
  R.Sensors.AccSensor acceleration;
  R.Sensors.RelAngleSensor relAngle;
  R.Sensors.RelSpeedSensor relSpeed;
  R.Sensors.RelAccSensor relAcceleration;
equation
  connect(a.flange_a, angle.flange);
  connect(a.flange_a, speed.flange);
  connect(a.flange_a, acceleration.flange);
  connect(a.flange_b, relAngle.flange_a);
  connect(b.flange_a, relAngle.flange_b);
  connect(a.flange_b, relSpeed.flange_a);
  connect(b.flange_a, relSpeed.flange_b);
  connect(a.flange_b, relAcceleration.flange_a);
  connect(b.flange_a, relAcceleration.flange_b);
"""
    )
    measured = {
        "angle.phi": 2,
        "speed.w": 2,
        "acceleration.a": 0,
        "relAngle.phi_rel": 1 + 3,
        "relSpeed.w_rel": 3,
        "relAcceleration.a_rel": 0,
    }
    for name, value in measured.items():
        assert result[name][-1] == pytest.approx(value, abs=1e-8), name


def test_turning_becomes_sliding(run: Callable[..., Any]) -> None:
    result = run(
        """
  Modelica.Mechanics.Rotational.Sources.ConstantTorque motor(tau_constant=3);
  Modelica.Mechanics.Rotational.Components.IdealRollingWheel wheel(radius=0.5);
  Modelica.Mechanics.Translational.Components.Mass cart(
    m=2, s(start=0, fixed=true), v(start=0, fixed=true));
equation
  connect(motor.flange, wheel.flangeR);
  connect(wheel.flangeT, cart.flange_a);
"""
    )
    np.testing.assert_allclose(result["cart.v"], 3 / 0.5 / 2 * result.time, atol=1e-8)


def test_a_negative_inertia_is_refused(shaft: Callable[..., Any]) -> None:
    result = shaft("  R.Components.Inertia wheel(J=-1);")
    assert "give J >= 0" in result.ended.message
