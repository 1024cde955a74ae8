"""Teeth that mesh, by law, with both back ends: `GearPair`, `Rack`, which extend `PartialMesh`."""

from __future__ import annotations

from math import acos, cos, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

import planarc
from tests.stdlib.small import FREE, G, both_backends, run

ALPHA = radians(20)
#: Two wheels on axes at rest, the second one at the angle `at` from the first.
GEARS = """
  Joints.Revolute axis1(phi(start=0.3, fixed=true), w(start={w1}, fixed=true), drivenFlange=true);
  Joints.Revolute axis2(phi(start=-0.7, fixed=true){w2});
  Parts.FixedTranslation apart(r={distance}*{{cos({at}), sin({at})}}, animation=false);
  Parts.Body wheel1(m=1, I=0.02);
  Parts.Body wheel2(m=4, I=0.3);
  Modelica.Mechanics.Rotational.Sources.ConstantTorque drive(tau_constant={torque});
  Contacts.GearPair gear(Ra=0.05, Rb={Rb}, {law});
equation
  connect(world.frame_b, axis1.frame_a);
  connect(world.frame_b, apart.frame_a);
  connect(apart.frame_b, axis2.frame_a);
  connect(axis1.frame_b, wheel1.frame_a);
  connect(axis2.frame_b, wheel2.frame_a);
  connect(drive.flange, axis1.axis);
  connect(axis1.frame_b, gear.frame_a);
  connect(axis2.frame_b, gear.frame_b);
"""
RACK = """
  Joints.Revolute axis(phi(start=0.3, fixed=true), w(start={w}, fixed=true));
  Parts.FixedTranslation up(r={{0, {h}}}, animation=false);
  Parts.Body pinion(m=1, I=0.02);
  Joints.Prismatic slide(s(start=0.7, fixed=true){v});
  Parts.Body bar(m=3);
  Forces.WorldForce pull;
  Contacts.Rack rack(R=0.05, {law});
equation
  connect(world.frame_b, up.frame_a);
  connect(up.frame_b, axis.frame_a);
  connect(axis.frame_b, pinion.frame_a);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, bar.frame_a);
  connect(slide.frame_b, pull.frame_b);
  connect(axis.frame_b, rack.frame_a);
  connect(slide.frame_b, rack.frame_b);
  pull.force = {{{force}, 0}};
"""
REST = ", w(start=0, fixed=true)"


def gears(law: str, **given: Any) -> str:
    values = {"w1": 0, "w2": REST, "Rb": 0.15, "distance": 0.2, "at": 0, "torque": 0}
    return GEARS.format(**{**values, "law": law, **given})


def after(r: Any, name: str, time: float) -> float:
    """A value right after an event."""
    return float(r[name][np.flatnonzero(np.abs(r["time"] - time) < 1e-10)[-1]])


@both_backends
@pytest.mark.parametrize(("Rb", "distance"), [(0.15, 0.2), (-0.15, 0.1)])
@pytest.mark.parametrize("at", [0, 2.5, pi])
def test_gears_without_backlash_share_their_inertia(
    at: float, Rb: float, distance: float, backend: str
) -> None:
    """Internal teeth turn the same way, external ones the other."""
    r = run(
        gears("backlash=0", at=at, Rb=Rb, distance=distance, torque=0.5, w2=""), 3, backend, FREE
    )
    w = 0.5 / (0.02 + 0.3 / 9) * 3
    assert r["axis1.w"][-1] == pytest.approx(w, rel=1e-9)
    assert r["axis2.w"][-1] == pytest.approx(-w * 0.05 / Rb, rel=1e-9)
    assert r["axis1.phi"][-1] - 0.3 > 2 * pi
    turned = 0.05 * (r["axis1.phi"] - 0.3) + Rb * (r["axis2.phi"] + 0.7)
    np.testing.assert_allclose(turned, 0, atol=1e-13)
    assert np.ravel(r["gear.f"])[-1] * 0.05 == pytest.approx(0.02 * w / 3 - 0.5, rel=1e-9)


