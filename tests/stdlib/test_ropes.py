"""What pulls and never pushes, by law, with both back ends: `Rope`, `Belt`."""

from __future__ import annotations

from functools import partial
from math import acos, asin, cos, exp, pi, sqrt

import numpy as np
import pytest

from tests.stdlib import small
from tests.stdlib.small import G, both_backends

ROPE = """
  Parts.PointMass mass(m=2, r(start={r}, each fixed=true), v(start={v}, each fixed=true),
    fixAngle=true);
  Contacts.Rope rope(length=1, {law});
equation
  connect(world.frame_b, rope.frame_a);
  connect(rope.frame_b, mass.frame_a);
"""
BELT = """
  Parts.FixedTranslation apart(r={{0.4, 0}}, animation=false);
  Joints.Revolute axis1(phi(fixed=true), w(start={w}, fixed=true), drivenFlange=true);
  Joints.Revolute axis2(phi(fixed=true), w(start={w2!r}, fixed=true));
  Parts.Body wheel1(m=1, I=0.02);
  Parts.Body wheel2(m=4, I=0.3);
  Modelica.Mechanics.Rotational.Sources.ConstantTorque drive(tau_constant={torque});
  Contacts.Belt belt(Ra=0.05, Rb=0.15, T0=100, mu=0.3);
equation
  connect(world.frame_b, axis1.frame_a);
  connect(world.frame_b, apart.frame_a);
  connect(apart.frame_b, axis2.frame_a);
  connect(axis1.frame_b, wheel1.frame_a);
  connect(axis2.frame_b, wheel2.frame_a);
  connect(drive.flange, axis1.axis);
  connect(axis1.frame_b, belt.frame_a);
  connect(axis2.frame_b, belt.frame_b);
"""


run = partial(small.run, tolerance=1e-12)


@both_backends
def test_a_rope_jerks_where_its_slack_ends_and_then_holds(backend: str) -> None:
    r = run(ROPE.format(r="{0, -0.5}", v="{0, 0}", law="e=0"), 1, backend)
    (taut,) = r.events
    assert taut.time == pytest.approx(sqrt(1 / G), abs=1e-10)
    assert taut.causes == (
        f"`rope` of `mass` and the ground: impact of {2 * sqrt(G):.4g} N.s, rests",
    )
    assert r["rope.tension"][-1] == pytest.approx(2 * G, rel=1e-9)
    assert r["mass.r[2]"][-1] == pytest.approx(-1, abs=1e-10)


@both_backends
def test_a_swing_on_a_rope_goes_slack_at_the_known_angle(backend: str) -> None:
    """Thrown from below with v^2 = 3.5*g*L: the rope lets go where 3*cos(a) = 2 - v^2/(g*L)."""
    r = run(ROPE.format(r="{0, -1}", v=f"{{{sqrt(3.5 * G)!r}, 0}}", law="e=0"), 0.8, backend)
    lets = r.events[0]
    assert lets.causes == ("`rope` of `mass` and the ground: lets go",)
    at = int(np.flatnonzero(np.abs(r["time"] - lets.time) < 1e-12)[0])
    angle = acos((2 - 3.5) / 3)
    assert r["mass.r[2]"][at] == pytest.approx(-cos(angle), abs=1e-9)
    after = slice(at + 2, at + 20)
    assert (r["rope.slack"][after] > 0).all()
    assert (r["rope.tension"][after] == 0).all()


@both_backends
def test_an_elastic_rope_is_a_spring_while_it_is_taut(backend: str) -> None:
    law = "law=Types.ContactLaw.Compliant, e=1, c=500"
    r = run(ROPE.format(r="{0, -0.5}", v="{0, 0}", law=law), 1, backend, intervals=2000)
    # The energy of the fall and of the stretch: c*x^2/2 = m*g*(0.5 + x).
    x = (2 * G + sqrt((2 * G) ** 2 + 2 * 500 * 2 * G * 0.5)) / 500
    assert r["mass.r[2]"].min() == pytest.approx(-1 - x, abs=1e-5)


@both_backends
def test_a_belt_turns_its_pulleys_like_a_gear(backend: str) -> None:
    r = run(BELT.format(w=3, w2=1.0, torque=0.5), 1, backend)
    inertia = 0.02 + 0.3 / 9
    assert not r.events
    assert r["axis1.w"][-1] == pytest.approx(3 + 0.5 / inertia, rel=1e-9)
    assert r["axis2.w"][-1] == pytest.approx((3 + 0.5 / inertia) / 3, rel=1e-9)
    assert r["belt.T1"][-1] + r["belt.T2"][-1] == pytest.approx(200)


@both_backends
def test_a_belt_slips_by_the_law_of_the_capstan(backend: str) -> None:
    """T2/T1 = exp(mu*beta) on the pulley with the smaller angle of contact."""
    r = run(BELT.format(w=0, w2=0.0, torque=50), 0.2, backend)
    beta = pi - 2 * asin(0.1 / 0.4)
    assert r["belt.wrap"][-1] == pytest.approx(beta, rel=1e-12)
    assert r["belt.slip"][-1] > 0
    tensions = sorted(float(np.ravel(r[f"belt.T{i}"])[-1]) for i in (1, 2))
    assert tensions[1] / tensions[0] == pytest.approx(exp(0.3 * beta), rel=1e-10)
    pull = tensions[1] - tensions[0]
    assert r["axis2.w"][-1] == pytest.approx(0.15 * pull / 0.3 * 0.2, rel=1e-8)
    assert r["axis1.w"][-1] == pytest.approx((50 - 0.05 * pull) / 0.02 * 0.2, rel=1e-8)


@both_backends
def test_a_belt_that_slips_grips_again(backend: str) -> None:
    r = run(BELT.format(w=30, w2=0.0, torque=0), 2, backend)
    (grips,) = r.events
    assert grips.causes == ("`belt`: sticks",)
    # Angular momentum, each part by its radius: 0.02*w1 + 0.3*w2/3 stays.
    w = 0.02 * 30 / (0.02 + 0.3 / 9)
    assert r["axis1.w"][-1] == pytest.approx(w, rel=1e-8)
    assert r["axis2.w"][-1] == pytest.approx(w / 3, rel=1e-8)
