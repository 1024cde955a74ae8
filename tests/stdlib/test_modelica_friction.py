"""Coulomb friction: break-away, sliding, sticking again, clutches, brakes and hard stops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

HEAD = """
  import R = Modelica.Mechanics.Rotational;
  import T = Modelica.Mechanics.Translational;
"""


@pytest.fixture
def rub(run: Callable[..., Any]) -> Callable[..., Any]:
    return lambda body, **options: run(HEAD + body, **options)


def modes(result: Any, name: str) -> list[int]:
    """The modes that a friction passes through."""
    values = result[f"{name}.mode"]
    return [int(values[0]), *(int(v) for v in values[1:][np.diff(values) != 0])]


def test_a_shaft_breaks_away_slides_and_sticks_again(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  R.Sources.Torque drive;
  R.Components.Inertia shaft(J=0.5, phi(start=0, fixed=true), w(start=0, fixed=true));
  R.Components.BearingFriction bearing(tau_pos=[0, 2], peak=1.5);
equation
  drive.tau = if time < 2 then 2*time else 0;
  connect(drive.flange, shaft.flange_a);
  connect(shaft.flange_b, bearing.flange_a);
""",
        stop=4.0,
    )
    assert modes(result, "bearing") == [0, 1, 0]
    t, w, tau = result.time, result["shaft.w"], result["bearing.tau"]
    stuck, driven = t < 1.499, (t > 1.501) & (t < 1.999)
    np.testing.assert_allclose(w[stuck], 0, atol=1e-12)
    np.testing.assert_allclose(tau[stuck], 2 * t[stuck], atol=1e-9)
    speed = (t**2 - 1.5**2 - 2 * (t - 1.5)) / 0.5
    np.testing.assert_allclose(w[driven], speed[driven], atol=1e-6)
    end = 2 + (2**2 - 1.5**2 - 2 * 0.5) / 0.5 / (2 / 0.5)
    assert np.all(w[t > end + 1e-3] == pytest.approx(0, abs=1e-9))
    assert np.all(tau[t > end + 1e-3] == pytest.approx(0, abs=1e-9))


@pytest.mark.parametrize("speed", [3, -3])
def test_friction_stops_a_shaft_from_both_directions(rub: Callable[..., Any], speed: float) -> None:
    result = rub(
        f"""
  R.Components.Inertia shaft(J=2, phi(start=0, fixed=true), w(start={speed}, fixed=true));
  R.Components.BearingFriction bearing(tau_pos=[0, 3; 1, 4; 10, 4]);
equation
  connect(shaft.flange_b, bearing.flange_a);
""",
        stop=3.0,
    )
    sign = np.sign(speed)
    assert modes(result, "bearing") == [sign, 0]
    # Above 1 rad/s the torque is 4, below it falls to 3 as a straight line.
    even = result.time < (3 - 1) / 2 - 0.01
    np.testing.assert_allclose(
        result["shaft.w"][even], sign * (3 - 2 * result.time[even]), atol=1e-7
    )
    stop = 1 + 2 * np.log(4 / 3)
    (index,) = np.nonzero(np.diff(result["bearing.mode"]))
    assert result.time[index[-1] + 1] == pytest.approx(stop, abs=1e-6)
    assert result["shaft.w"][-1] == pytest.approx(0, abs=1e-10)


def test_a_clutch_slips_until_speeds_are_equal(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  R.Components.Inertia a(J=1, phi(start=0, fixed=true), w(start=9, fixed=true));
  R.Components.Inertia b(J=2, phi(start=0, fixed=true), w(start=0, fixed=true));
  R.Components.Clutch clutch(fn_max=20, mu_pos=[0, 0.3]);
equation
  clutch.f_normalized = if time < 0.5 then 0 else 1;
  connect(a.flange_b, clutch.flange_a);
  connect(clutch.flange_b, b.flange_a);
""",
        stop=2.0,
    )
    assert modes(result, "clutch") == [2, -1, 0]
    t = result.time
    slip = np.clip(t - 0.5, 0, 1)  # torque 6 makes up 9 rad/s in 1 s
    np.testing.assert_allclose(result["a.w"], 9 - 6 * slip, atol=1e-6)
    np.testing.assert_allclose(result["b.w"], 3 * slip, atol=1e-6)
    assert np.all(result["clutch.lossPower"] >= -1e-9)


def test_a_brake_holds_a_load_up_to_its_limit(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  R.Components.Inertia wheel(J=1, phi(start=0, fixed=true), w(start=0, fixed=true));
  R.Components.Brake brake(fn_max=10, mu_pos=[0, 0.5], cgeo=2, peak=1.2);
  R.Sources.Torque load;
equation
  brake.f_normalized = 1;
  load.tau = -8*time;
  connect(load.flange, wheel.flange_a);
  connect(wheel.flange_b, brake.flange_a);
""",
        stop=2.0,
    )
    assert modes(result, "brake") == [0, -1]
    t = result.time
    away = 1.2 * 10 * 0.5 * 2 / 8
    w = np.where(t > away, -(8 * (t**2 - away**2) / 2 - 10 * (t - away)), 0)
    np.testing.assert_allclose(result["wheel.w"], w, atol=1e-6)