@both_backends
@pytest.mark.parametrize("e", [0, 0.5, 1])
def test_a_gear_strikes_the_flank_ahead_by_newtons_law(e: float, backend: str) -> None:
    """The way is half the backlash; momentum by the radii stays, speeds part e times as fast."""
    r = run(gears(f"backlash=2e-3, e={e}", w1=2, at=pi), 0.5, backend, FREE)
    meets = r.events[0].time
    assert meets == pytest.approx(1e-3 / (0.05 * 2), abs=1e-12)
    assert r.events[0].causes[0].startswith("`gear.ahead` of `wheel1` and `wheel2`: impact")
    inertia1, inertia2 = 0.02 / 0.05**2, 0.3 / 0.15**2  # at the pitch circle, where b runs back
    v = 0.05 * 2
    common = inertia1 * v / (inertia1 + inertia2)
    v1 = common - e * inertia2 * v / (inertia1 + inertia2)
    v2 = common + e * inertia1 * v / (inertia1 + inertia2)
    assert after(r, "axis1.w", meets) == pytest.approx(v1 / 0.05, abs=1e-10)
    assert after(r, "axis2.w", meets) == pytest.approx(-v2 / 0.15, abs=1e-10)
    if e:
        assert r.events[1].time == pytest.approx(meets + 2e-3 / (e * v), abs=1e-9)
        assert r.events[1].causes[0].startswith("`gear.behind` of `wheel1` and `wheel2`: impact")
    else:
        assert len(r.events) == 1
        np.testing.assert_allclose(r["gear.play"][r["time"] > meets], 1e-3, atol=1e-12)


@both_backends
def test_flanks_push_the_axes_apart_by_their_pressure_angle(backend: str) -> None:
    r = run(gears("backlash=1e-3, play_0=5e-4", torque=0.5), 0.5, backend, FREE)
    force = 0.3 / 0.15 * 0.5 / (0.02 + 0.3 / 9) * (0.05 / 0.15)
    assert r["axis2.frame_b.f[2]"][-1] == pytest.approx(force, rel=1e-8)
    assert r["axis2.frame_b.f[1]"][-1] == pytest.approx(force * tan(ALPHA), rel=1e-8)


@both_backends
def test_involutes_gain_backlash_with_the_distance_of_their_axes(backend: str) -> None:
    """Each normal gap grows by the integral of the sine of the working pressure angle."""
    far = 0.203
    r = run(gears("backlash=1e-3", w1=2, distance=far, at=1), 0.3, backend, FREE)
    grid = np.linspace(0.2, far, 20001)
    opens = np.trapezoid(np.sqrt(1 - (0.2 * cos(ALPHA) / grid) ** 2), grid)
    meets = (5e-4 * cos(ALPHA) + opens) / (0.05 * cos(ALPHA) * 2)
    assert r.events[0].time == pytest.approx(meets, abs=1e-9)
    # The force stands on the common tangent of the base circles.
    assert float(r["gear.alpha_w"][0]) == pytest.approx(acos(0.2 * cos(ALPHA) / far), abs=1e-12)


@both_backends
def test_a_planet_runs_around_its_sun_for_many_turns(backend: str) -> None:
    """Willis: (w_sun - w_arm)*Ra = -(w_planet - w_arm)*Rb, over turns of the arm, with rattling."""
    body = """
  Joints.Revolute arm(phi(start=2, fixed=true), w(start=9, fixed=true));
  Joints.Revolute hinge(phi(fixed=true), w(start={w}, fixed=true));
  Parts.FixedTranslation rod(r={{{rod}, 0}});
  Parts.Body planet(m=1, I=1e-3);
  Contacts.GearPair gear(Ra={Ra}, Rb=0.05, backlash=1e-4, e=0.3);
equation
  connect(world.frame_b, arm.frame_a);
  connect(arm.frame_b, rod.frame_a);
  connect(rod.frame_b, hinge.frame_a);
  connect(hinge.frame_b, planet.frame_a);
  connect(world.frame_b, gear.frame_a);
  connect(planet.frame_a, gear.frame_b);
"""
    for radius in (0.1, -0.2):
        ratio = radius / 0.05
        text = body.format(Ra=radius, rod=abs(radius + 0.05), w=9 * ratio * 0.99)
        r = run(text, 5, backend)
        assert np.ptp(r["arm.phi"]) > 4 * pi
        turned = r["hinge.phi"] - ratio * (r["arm.phi"] - 2)
        assert np.abs(turned).max() <= 1.001 * 5e-5 / 0.05
        assert len(r.events) > 3
        assert np.abs(r["gear.play"]).max() <= 5e-5 + 1e-9


