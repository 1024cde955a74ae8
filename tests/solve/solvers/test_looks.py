"""Contacts that close and open again within a step, where states move so evenly that steps grow."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planarc

ROTOR = """
model Rotor "A blade of 1 m turns past a post at x = 1.2 m"
  inner PlanarMultiBody.World world(gravityType=PlanarMultiBody.Types.GravityTypes.NoGravity);
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0.5, fixed=true), w(start=7, fixed=true));
  PlanarMultiBody.Parts.Body blade(m=1, I=1);
  PlanarMultiBody.Contacts.Contact post(
    redeclare PlanarMultiBody.Contacts.Segment contour1(a={0,0}, b={1,0}, R=0.01),
    redeclare PlanarMultiBody.Contacts.Circle contour2(r={1.2,0}, R=0.25), e=0.5);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, blade.frame_a);
  connect(blade.frame_a, post.frame_a);
  connect(world.frame_b, post.frame_b);
end Rotor;
"""

TUMBLE = """
model Tumble "A bar tumbles with 18 rad/s and drifts to a floor"
  inner PlanarMultiBody.World world(gravityType=PlanarMultiBody.Types.GravityTypes.NoGravity);
  PlanarMultiBody.Joints.FreeMotion free(
    r_rel_a(start={0,-0.7}, each fixed=true), v_rel_a(start={0,-0.3}, each fixed=true),
    phi_rel(start=0.145, fixed=true), w_rel(start=18.37, fixed=true));
  PlanarMultiBody.Parts.Body bar(m=2, I=0.03);
  PlanarMultiBody.Contacts.Contact floor(
    redeclare PlanarMultiBody.Contacts.Polygon contour1(
      vertices={{-0.2,-0.1},{0.2,-0.1},{0.2,0.1},{-0.2,0.1}}),
    redeclare PlanarMultiBody.Contacts.HalfPlane contour2(r={0,-1}), e=0.7, mu=0.2);
equation
  connect(world.frame_b, free.frame_a);
  connect(free.frame_b, bar.frame_a);
  connect(bar.frame_a, floor.frame_a);
  connect(world.frame_b, floor.frame_b);
end Tumble;
"""

CROSSING = """
model Crossing "Two points on crossing ways, and how often they have come nearer than 0.1 m"
  Real x(start=-5.02, fixed=true), y(start=-5, fixed=true);
  Real gap = sqrt(x^2 + y^2) - 0.1;
  discrete Integer met(start=0, fixed=true);
  discrete Real at(start=0, fixed=true);
equation
  der(x) = 1;
  der(y) = 1;
  when gap < 0 then
    met = pre(met) + 1;
    at = time;
  end when;
end Crossing;
"""

DRIVEN = """
model Driven "A wheel with a cam, turned by a motor"
  Real phi, lift = cos(phi) - 0.99;
  discrete Integer n(start=0, fixed=true);
  Real load(start=0, fixed=true);
equation
  phi = {phi};
  der(load) = -load;
  when lift > 0 then
    n = pre(n) + 1;
  end when;
end Driven;
"""


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("stop", [2, 20, 100])
def test_a_blade_meets_a_post_at_each_turn(stop: float, backend: str) -> None:
    """Its end meets the circle's of 0.26 m about the post: at phi = -acos(2.3724/2.4) + 2*pi. Each
    impact halves its speed, and the next one comes after a turn but for twice that angle."""
    run = planarc.load(ROTOR).simulate(stop, backend=backend)
    near = np.arccos((1 + 1.44 - 0.26**2) / 2.4)
    expected, t, w = [], (2 * np.pi - near - 0.5) / 7, 3.5
    while t < stop:
        expected.append(t)
        t, w = t + (2 * np.pi - 2 * near) / w, w / 2
    assert [e.time for e in run.events] == pytest.approx(expected, rel=1e-6)
    assert run["post.gap"].min() > -1e-6


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("stop", [1, 5, 20, 100])
def test_the_end_of_a_run_does_not_change_its_begin(stop: float, backend: str) -> None:
    """The corner that comes lowest, sqrt(0.05) m from the middle, meets the floor first."""

    def lowest(t: Any) -> Any:
        phi = 0.145 + 18.37 * t
        corners = [(x, y) for x in (-0.2, 0.2) for y in (-0.1, 0.1)]
        return 0.3 - 0.3 * t + min(x * np.sin(phi) + y * np.cos(phi) for x, y in corners)

    times = np.linspace(0, 1, 100001)
    first = times[np.argmax([lowest(t) < 0 for t in times])]
    run = planarc.load(TUMBLE).simulate(stop, intervals=4000, backend=backend)
    assert run.events[0].time == pytest.approx(first, abs=2e-5)
    assert run["floor.gap"].min() > -1e-6


@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams", "lsoda"])
@pytest.mark.parametrize("stop", [10, 100, 10000])
def test_ways_that_cross_meet_however_long_the_steps(stop: float, solver: str) -> None:
    run = planarc.load(CROSSING).simulate(stop, solver=solver)
    assert run["met"][-1] == 1
    assert run["at"][-1] == pytest.approx(5.01 - np.sqrt(0.01 / 2 - 0.01**2), rel=1e-6)


@pytest.mark.parametrize("phi", ["7*time", "7*time + 0*load", "7*time + load"])
def test_an_angle_that_is_given_is_followed(phi: str) -> None:
    run = planarc.load(DRIVEN.format(phi=phi)).simulate(50)
    assert run["n"][-1] == int((7 * 50 + np.arccos(0.99)) / (2 * np.pi))


def test_an_angle_that_no_relation_feels_costs_no_event() -> None:
    run = planarc.load(DRIVEN.format(phi="7*time").replace("- 0.99", "- 1.01")).simulate(50)
    assert run["n"][-1] == 0
    assert not run.events


@pytest.mark.parametrize("k", ["300", "k", "2*k - 300"])
def test_a_sine_of_many_turns_by_way_of_a_variable(k: str) -> None:
    model = planarc.load(f"""
    model Comb
      parameter Real k = 300;
      Real x(start=0, fixed=true), s = sin(({k})*x + 1);
      discrete Integer n(start=0, fixed=true);
    equation
      der(x) = 1;
      when s > 0 then
        n = pre(n) + 1;
      end when;
    end Comb;
    """)
    assert model.simulate(20)["n"][-1] == int((300 * 20 + 1) / (2 * np.pi))
