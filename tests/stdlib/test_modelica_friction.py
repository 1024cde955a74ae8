"""Coulomb friction: break-away, sliding, sticking again, clutches, brakes and hard stops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc.core.resources import stdlib

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


# Each element between a driven part (0.5 kg, 0.5 kg.m2) and what stands still; break-away at 3.
ELEMENTS = {
    "R.Components.BearingFriction": "tau_pos=[0, 2], peak=1.5",
    "R.Components.Brake": "mu_pos=[0, 0.5], fn_max=2, cgeo=2, peak=1.5, f_normalized=1",
    "R.Components.Clutch": "mu_pos=[0, 0.5], fn_max=4, peak=1.5, f_normalized=1",
    "R.Components.OneWayClutch": "mu_pos=[0, 0.5], fn_max=4, peak=1.5, f_normalized=1",
    "T.Components.SupportFriction": "f_pos=[0, 2], peak=1.5",
    "T.Components.Brake": "mu_pos=[0, 0.5], fn_max=4, peak=1.5, f_normalized=1",
    "T.Components.MassWithStopAndFriction": "m=0.5, F_prop=0, F_Coulomb=2, F_Stribeck=1, fexp=50",
}
DRIVEN = {
    "R": """
  R.Sources.Torque drive;
  R.Components.Inertia part(J=0.5, phi(start=0, fixed=true), w(start=0, fixed=true));
""",
    "T": """
  T.Sources.Force drive;
  T.Components.Mass part(m=0.5, s(start=0, fixed=true), v(start=0, fixed=true));
""",
    "T.Components.MassWithStopAndFriction": """
  T.Sources.Force drive;
""",
}


def driven(element: str, force: str) -> str:
    """A model in which `force` drives a part that the element `x` holds."""
    kind = element[0]
    alone = element in DRIVEN
    text = DRIVEN[element] if alone else DRIVEN[kind]
    start = ", s(start=0, fixed=true), v(start=0, fixed=true)" if alone else ""
    ends = "connect(drive.flange, x.flange_a);"
    if not alone:
        ends = "connect(drive.flange, part.flange_a); connect(part.flange_b, x.flange_a);"
    if "Clutch" in element:
        text += "  R.Components.Fixed wall;\n"
        ends += " connect(x.flange_b, wall.flange);"
    signal = "tau" if kind == "R" else "f"
    given = f"  {element} x({ELEMENTS[element]}{start});\n"
    return f"{text}{given}equation\n  drive.{signal} = {force};\n  {ends}\n"


@pytest.mark.parametrize("element", ELEMENTS)
def test_every_friction_keeps_the_law(rub: Callable[..., Any], element: str) -> None:
    """Stuck below the break-away, sliding above, at rest again; energy is only lost."""
    sign = -1 if "Clutch" in element else 1  # a clutch measures flange_b against flange_a
    result = rub(driven(element, f"{sign}*3.2*sin(time)"), stop=9.0)
    t, force = result.time, 3.2 * np.sin(result.time)  # in the direction of v
    v = result["x.w_relfric" if element[0] == "R" else "x.v_relfric"]
    locked, mode = result["x.locked"] > 0.5, result["x.mode"]
    held = result["x.tau" if element[0] == "R" else "x.f"]

    passed = modes(result, "x")
    assert passed[:3] == [0, 1, 0]
    assert (-1 in passed) == ("OneWay" not in element)
    assert t[mode == 1][0] == pytest.approx(np.arcsin(3 / 3.2), abs=0.1)
    np.testing.assert_allclose(v[locked], 0, atol=1e-7)
    np.testing.assert_allclose(held[locked], force[locked], atol=1e-6)
    within = held[locked] if "OneWay" in element else np.abs(held[locked])
    assert within.max() <= 3.0 * 1.001 + 1e-6
    assert np.all(v * mode >= -1e-9)

    loss = result["x.lossPower"]
    assert loss.min() >= -1e-7
    lost, given = np.trapezoid(loss, t), np.trapezoid(force * v, t)
    assert 0.25 * v[-1] ** 2 == pytest.approx(given - lost, abs=0.02 * given)


@pytest.mark.parametrize("element", ELEMENTS)
def test_every_friction_is_the_one_automaton(element: str) -> None:
    """The moves between the modes stand in one file only."""
    folder = stdlib() / "Modelica" / "Mechanics"
    room, _, name = element.partition(".Components.")
    kind = {"R": "Rotational", "T": "Translational"}[room]
    text = (folder / kind / "Components" / f"{name}.pmo").read_text("utf-8")
    assert "PartialFriction" in text or "extends Modelica.Mechanics.Friction.S" in text
    told = [p.name for p in folder.rglob("*.pmo") if "pre(mode)" in p.read_text("utf-8")]
    assert told == ["Automaton.pmo"]


def test_a_free_wheel_holds_any_torque_backward(rub: Callable[..., Any]) -> None:
    result = rub(driven("R.Components.OneWayClutch", "1000*time"))
    np.testing.assert_allclose(result["part.w"], 0, atol=1e-9)
    assert set(result["x.mode"]) == {0}
    assert result["x.tau"][-1] == pytest.approx(-1000)


def test_surfaces_that_meet_while_they_move_slide_at_once(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  T.Components.Mass part(m=2, s(start=0, fixed=true), v(start=-3, fixed=true));
  T.Components.Brake x(mu_pos=[0, 0.5], fn_max=8, f_normalized=if time < 0.25 then 0 else 1);
equation
  connect(part.flange_b, x.flange_a);
""",
        stop=2.0,
    )
    assert modes(result, "x") == [2, -1, 0]
    v = np.minimum(-3 + 2 * np.maximum(result.time - 0.25, 0), 0)
    np.testing.assert_allclose(result["part.v"], v, atol=1e-6)


