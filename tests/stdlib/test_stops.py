"""Stops of joints by law, with both back ends: `PrismaticStops`, `RevoluteStops`.

Each has two of `Internal.Touch`, kept by the `PartialStops` that both extend.
"""

from __future__ import annotations

from math import cos, pi, sqrt
from typing import Any

import numpy as np
import pytest

from tests.stdlib.small import FREE, G, both_backends, run

SLIDE = """
  Joints.Prismatic slide(n={{1, 0}}, s(start={s}, fixed=true), v(start={v}, fixed=true));
  Parts.Body mass(m=2);
  Contacts.PrismaticStops stops({law});
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
  connect(slide.frame_a, stops.frame_a);
  connect(slide.frame_b, stops.frame_b);
"""
HINGE = """
  Joints.Revolute hinge(phi(start=0, fixed=true), w(start={w}, fixed=true));
  Parts.Body bar(m=2, I=0.3, r_CM={{0.5, 0}});
  Contacts.RevoluteStops stops({law});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bar.frame_a);
  connect(hinge.frame_a, stops.frame_a);
  connect(hinge.frame_b, stops.frame_b);
"""
INERTIA = 0.3 + 2 * 0.5**2


def column(r: Any, name: str) -> Any:
    return np.broadcast_to(r[name], r["time"].shape)


@both_backends
def test_a_slide_strikes_its_stops_at_known_times(backend: str) -> None:
    """Each way of 1 m takes 1/e as long as the last one."""
    body = SLIDE.format(s=0, v=1, law="s_min=-1, s_max=1, e=0.8")
    r = run(body, 10, backend, world=FREE)
    speeds = 0.8 ** np.arange(5)
    times = np.cumsum([1, *(2 / speeds[1:])])
    times = times[times < 10]
    np.testing.assert_allclose([e.time for e in r.events], times, rtol=0, atol=1e-9)
    assert [e.causes for e in r.events[:2]] == [
        ("`stops.upper` of `mass` and the ground: impact of 3.6 N.s",),
        ("`stops.lower` of `mass` and the ground: impact of 2.88 N.s",),
    ]
    assert abs(r["slide.v"][-1]) == pytest.approx(0.8 ** len(times), abs=1e-9)


@both_backends
def test_a_slide_rests_on_its_stop_at_the_end_of_the_series(backend: str) -> None:
    body = SLIDE.format(s=1, v=0, law="s_min=0, e=0.5")
    r = run(body, 2, backend, world="n={-1, 0}")
    rest = 3 * sqrt(2 / G)
    touches = column(r, "stops.lower.touches")
    assert r["time"][touches > 0][0] == pytest.approx(rest, abs=1e-9)
    assert r["stops.f"][-1] == pytest.approx(2 * G, rel=1e-9)
    assert r["slide.s"][-1] == pytest.approx(0, abs=1e-9)


@both_backends
def test_a_bar_falls_on_its_stop_and_the_stop_bears_it(backend: str) -> None:
    """w = sqrt(2*m*g*r*sin(phi)/I) at the stop, whose impulse at the radius R is I*w/R."""
    body = HINGE.format(w=0, law="phi_min=-0.5, phi_max=1, R=0.25")
    r = run(body, 2, backend, tolerance=1e-11)
    speed = sqrt(2 * 2 * G * 0.5 * np.sin(0.5) / INERTIA)
    (lands,) = r.events
    assert r["hinge.w"].min() == pytest.approx(-speed, abs=1e-8)
    assert column(r, "stops.lower.rigid.impulse")[-1] == pytest.approx(
        INERTIA * speed / 0.25, rel=1e-8
    )
    assert lands.causes[0].startswith("`stops.lower` of `bar` and the ground: impact of")
    assert r["hinge.phi"][-1] == pytest.approx(-0.5, abs=1e-10)
    assert r["stops.tau"][-1] == pytest.approx(2 * G * 0.5 * cos(0.5), rel=1e-9)


