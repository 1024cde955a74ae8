"""CurveCurveContact by law: cams that lift their follower off, discs that meet, roll and yield."""

from __future__ import annotations

from functools import cache
from math import asin, cos, sin, sqrt

import numpy as np
import pytest

import planarc

both_backends = pytest.mark.parametrize("backend", ["native", "numpy"])

G = 9.81
SPEED = 12.0
ELLIPSE = "Curves.Ellipse curve1(a=0.15, b=0.08), s1(start=0.31)"
ECCENTRIC = "Eccentric curve1, s1(start=2.8)"
SPLINE = (
    "Curves.Spline curve1(points={{0.15*sin(i*Modelica.Constants.pi/10), "
    "-0.08*cos(i*Modelica.Constants.pi/10)} for i in 0:19}), s1(start=0.31)"
)
CAM = """
model Cam
  import PlanarMultiBody.*;
  model Eccentric "A round cam whose axis is not its centre"
    extends Interfaces.BaseCurve(s_max=2*Modelica.Constants.pi, closed=true,
      redeclare final function position = round);
    function round
      extends Interfaces.partialCurvePosition;
    algorithm
      r := {{0.1*sin(s) + 0.09, -0.1*cos(s)}};
    end round;
  end Eccentric;
  inner World world;
  Joints.Revolute hinge(drivenFlange=true, phi(start=0.3), w(start={speed}));
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed drive(w_fixed={speed}, phi(start=0.3));
  {kind} contact(redeclare {curve},
    redeclare Curves.StraightLine curve2(s_min=-0.2, s_max=0.2) {more});
  Joints.Prismatic slide(n={{0, 1}}, s(start=0.09));
  Parts.Body follower(m=0.5);
{start}
equation
  connect(drive.flange, hinge.axis);
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, contact.frame_a);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, follower.frame_a);
  connect(slide.frame_b, contact.frame_b);
end Cam;
"""


@cache
def cam(curve: str, backend: str, kept: bool = False) -> planarc.Model:
    given = {"curve": curve, "speed": SPEED}
    if kept:
        kind, more, start = "Joints.CurveCurveJoint", ", detectSeparation=true", ""
    else:
        kind, more = "Contacts.CurveCurveContact", ", e=0.2, gap(start=0, fixed=true)"
        start = "initial equation\n  der(contact.gap) = 0;"
    return planarc.load(CAM.format(kind=kind, more=more, start=start, **given), backend=backend)


def root(f: object, low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(f, low, high, xtol=1e-15, rtol=1e-15))


def lift(phi: float) -> tuple[float, float, float]:
    """That of a flat follower on the ellipse, and its derivatives by the angle."""
    a2, b2 = 0.15**2, 0.08**2
    s = sqrt(a2 * sin(phi) ** 2 + b2 * cos(phi) ** 2)
    half = (a2 - b2) / 2
    v = half * sin(2 * phi) / s
    return s, v, (2 * half * cos(2 * phi) - v**2) / s


@both_backends
def test_a_follower_lifts_off_where_nothing_presses_and_falls_back(backend: str) -> None:
    r = cam(ELLIPSE, backend).simulate(stop_time=0.26, backend=backend, tolerance=1e-12)
    off, on = r.events
    phi = root(lambda p: lift(p)[2] * SPEED**2 + G, 0.8, 1.2)
    assert off.causes == ("`contact` of `hinge` and `follower`: lets go",)
    assert off.time == pytest.approx((phi - 0.3) / SPEED, abs=1e-9)

    height, rate, _ = lift(phi)

    def falls(t: float) -> float:
        return height + rate * SPEED * t - G * t**2 / 2 - lift(phi + SPEED * t)[0]

    flight = root(falls, 0.1, 0.3)
    assert on.time == pytest.approx(off.time + flight, abs=1e-9)
    own = lift(phi + SPEED * flight)[1] * SPEED
    meets = rate * SPEED - G * flight - own
    assert on.causes == (
        f"`contact` of `hinge` and `follower`: impact of {-0.5 * 1.2 * meets:.4g} N.s",
    )
    (at,) = np.nonzero(np.abs(r["time"] - on.time) < 1e-12)
    assert r["slide.v"][at[-1]] == pytest.approx(own - 0.2 * meets, abs=1e-8)