@both_backends
def test_flanks_that_yield_store_what_they_take(backend: str) -> None:
    law = "law=Types.ContactLaw.Compliant, backlash=2e-3, e=1, c=1e5, exponent=1"
    r = run(gears(law, w1=2), 0.2, backend, FREE, intervals=2000)
    meets, parts = (e.time for e in r.events[:2])
    mass = 1 / (0.05**2 / 0.02 + 0.15**2 / 0.3) / cos(ALPHA) ** 2  # along the line of action
    assert meets == pytest.approx(0.01, abs=1e-9)
    assert parts - meets == pytest.approx(pi * sqrt(mass / 1e5), rel=1e-6)
    energy = 0.01 * r["axis1.w"] ** 2 + 0.15 * r["axis2.w"] ** 2 + r["gear.energy"]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)


@both_backends
def test_a_rack_without_backlash_goes_with_its_pinion(backend: str) -> None:
    body = RACK.format(w=2, v="", h=0.05, force=6, law="backlash=0")
    r = run(body, 2, backend)
    a = 6 / (3 + 0.02 / 0.05**2)
    assert not r.events
    assert r["slide.v"][-1] == pytest.approx(0.1 + 2 * a, rel=1e-9)
    assert r["axis.w"][-1] == pytest.approx((0.1 + 2 * a) / 0.05, rel=1e-9)


@both_backends
@pytest.mark.parametrize("lift", [0.0, 1e-3])
def test_a_pinion_strikes_its_rack_and_drives_it(lift: float, backend: str) -> None:
    """Lifted off its pitch line the pinion has lift*tan(alpha) more play on each side."""
    law = "backlash=2e-3, e=0.25"
    body = RACK.format(w=2, v=", v(start=0, fixed=true)", h=0.05 + lift, force=0, law=law)
    r = run(body, 0.2, backend)
    meets = (1e-3 + lift * tan(ALPHA)) / 0.1
    assert r.events[0].time == pytest.approx(meets, abs=1e-10)
    mass = 0.02 / 0.05**2
    speed = 0.1 * mass * 1.25 / (mass + 3)
    assert after(r, "slide.v", meets) == pytest.approx(speed, abs=1e-10)
    assert after(r, "axis.w", meets) == pytest.approx((0.1 - speed * 3 / mass) / 0.05, abs=1e-9)


@both_backends
@pytest.mark.parametrize(
    ("law", "axis"),
    [
        ("backlash=0", "phi(start=0)"),
        ("backlash=1e-3, play_0=5e-4", "phi(fixed=true), w(fixed=true)"),
    ],
    ids=["kept", "backlash"],
)
def test_a_pinion_rolls_down_a_rack_like_a_wheel(law: str, axis: str, backend: str) -> None:
    body = f"""
  Joints.Prismatic guide(n={{cos(0.4), -sin(0.4)}}, s(fixed=true), v(fixed=true));
  Joints.Revolute axis({axis});
  Parts.Body pinion(m=2, I=0.004);
  Parts.Fixed base(phi=-0.4, r=0.05*{{-sin(0.4), -cos(0.4)}});
  Contacts.Rack rack(R=0.05, {law});
equation
  connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, axis.frame_a);
  connect(axis.frame_b, pinion.frame_a);
  connect(axis.frame_b, rack.frame_a);
  connect(base.frame_b, rack.frame_b);
"""
    way = G * sin(0.4) / (1 + 0.004 / (2 * 0.05**2)) / 2
    r = run(body, 1, backend)
    assert r["guide.s"][-1] == pytest.approx(way, rel=1e-8)
    assert r["axis.phi"][-1] == pytest.approx(-way / 0.05, rel=1e-8)


def test_what_rattling_gears_take_is_counted() -> None:
    from planarc.insight.energy import find_energies

    r = planarc.load("PlanarMultiBody.Examples.Contacts.RattlingGears").simulate(stop_time=0.3)
    energies = find_energies(r.rows, r.rows.program.mechanism)
    assert energies is not None
    assert np.abs(energies.balance).max() < 1e-2 * energies.exchanged