def test_a_jump_turns_a_slide_round(rub: Callable[..., Any]) -> None:
    result = rub(
        """
  T.Components.Mass part(
    m=1, s(start=0, fixed=true), v(start=1, fixed=true, stateSelect=StateSelect.always));
  T.Components.SupportFriction x(f_pos=[0, 2]);
equation
  connect(part.flange_b, x.flange_a);
  when time > 0.25 then
    reinit(part.v, -1);
  end when;
"""
    )
    assert modes(result, "x") == [1, -1, 0]
    t = result.time
    np.testing.assert_allclose(
        result["part.v"][t > 0.26], np.minimum(-1 + 2 * (t - 0.25), 0)[t > 0.26], atol=1e-6
    )


def test_a_friction_of_ones_own_extends_the_partial_one(rub: Callable[..., Any]) -> None:
    """Written against the interface, as other libraries do: by its modes and starts."""
    result = rub(
        """
  model Rubbing "Friction that grows with the square of the velocity"
    extends R.Interfaces.PartialElementaryTwoFlangesAndSupport2;
    extends R.Interfaces.PartialFriction;
    Real tau, w, phi;
  equation
    phi = flange_a.phi - phi_support;
    flange_a.phi = flange_b.phi;
    w = der(phi);
    w_relfric = w;
    a_relfric = der(w);
    tau0 = 2;
    tau0_max = 3;
    free = false;
    flange_a.tau + flange_b.tau = tau;
    tau = if locked then sa*unitTorque
      elseif startForward or not startBackward and pre(mode) == Forward then 2 + w^2
      else -2 - w^2;
  end Rubbing;
  R.Components.Inertia shaft(J=2, phi(start=0, fixed=true), w(start=3, fixed=true));
  Rubbing x;
  R.Sources.Torque drive;
equation
  drive.tau = if time < 2.5 then 0 elseif time < 3 then 2.9 else -5;
  connect(drive.flange, shaft.flange_a);
  connect(shaft.flange_b, x.flange_a);
""",
        stop=4.0,
    )
    assert modes(result, "x") == [1, 0, -1]
    t = result.time
    rest = np.arctan(3 / np.sqrt(2)) * np.sqrt(2)  # of 2*der(w) = -(2 + w^2)
    w = np.sqrt(2) * np.tan(np.maximum(rest - t, 0) / np.sqrt(2))
    np.testing.assert_allclose(result["shaft.w"][t < 3], w[t < 3], atol=1e-6)
    assert t[result["x.mode"] == -1][0] == pytest.approx(3, abs=0.05)
