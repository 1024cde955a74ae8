"""`GenevaWheel` by its closed form, with both back ends."""

from __future__ import annotations

from math import atan2, cos, pi, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

import planarc
from tests.stdlib.small import FREE, both_backends, run

DRIVE = """
  Joints.Revolute carrier(drivenFlange=true);
  Joints.Revolute shaft(drivenFlange=true{w});
  Joints.Revolute axis{start};
  Parts.FixedTranslation apart(r=0.1*{{cos({at}), sin({at})}}, animation=false);
  Parts.Body driver(m=1, I=0.01);
  Parts.Body wheel(m=1, I=0.003);
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed turns(w_fixed={turns},
    phi(start=0, fixed=true));
  Modelica.Mechanics.Rotational.Sources.{drive};
  Contacts.GenevaWheel geneva({law});
equation
  connect(world.frame_b, carrier.frame_a);
  connect(turns.flange, carrier.axis);
  connect(carrier.frame_b, shaft.frame_a);
  connect(carrier.frame_b, apart.frame_a);
  connect(apart.frame_b, axis.frame_a);
  connect(motor.flange, shaft.axis);
  connect(shaft.frame_b, driver.frame_a);
  connect(axis.frame_b, wheel.frame_a);
  connect(shaft.frame_b, geneva.frame_a);
  connect(axis.frame_b, geneva.frame_b);
"""
COASTS = "ConstantTorque motor(tau_constant=0)"


def drive(law: str, drive: str = COASTS, **given: Any) -> str:
    values = {"at": 0.0, "turns": 0, "w": "", "start": "", "law": law, "drive": drive, **given}
    return DRIVE.format(**values)


def wheel(theta: Any, n: int) -> Any:
    """The wheel's angle, the driver's from the line of centres: by its own few cases."""
    turned = np.round(theta / (2 * pi))
    a, part = theta - 2 * pi * turned, sin(pi / n)
    driven = np.arctan2(part * np.sin(a), 1 - part * np.cos(a))
    held = np.sign(a) * pi / n
    return -np.where(np.abs(a) < pi / 2 - pi / n, driven, held) - 2 * pi * turned / n


@both_backends
@pytest.mark.parametrize(("n", "speed"), [(3, 6), (4, -6), (7, 6)])
@pytest.mark.parametrize(("at", "turns"), [(0.0, 0), (pi, 0), (2.0, -5)])
def test_the_wheel_follows_its_closed_form(
    n: int, speed: int, at: float, turns: int, backend: str
) -> None:
    motor = f"ConstantSpeed motor(w_fixed={speed}, phi(start=0.5, fixed=true))"
    r = run(drive(f"n={n}", motor, at=at, turns=turns), 5, backend, FREE)
    theta = r["shaft.phi"] - at
    np.testing.assert_allclose(theta, 0.5 + speed * r["time"] - at, atol=1e-8)
    turned = r["axis.phi"] - r["axis.phi"][0]
    expected = wheel(theta, n)
    np.testing.assert_allclose(turned, expected - expected[0], atol=1e-8)
    part = sin(pi / n)
    assert np.abs(r["axis.w"]).max() == pytest.approx(6 * part / (1 - part), rel=5e-3)


@both_backends
def test_the_wheel_starts_with_the_known_acceleration(backend: str) -> None:
    """tan(pi/n)*w^2 where the pin enters; before that the wheel is held, and so it is after."""
    for n in (4, 6):
        r = run(
            drive(f"n={n}", "ConstantSpeed motor(w_fixed=6, phi(start=0.5, fixed=true))"),
            2,
            backend,
            FREE,
        )
        enters = next(e.time for e in r.events if "turns the wheel" in e.causes[0])
        assert 0.5 + 6 * enters == pytest.approx(2 * pi - (pi / 2 - pi / n), abs=1e-8)
        rows = np.flatnonzero(np.abs(r["time"] - enters) < 1e-10)
        assert r["axis.z"][rows[0]] == pytest.approx(0, abs=1e-6)
        assert r["axis.z"][rows[-1]] == pytest.approx(-36 * tan(pi / n), rel=1e-6)


@both_backends
def test_a_drive_that_coasts_keeps_its_energy(backend: str) -> None:
    """The driver slows down while it turns the wheel, by the ratio of the closed form."""
    r = run(
        drive("n=5", w=", phi(start=0.5, fixed=true), w(start=6, fixed=true)"), 4, backend, FREE
    )
    energy = 0.01 * r["shaft.w"] ** 2 + 0.003 * r["axis.w"] ** 2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)
    assert r["shaft.w"].min() < 5
    assert r["shaft.phi"][-1] > 6 * pi


