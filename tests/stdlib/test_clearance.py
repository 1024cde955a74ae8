"""Joints with clearance by law, with both back ends: `ClearanceRevolute`, `ClearancePrismatic`."""

from __future__ import annotations

from math import atan, cos, pi, sin, sqrt

import numpy as np
import pytest

import planarc
from tests.stdlib.small import FREE, G, both_backends, run

#: A disc of 2 kg whose rim is a pin of 10 mm in a hole of 11 mm.
PIN = """
  Parts.Body disc(m=2, I=1e-4, r(start={r}, each fixed=true), v(start={v}, each fixed=true),
    phi(start=0, fixed=true), w(start=0, fixed=true));
  Contacts.ClearanceRevolute hinge(c=1e-3, R=0.01, {law});
equation
  connect(disc.frame_a, hinge.frame_a);
  connect(world.frame_b, hinge.frame_b);
"""
BLOCK = """
  Parts.Body drawer(m=2, I=0.01, r(start={{0, {y}}}, each fixed=true),
    v(start={{{v}, 0}}, each fixed=true), phi(start=0, fixed=true), w(start=0, fixed=true));
  Contacts.ClearancePrismatic slide(c=1e-3, length=0.2, height=0.1, {law});
  Forces.WorldForce pull(resolveInFrame=Types.ResolveInFrameB.frame_b);
  Parts.FixedTranslation lever(r={{0, {b}}});
equation
  connect(world.frame_b, slide.frame_a);
  connect(drawer.frame_a, slide.frame_b);
  connect(drawer.frame_a, lever.frame_a);
  connect(lever.frame_b, pull.frame_b);
  pull.force = {{{force}, 0}};
"""


def pin(law: str, r: str = "{0, 0}", v: str = "{0, 0}") -> str:
    return PIN.format(law=law, r=r, v=v)


def at(angle: float) -> str:
    """Where the pin lies on the wall, the angle from below."""
    return f"{{{1e-3 * sin(angle)!r}, {-1e-3 * cos(angle)!r}}}"


@both_backends
def test_a_pin_flies_and_strikes_the_wall_of_its_hole(backend: str) -> None:
    """(v*t)^2 + (g*t^2/2)^2 = c^2, and the velocity along the normal turns round."""
    r = run(pin("e=0.5", v="{0.05, 0}"), 0.03, backend, tolerance=1e-13)
    square = (-(0.05**2) + sqrt(0.05**4 + (G * 1e-3) ** 2)) / (G**2 / 2)
    meets = sqrt(square)
    assert r.events[0].time == pytest.approx(meets, abs=1e-11)
    before, after = np.flatnonzero(np.abs(r["time"] - meets) < 1e-9)[[0, -1]]
    d = np.array([0.05 * meets, -G * meets**2 / 2]) / 1e-3
    v, u = ([r[f"disc.v[{k}]"][i] for k in (1, 2)] for i in (before, after))
    np.testing.assert_allclose(v, [0.05, -G * meets], atol=1e-9)
    assert d @ u == pytest.approx(-0.5 * (d @ v), abs=1e-9)
    assert d[0] * u[1] - d[1] * u[0] == pytest.approx(d[0] * v[1] - d[1] * v[0], abs=1e-9)


@both_backends
@pytest.mark.parametrize(("law", "part"), [("e=0", 0.0), ("mu=2", 1e-4 / (2 * 0.01**2))])
def test_a_pin_slides_and_rolls_in_its_hole_like_a_pendulum(
    law: str, part: float, backend: str
) -> None:
    """Its length is c without friction, c*(1 + I/(m*R^2)) where it rolls."""
    r = run(pin(law, r=at(0.3)), 0.5, backend, intervals=5000)
    length = 1e-3 * (1 + part)
    a, b = 1.0, cos(0.15)
    for _ in range(20):
        a, b = (a + b) / 2, sqrt(a * b)
    period = 2 * pi * sqrt(length / G) / a
    side = r["hinge.d[1]"]
    crossings = np.flatnonzero((side[:-1] > 0) & (side[1:] <= 0))
    times = [
        np.interp(0, [side[i + 1], side[i]], [r["time"][i + 1], r["time"][i]]) for i in crossings
    ]
    np.testing.assert_allclose(np.diff(times), period, atol=1e-6)
    assert times[0] == pytest.approx(period / 4, abs=1e-6)
    assert np.abs(r["hinge.gap"]).max() < 1e-9
    if part:
        assert np.abs(r["hinge.slip"]).max() < 1e-8