def test_a_free_wheel_lets_only_one_direction_run(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  R.Sources.Torque drive;
  R.Components.Inertia a(J=1, phi(start=0, fixed=true), w(start=0, fixed=true));
  R.Components.OneWayClutch wheel(fn_max=10, mu_pos=[0, 0.01]);
  R.Components.Inertia b(J=1);
equation
  wheel.f_normalized = 1;
  drive.tau = if time < 1 then 4 else -4;
  connect(drive.flange, a.flange_a);
  connect(a.flange_b, wheel.flange_a);
  connect(wheel.flange_b, b.flange_a);
""",
        stop=1.5,
    )
    driven = result.time < 0.999
    np.testing.assert_allclose(result["b.w"][driven], 2 * result.time[driven], atol=1e-6)
    # Alone, `b` keeps its speed but for the friction of the discs.
    assert result["b.w"][-1] == pytest.approx(2 - 0.1 * 0.5, abs=1e-5)
    assert result["a.w"][-1] == pytest.approx(2 - (4 - 0.1) * 0.5, abs=1e-5)


def test_a_sliding_part_sticks_to_its_support(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  T.Components.Mass mass(m=2, s(start=0, fixed=true), v(start=1, fixed=true));
  T.Components.SupportFriction guide(f_pos=[0, 4]);
equation
  connect(mass.flange_b, guide.flange_a);
"""
    )
    t = np.minimum(result.time, 0.5)
    np.testing.assert_allclose(result["mass.s"], t - t**2, atol=1e-7)
    assert modes(result, "guide") == [1, 0]


def test_a_mass_rests_at_its_stop_until_it_is_pulled_away(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  T.Sources.Force push;
  T.Components.MassWithStopAndFriction mass(
    m=1, L=0.2, smax=1, smin=-1, F_prop=0, F_Coulomb=2, F_Stribeck=0,
    s(start=0, fixed=true), v(start=2, fixed=true));
equation
  push.f = if time < 1 then 4 else -4;
  connect(push.flange, mass.flange_a);
""",
        stop=2.0,
    )
    t, s, v = result.time, result["mass.s"], result["mass.v"]
    # 2*t + t^2 = 0.9 at the right stop; from t = 1 on back with a = -2.
    met = np.sqrt(1 + 0.9) - 1
    there = (t > met + 1e-3) & (t < 0.999)
    np.testing.assert_allclose(s[t < met - 1e-3], (2 * t + t**2)[t < met - 1e-3], atol=1e-6)
    np.testing.assert_allclose(s[there], 0.9, atol=1e-9)
    np.testing.assert_allclose(v[there], 0, atol=1e-9)
    back = t > 1.001
    np.testing.assert_allclose(s[back], 0.9 - (t[back] - 1) ** 2, atol=1e-4)


def test_a_bouncing_mass_loses_what_the_gap_takes(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  T.Components.Fixed ground;
  T.Components.ElastoGap gap(c=1000, d=0, s_rel0=0.1);
  T.Components.Mass mass(m=1, s(start=0.3, fixed=true), v(start=-1, fixed=true));
equation
  connect(ground.flange, gap.flange_a);
  connect(gap.flange_b, mass.flange_a);
""",
        stop=0.5,
    )
    instants = [event.time for event in result.events]
    part = 0.2 + np.pi / np.sqrt(1000)
    assert instants == pytest.approx([0.2, part], abs=1e-6)
    np.testing.assert_allclose(result["mass.v"][result.time > part + 1e-3], 1, atol=1e-6)
    assert np.all(result["gap.f"] <= 1e-9)


def test_a_peak_below_one_is_refused(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  R.Components.Inertia shaft(J=1);
  R.Components.BearingFriction bearing(peak=0.5);
equation
  connect(shaft.flange_b, bearing.flange_a);
"""
    )
    assert "give peak >= 1" in result.ended.message