@both_backends
def test_a_hinge_gives_back_its_restitution_at_both_stops(backend: str) -> None:
    body = HINGE.format(w=2, law="phi_min=-1, phi_max=0.5, e=0.7")
    r = run(body, 3, backend, world=FREE)
    times = np.cumsum([0.25, 1.5 / 1.4, 1.5 / 0.98])
    np.testing.assert_allclose([e.time for e in r.events], times, rtol=0, atol=1e-9)
    assert r["hinge.w"][-1] == pytest.approx(-2 * 0.7**3, abs=1e-9)


@both_backends
def test_an_elastic_stop_is_a_spring_while_it_is_touched(backend: str) -> None:
    """Half a period of contact, and the depth in which the spring has taken all energy."""
    law = "law=Types.ContactLaw.Compliant, s_max=0.5, e=1, c=200"
    r = run(SLIDE.format(s=0, v=1, law=law), 2, backend, world=FREE, intervals=2000)
    meets, parts = (e.time for e in r.events)
    assert meets == pytest.approx(0.5, abs=1e-9)
    assert parts - meets == pytest.approx(pi * sqrt(2 / 200), abs=1e-7)
    assert r["slide.s"].max() - 0.5 == pytest.approx(sqrt(2 / 200), rel=1e-4)
    energy = column(r, "slide.v") ** 2 + column(r, "stops.upper.energy")
    np.testing.assert_allclose(energy, 1, atol=1e-7)


@both_backends
def test_a_loop_rattles_between_stops_without_gaining_energy(backend: str) -> None:
    """A four-bar whose rocker is stopped: with e = 1 its energy stays, with e = 0.6 it falls."""
    r = run(FOURBAR.format(e=1), 2, backend)
    assert len(r.events) >= 3
    np.testing.assert_allclose(energy_of(r), energy_of(r)[0], atol=1e-6)
    r = run(FOURBAR.format(e=0.6), 2, backend)
    assert (np.diff(energy_of(r)) < 1e-6).all()
    assert energy_of(r)[-1] < energy_of(r)[0] - 0.1


FOURBAR = """
  Joints.Revolute pin1(phi(start=1, fixed=true), w(start=3, fixed=true));
  Joints.Revolute pin2(phi(start=-0.5));
  Joints.Revolute pin3(phi(start=-1));
  Joints.Revolute pin4;
  Parts.BodyShape crank(r={{0.4, 0}}, m=1, I=0.1, r_CM={{0.2, 0}});
  Parts.BodyShape coupler(r={{1, 0}}, m=1, I=0.1, r_CM={{0.5, 0}});
  Parts.BodyShape rocker(r={{0.8, 0}}, m=1, I=0.1, r_CM={{0.4, 0}});
  Parts.FixedTranslation ground(r={{1, 0}});
  Contacts.RevoluteStops stops(phi_min=0.6, phi_max=1.6, e={e});
equation
  connect(world.frame_b, pin1.frame_a);
  connect(pin1.frame_b, crank.frame_a);
  connect(crank.frame_b, pin2.frame_a);
  connect(pin2.frame_b, coupler.frame_a);
  connect(coupler.frame_b, pin3.frame_a);
  connect(pin3.frame_b, rocker.frame_a);
  connect(rocker.frame_b, pin4.frame_b);
  connect(world.frame_b, ground.frame_a);
  connect(ground.frame_b, pin4.frame_a);
  connect(pin1.frame_a, stops.frame_a);
  connect(pin1.frame_b, stops.frame_b);
"""


def energy_of(r: Any) -> Any:
    total: Any = 0.0
    for name in ("crank", "coupler", "rocker"):
        body = f"{name}.body"
        speed = r[f"{body}.v_CM[1]"] ** 2 + r[f"{body}.v_CM[2]"] ** 2
        total = total + speed / 2 + 0.1 * r[f"{body}.w"] ** 2 / 2 + G * r[f"{body}.r_0CM[2]"]
    return total