@both_backends
def test_a_pin_in_a_turning_hole_lies_at_the_angle_of_friction(backend: str) -> None:
    body = f"""
  Joints.Prismatic aside(n={{1, 0}}, s(start={1e-3 * sin(atan(0.3))!r}, fixed=true),
    v(fixed=true));
  Joints.Prismatic up(n={{0, 1}}, s(start={-1e-3 * cos(atan(0.3))!r}, fixed=true), v(fixed=true));
  Parts.PointMass mass(m=2);
  Joints.Revolute shaft(drivenFlange=true);
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed drive(w_fixed=20);
  Contacts.ClearanceRevolute hinge(c=1e-3, R=0.01, mu=0.3);
equation
  connect(world.frame_b, aside.frame_a);
  connect(aside.frame_b, up.frame_a);
  connect(up.frame_b, mass.frame_a);
  connect(up.frame_b, hinge.frame_a);
  connect(world.frame_b, shaft.frame_a);
  connect(shaft.frame_b, hinge.frame_b);
  connect(drive.flange, shaft.axis);
"""
    r = run(body, 0.1, backend)
    np.testing.assert_allclose(r["hinge.d[1]"], 1e-3 * sin(atan(0.3)), atol=1e-9)
    assert r["shaft.tau"][-1] == pytest.approx(2 * G * 0.011 * sin(atan(0.3)), rel=1e-6)


@both_backends
def test_a_pin_that_yields_presses_with_its_weight(backend: str) -> None:
    law = "law=Types.ContactLaw.Compliant, e=0.2, stiffness=1e8"
    r = run(pin(law, r=at(0)), 0.3, backend)
    assert r["hinge.gap"][-1] == pytest.approx(-((2 * G / 1e8) ** (2 / 3)), rel=1e-3)
    assert r["hinge.f[2]"][-1] == pytest.approx(2 * G, rel=1e-3)


def block(law: str, y: float = 0.0, v: float = 0.0, b: float = 0.0, force: float = 0.0) -> str:
    return BLOCK.format(law=law, y=y, v=v, b=b, force=force)


@both_backends
def test_a_block_falls_through_its_clearance_and_slides_to_rest(backend: str) -> None:
    r = run(block("mu=0.3", v=0.5), 0.5, backend, tolerance=1e-13)
    lands = sqrt(2e-3 / G)
    assert r.events[0].time == pytest.approx(lands, abs=1e-11)
    # Both corners strike at once; friction takes mu times the normal impulse.
    speed = 0.5 - 0.3 * G * lands
    way = 0.5 * lands + speed**2 / (2 * 0.3 * G)
    assert r["slide.s"][-1] == pytest.approx(way, abs=1e-8)
    assert r["slide.u"][-1] == pytest.approx(-1e-3, abs=1e-9)
    assert sum(r[f"slide.f_n[{i}]"][-1] for i in (3, 4)) == pytest.approx(2 * G, rel=1e-8)


@both_backends
@pytest.mark.parametrize("part", [0.9, 1.1])
def test_a_drawer_jams_where_it_is_pulled_too_far_aside(part: float, backend: str) -> None:
    """With the lever b it slides with F*(1 - 2*mu*b/length)/m, and locks where that is negative."""
    b = part * 0.2 / (2 * 0.25)
    r = run(block("mu=0.25", b=b, force=10.0), 1, backend, world=FREE)
    if part > 1:
        assert r["slide.s"][-1] < 1e-2
        assert r["drawer.v[1]"][-1] == pytest.approx(0, abs=1e-9)
    else:
        sure = r["time"] > 0.5
        speeds = r["drawer.v[1]"][sure]
        a = np.diff(speeds) / np.diff(r["time"][sure])
        np.testing.assert_allclose(a, 5 * (1 - part), rtol=0.1)


def test_what_a_worn_hinge_takes_is_counted() -> None:
    from planarc.insight.energy import find_energies

    r = planarc.load("PlanarMultiBody.Examples.Contacts.WornSliderCrank").simulate(stop_time=0.2)
    assert r.events[0].causes == ("`hinge` of `rod` and `slider`: impact of 0.5993 N.s",)
    energies = find_energies(r.rows, r.rows.program.mechanism)
    assert energies is not None
    assert np.abs(energies.balance).max() < 1e-2 * energies.exchanged