@both_backends
@pytest.mark.parametrize("curve", [ELLIPSE, SPLINE, ECCENTRIC], ids=["ellipse", "spline", "own"])
def test_lift_off_is_where_the_joint_begins_to_pull(curve: str, backend: str) -> None:
    options = {"backend": backend, "tolerance": 1e-12}
    kept = cam(curve, backend, kept=True).simulate(stop_time=0.15, **options)
    free = cam(curve, backend).simulate(stop_time=0.15, **options)
    assert free.events[0].causes == ("`contact` of `hinge` and `follower`: lets go",)
    assert free.events[0].time == pytest.approx(kept.events[0].time, abs=1e-9)
    if curve is ECCENTRIC:  # at sin(phi) = g/(0.09*w^2)
        phi = asin(G / (0.09 * SPEED**2))
        assert free.events[0].time == pytest.approx((phi - 0.3) / SPEED, abs=1e-9)


DISCS = """
model Discs
  import PlanarMultiBody.*;
  inner World world(gravityType=Types.GravityTypes.NoGravity);
  Parts.Body a(m=1, I=0.01, r(start={0, 0}, each fixed=true), v(start={3, 0}, each fixed=true),
    phi(fixed=true), w(fixed=true));
  Parts.Body b(m=2, I=0.01, r(start={1, 0.15}, each fixed=true), v(start={0, 0}, each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.CurveCurveContact contact(curve1(R=0.1), curve2(R=0.2), s1(start=0.16),
    s2(start=0.94), e=0.8);
equation
  connect(a.frame_a, contact.frame_a);
  connect(b.frame_a, contact.frame_b);
end Discs;
"""


@both_backends
def test_discs_meet_along_the_line_of_their_centres(backend: str) -> None:
    model = planarc.load(DISCS, backend=backend)
    r = model.simulate(stop_time=0.5, backend=backend, tolerance=1e-12)
    (event,) = r.events
    x = 1 - sqrt(0.3**2 - 0.15**2)
    assert event.time == pytest.approx(x / 3, abs=1e-9)
    n = np.array([1 - x, 0.15]) / 0.3
    impulse = 1.8 * (3 * n[0]) / (1 + 1 / 2)
    for body, mass, sign, start in (("a", 1, -1, 3.0), ("b", 2, 1, 0.0)):
        v = [r[f"{body}.v[{k}]"][-1] for k in (1, 2)]
        expected = np.array([start, 0]) + sign * impulse / mass * n
        np.testing.assert_allclose(v, expected, atol=1e-9)


ROLLS = """
model Rolls
  import PlanarMultiBody.*;
  inner World world;
  Parts.Body disc(m=2, I=0.008, r(start={0, 0.1}, each fixed=true),
    v(start={1, 0}, each fixed=true), phi(fixed=true), w(fixed=true));
  Contacts.CurveCurveContact contact(curve1(R=0.1), s1(start=0.0), s2(start=0),
    redeclare Curves.StraightLine curve2(s_min=-5, s_max=5, switchSide=true), %s);
equation
  connect(disc.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
end Rolls;
"""


@both_backends
def test_a_disc_slides_until_it_rolls(backend: str) -> None:
    model = planarc.load(ROLLS % "mu=0.3", backend=backend)
    r = model.simulate(stop_time=1, backend=backend, tolerance=1e-10)
    assert r["disc.v[1]"][-1] == pytest.approx(1 / 1.4, abs=1e-9)
    assert r["disc.w"][-1] == pytest.approx(-10 / 1.4, abs=1e-8)
    (begins,) = r.events
    assert begins.time == pytest.approx((1 - 1 / 1.4) / (0.3 * G), abs=1e-9)


@both_backends
def test_curves_yield(backend: str) -> None:
    law = "law=Types.ContactLaw.Compliant, c=1e8, e=0.3"
    r = planarc.load(ROLLS % law, backend=backend).simulate(stop_time=1, backend=backend)
    assert r["contact.gap"][-1] == pytest.approx(-((2 * G / 1e8) ** (2 / 3)), rel=1e-3)
    assert r["contact.f_n"][-1] == pytest.approx(2 * G, rel=1e-3)


def test_energy_is_lost_in_impacts_alone() -> None:
    from planarc.insight.energy import find_energies

    r = planarc.load(DISCS).simulate(stop_time=0.5, tolerance=1e-10)
    energies = find_energies(r.rows, r.rows.program.mechanism)
    assert energies is not None
    assert np.abs(energies.balance).max() < 1e-7 * energies.exchanged
    n = sqrt(0.3**2 - 0.15**2) / 0.3
    lost = (1 - 0.8**2) / 2 * (2 / 3) * (3 * n) ** 2
    assert energies.dissipated[-1] == pytest.approx(lost, rel=1e-7)
