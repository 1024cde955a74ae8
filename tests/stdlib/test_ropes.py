"""What pulls and never pushes, by law, with both back ends: `Rope`, `Belt`, `SerpentineBelt`."""

from __future__ import annotations

from functools import partial
from math import acos, asin, cos, exp, pi, sqrt

import numpy as np
import pytest

import planarc
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


MANY = """
  Parts.FixedTranslation place[{n}](r={places}, each animation=false);
  Joints.Revolute axis[{n}](each phi(fixed=true), each w(fixed=true));
  Parts.Body wheel[{n}](each m=1, I={inertias});
  Forces.WorldTorque drive(torque={torque});
  Contacts.SerpentineBelt belt(n={n}, R={radii}, side={sides}, T0=100, mu=0.3, m={mass},
    v(fixed=true));
equation
  connect(drive.frame_b, wheel[1].frame_a);
  for i in 1:{n} loop
    connect(world.frame_b, place[i].frame_a);
    connect(place[i].frame_b, axis[i].frame_a);
    connect(axis[i].frame_b, wheel[i].frame_a);
    connect(wheel[i].frame_a, belt.frame[i]);
  end for;
"""
#: Two pulleys in the belt, and one that its back turns.
BACK = {
    "n": 3,
    "places": "{{0, 0}, {0.4, 0}, {0.2, 0.12}}",
    "inertias": "{0.02, 0.3, 0.01}",
    "radii": "{0.05, 0.15, 0.05}",
    "sides": "{1, 1, -1}",
}


@both_backends
def test_a_belt_turns_many_pulleys_like_gears_with_its_back_the_other_way(backend: str) -> None:
    r = run(MANY.format(**BACK, torque=0.5, mass=0.1), 1, backend)
    assert not r.events
    rho, inertia = (0.05, 0.15, -0.05), (0.02, 0.3, 0.01)
    shares = [i / q**2 for i, q in zip(inertia, rho, strict=True)]
    a = 0.5 / 0.05 / (sum(shares) + 0.1)
    assert r["belt.v"][-1] == pytest.approx(a, rel=1e-9)
    for i in (1, 2, 3):
        assert r[f"axis[{i}].w"][-1] == pytest.approx(a / rho[i - 1], rel=1e-9)
    tension = [float(np.ravel(r[f"belt.T[{i}]"])[-1]) for i in (1, 2, 3)]
    assert tension[1] - tension[0] == pytest.approx((shares[1] + 0.1 / 3) * a, rel=1e-9)
    assert tension[2] - tension[1] == pytest.approx((shares[2] + 0.1 / 3) * a, rel=1e-9)


@both_backends
def test_a_belt_slips_on_each_pulley_by_its_own_angle_of_contact(backend: str) -> None:
    """T2/T1 = exp(mu*beta) at the motor and at the little angle of the pulley on its back; the
    other one is turned by what is left."""
    r = run(MANY.format(**BACK, torque=50, mass=1e-6), 0.1, backend)
    t1, t2, t3 = (float(np.ravel(r[f"belt.T[{i}]"])[-1]) for i in (1, 2, 3))
    wrap = [float(np.ravel(r[f"belt.wrap[{i}]"])[-1]) for i in (1, 2, 3)]
    assert wrap[0] - wrap[2] + wrap[1] == pytest.approx(2 * pi, rel=1e-12)
    assert t3 / t1 == pytest.approx(exp(0.3 * wrap[0]), rel=1e-6)
    assert t3 / t2 == pytest.approx(exp(0.3 * wrap[2]), rel=1e-6)
    assert [np.sign(np.round(r[f"belt.slip[{i}]"][-1], 7)) for i in (1, 2, 3)] == [1, 0, -1]
    for i, pull, rho, inertia in ((2, t2 - t1, 0.15, 0.3), (3, t3 - t2, -0.05, 0.01)):
        assert r[f"axis[{i}].w"][-1] == pytest.approx(rho * pull / inertia * 0.1, rel=1e-5)
    assert r["axis[1].w"][-1] == pytest.approx((50 - 0.05 * (t3 - t1)) / 0.02 * 0.1, rel=1e-6)


@both_backends
@pytest.mark.parametrize("torque", [0.5, 50.0])
def test_a_belt_over_two_pulleys_is_the_belt_for_two(backend: str, torque: float) -> None:
    two = {"n": 2, "places": "{{0, 0}, {0.4, 0}}", "inertias": "{0.02, 0.3}"}
    two |= {"radii": "{0.05, 0.15}", "sides": "{1, 1}"}
    many = run(MANY.format(**two, torque=torque, mass=1e-7), 0.2, backend)
    one = run(BELT.format(w=0, w2=0.0, torque=torque), 0.2, backend)
    for i in (1, 2):
        assert many[f"axis[{i}].w"][-1] == pytest.approx(one[f"axis{i}.w"][-1], rel=1e-6)
    assert np.ravel(many["belt.wrap[1]"])[-1] == pytest.approx(one["belt.wrap"][-1], rel=1e-12)
    assert np.ravel(many["belt.T[1]"])[-1] == pytest.approx(one["belt.T2"][-1], rel=1e-6)


@both_backends
def test_the_length_of_a_belt_round_a_triangle_is_its_sides_and_one_circle(backend: str) -> None:
    three = {"n": 3, "places": f"{{{{0, 0}}, {{0.4, 0}}, {{0.2, {0.2 * sqrt(3)!r}}}}}"}
    three |= {"inertias": "{1, 1, 1}", "radii": "{0.1, 0.1, 0.1}", "sides": "{1, 1, 1}"}
    r = run(MANY.format(**three, torque=1, mass=0.1), 0.1, backend)
    assert r["belt.length"] == pytest.approx(3 * 0.4 + 2 * pi * 0.1, rel=1e-12)
    for i in (1, 2, 3):
        assert r[f"belt.wrap[{i}]"] == pytest.approx(2 * pi / 3, rel=1e-12)


def test_a_belt_that_does_not_reach_a_pulley_says_so() -> None:
    away = BACK | {"places": "{{0, 0}, {0.4, 0}, {0.1, 0.13}}", "radii": "{0.05, 0.15, 0.03}"}
    with pytest.raises(planarc.PlanarcError, match="nearly once round a pulley"):
        run(MANY.format(**away, torque=1, mass=0.1), 0.1, "native")