@both_backends
def test_the_pin_presses_across_its_slot(backend: str) -> None:
    r = run(
        drive("n=4", w=", phi(start=0.5, fixed=true), w(start=6, fixed=true)"), 1.2, backend, FREE
    )
    part = 0.1 * sin(pi / 4)
    phi = r["shaft.phi"]
    pin = np.array([part * np.cos(phi) - 0.1, part * np.sin(phi)])
    rho = np.hypot(*pin)
    driven = np.abs(np.mod(phi + pi, 2 * pi) - pi) < pi / 4 - 1e-6
    force = 0.003 * r["axis.z"] / rho  # to the left of the slot's direction
    across = np.array([-pin[1], pin[0]]) / rho * force
    for k in (1, 2):
        np.testing.assert_allclose(
            r[f"axis.frame_b.f[{k}]"][driven], across[k - 1][driven], atol=1e-6
        )
    assert np.abs(force[driven]).max() > 1


@both_backends
@pytest.mark.parametrize("e", [0.0, 0.6])
def test_a_pin_with_play_strikes_its_slot(e: float, backend: str) -> None:
    """Where the slot has moved by half the backlash, both speeds change by one impulse."""
    from scipy.optimize import brentq

    start = "(phi(fixed=true), w(fixed=true))"
    body = drive(
        f"n=4, backlash=1e-3, e={e}",
        w=", phi(start=1.5, fixed=true), w(start=6, fixed=true)",
        start=start,
    )
    r = run(body, 1.2, backend, FREE)
    rim, part, step = 0.1 * cos(pi / 4), sin(pi / 4), 1e-6
    meets = brentq(
        lambda a: rim * (pi / 4 - atan2(-part * sin(a), 1 - part * cos(a))) - 5e-4, -pi / 4, 0
    )
    event = next(x for x in r.events if "impact" in x.causes[0])
    assert event.causes[0].startswith("`geneva.ahead`")
    assert 1.5 + 6 * event.time == pytest.approx(2 * pi + meets, abs=1e-8)
    ratio = float(wheel(meets + step, 4) - wheel(meets - step, 4)) / (2 * step)
    # J*ratio on the driver, -J on the wheel; the wheel's speed beyond the slot's is e times that of
    # the approach.
    impulse = (1 + e) * 6 * ratio / (ratio**2 / 0.01 + 1 / 0.003)
    after = np.flatnonzero(np.abs(r["time"] - event.time) < 1e-10)[-1]
    assert r["axis.w"][after] == pytest.approx(impulse / 0.003, rel=1e-8)
    assert r["shaft.w"][after] == pytest.approx(6 - impulse * ratio / 0.01, rel=1e-8)
    assert np.abs(r["geneva.play"]).max() < 5e-4 + 1e-9
    energy = 0.01 * r["shaft.w"] ** 2 + 0.003 * r["axis.w"] ** 2
    assert (np.diff(energy) < 1e-7).all()


@both_backends
@pytest.mark.parametrize("law", ["backlash=0", "backlash=1e-3, e=0.5"])
@pytest.mark.parametrize(
    ("phi", "at", "n"),
    [(-8.17, 0.12, 8), (0.13, 0.58, 6), (-8.27, -1.34, 4), (-9.63, -1.98, 4), (20.0, 2.0, 5)],
)
def test_a_drive_starts_at_any_angle(phi: float, at: float, n: int, law: str, backend: str) -> None:
    """Whatever turns the driver has behind it, and wherever its wheel is."""
    start = "(phi(fixed=true), w(fixed=true))" if "e=" in law else ""
    motor = f"ConstantSpeed motor(w_fixed=-7, phi(start={phi}, fixed=true))"
    r = run(drive(f"n={n}, {law}", motor, at=at, start=start), 2, backend, FREE)
    assert not r.warnings
    expected = wheel(r["shaft.phi"] - at, n)
    off = r["axis.phi"] - r["axis.phi"][0] - expected + expected[0]
    play = 0.0 if law == "backlash=0" else 5e-4
    np.testing.assert_allclose(off, 0, atol=play / (0.1 * cos(pi / n)) + 1e-7)


@both_backends
def test_the_disc_holds_the_wheel_against_a_torque(backend: str) -> None:
    """Through the axis of the driver, which does not feel it."""
    body = drive(
        "n=4, backlash=1e-3",
        "ConstantSpeed motor(w_fixed=0, phi(start=3, fixed=true))",
        start="(w(fixed=true))",
    )
    body = body.replace("equation\n", "  Forces.WorldTorque load;\nequation\n", 1)
    body += "  connect(axis.frame_b, load.frame_b);\n  load.torque = 0.2;\n"
    r = run(body, 1, backend, FREE)
    rim = 0.1 * cos(pi / 4)
    assert r.events[0].time == pytest.approx(sqrt(2 * 5e-4 / rim * 0.003 / 0.2), abs=1e-9)
    assert r["axis.phi"][-1] - r["axis.phi"][0] == pytest.approx(5e-4 / rim, abs=1e-9)
    assert r["shaft.tau"][-1] == pytest.approx(0, abs=1e-9)
    assert abs(r["axis.frame_b.f[2]"][-1]) == pytest.approx(2, rel=1e-8)


def test_events_are_told_in_words_of_the_wheel() -> None:
    run = planarc.load("examples/geneva_drive.pmo").simulate()
    told = {c for e in run.events for c in e.causes}
    assert {"`geneva` turns the wheel", "`geneva` locks the wheel"} <= told
    assert not any("theta_a" in cause for cause in told)
