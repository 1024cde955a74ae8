"""Joints that rub with what presses on them, by law, with both back ends.

`RevoluteWithFriction` and `PrismaticWithFriction` have a `Rubbing` each.
"""

from __future__ import annotations

from math import asin, atan, cos, sin

import numpy as np
import pytest

import planarc
from tests.stdlib.small import FREE, G, both_backends, run

SINE = sin(atan(0.3))
HINGE = """
  Joints.RevoluteWithFriction hinge(phi(start={phi!r}, fixed=true), w(start={w}, fixed=true),
    R=0.1, mu=0.3);
  Parts.Body bar(m=2, I=0.1, r_CM={{{l}, 0}});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bar.frame_a);
"""
SLIDE = """
  Joints.PrismaticWithFriction slide(n={{{c!r}, {s!r}}}, s(start=0, fixed=true),
    v(start={v}, fixed=true), mu=0.3, length={length});
  Parts.Body mass(m=2, I=0.1);
  Parts.FixedTranslation lever(r={{0, {b!r}}});
  Forces.WorldForce pull;
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
  connect(slide.frame_b, lever.frame_a);
  connect(lever.frame_b, pull.frame_b);
  pull.force = {{{force}, 0}};
"""
#: A slender rod on a slide without mass, which moves with the rod's end ahead.
ROD = """
  Joints.PrismaticWithFriction slide(s(start=0, fixed=true), v(start={v}, fixed=true), mu={mu});
  Joints.Revolute hinge(phi(start=0, fixed=true), w(fixed=true));
  Parts.Body rod(m=1, I=0.02, r_CM={{0.3, 0.5}});
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
"""


def slide(
    angle: float = 0.0, v: float = 0.0, length: float = 0.0, b: float = 0.0, force: float = 0.0
) -> str:
    return SLIDE.format(c=cos(angle), s=sin(angle), v=v, length=length, b=b, force=force)


@both_backends
@pytest.mark.parametrize("part", [0.999, 1.001])
def test_a_hinge_locks_within_its_circle_of_friction(part: float, backend: str) -> None:
    """A bar that hangs at an angle stays where its weight passes the circle of R*sin(rho)."""
    angle = asin(part * 0.1 * SINE / 0.5)
    r = run(HINGE.format(phi=angle - np.pi / 2, w=0, l=0.5), 1, backend)
    moved = abs(r["hinge.phi"][-1] - r["hinge.phi"][0])
    assert moved < 1e-12 if part < 1 else moved > 1e-4
    if part < 1:
        assert r["hinge.friction"][-1] == pytest.approx(2 * G * 0.5 * sin(angle), rel=1e-9)


@both_backends
def test_a_wheel_runs_down_in_its_bearing(backend: str) -> None:
    r = run(HINGE.format(phi=0, w=5, l=0), 1, backend)
    torque = 0.1 * SINE * 2 * G
    (sticks,) = r.events
    assert sticks.causes == ("`hinge`: sticks",)
    assert sticks.time == pytest.approx(0.1 * 5 / torque, abs=1e-8)
    assert r["hinge.phi"][-1] == pytest.approx(0.1 * 25 / (2 * torque), abs=1e-8)


@both_backends
@pytest.mark.parametrize("part", [0.999, 1.001])
def test_a_slide_locks_on_slopes_below_the_angle_of_friction(part: float, backend: str) -> None:
    angle = atan(part * 0.3)
    r = run(slide(angle), 1, backend)
    speed = G * (0.3 * cos(angle) - sin(angle))
    assert r["slide.v"][-1] == pytest.approx(min(speed, 0.0), abs=1e-9)


@both_backends
def test_a_slide_comes_to_rest_by_friction(backend: str) -> None:
    r = run(slide(v=1), 1, backend)
    assert r.events[0].time == pytest.approx(1 / (0.3 * G), abs=1e-9)
    assert r["slide.s"][-1] == pytest.approx(1 / (2 * 0.3 * G), abs=1e-9)


@pytest.mark.parametrize(
    ("backend", "solver"),
    [("native", "cvode-bdf"), ("numpy", "cvode-bdf"), ("native", "exported")],
)
@pytest.mark.parametrize("v", [0.2, -1e-3])
def test_a_slide_that_sticks_and_is_given_a_speed_slides_by_friction(
    v: float, backend: str, solver: str
) -> None:
    """Where its decay as an error would ask for less friction than mu*N, too."""
    knock = f"  when time > 0.3 then\n    reinit(slide.v, {v});\n  end when;\n"
    r = run(slide() + knock, 0.4, backend, solver=solver)
    assert r["slide.s"][-1] == pytest.approx(v * abs(v) / (2 * 0.3 * G), rel=1e-4, abs=1e-9)
    assert abs(r["slide.friction"]).max() == pytest.approx(0.3 * 2 * G, rel=1e-9)
    told = [cause for e in r.events for cause in e.causes]
    assert told == ["`slide`: slides", "time > 0.3", "`slide`: sticks"]


@both_backends
@pytest.mark.parametrize("part", [0.9, 0.999, 1.001])
def test_a_drawer_locks_where_its_lever_is_too_long(part: float, backend: str) -> None:
    """The ends press with F*b/length each, so that it locks from b = length/(2*mu) on."""
    r = run(slide(length=0.2, b=part * 0.2 / 0.6, force=10), 1, backend, world=FREE)
    assert r["slide.v"][-1] == pytest.approx(max(5 * (1 - part), 0.0), abs=1e-9)


@both_backends
def test_what_slides_and_needs_too_much_friction_jams(backend: str) -> None:
    """|N| = N0 + k*mu*|N| has no solution from k*mu = 1 on; the other way |N| = N0/(1 + k*mu)."""
    steep = 0.3 * 0.5 / (0.02 + 0.3**2)
    run(ROD.format(v=-1, mu=0.99 / steep), 0.001, backend)
    with pytest.raises(planarc.PlanarcError) as caught:
        run(ROD.format(v=-1, mu=1.01 / steep), 0.001, backend)
    (found,) = caught.value.diagnostics
    assert found.code == "R482"
    assert found.message.startswith("no forces hold `slide` (mu = 0.7407) at t = 0 s")
    free = G * 0.02 / (0.02 + 0.3**2)
    for mu in (0.5, 2):
        r = run(ROD.format(v=1, mu=mu), 0.001, backend)
        assert r["slide.pressure"][0] == pytest.approx(free / (1 + mu * steep), rel=1e-9)


@both_backends
def test_a_loop_of_rubbing_joints_loses_what_they_take_and_rests(backend: str) -> None:
    from planarc.insight.energy import find_energies

    crank = planarc.load("PlanarMultiBody.Examples.Loops.RubbingCrankSlider", backend=backend)
    r = crank.simulate(backend=backend, tolerance=1e-8, intervals=4000)
    energies = find_energies(r.rows, r.rows.program.mechanism)
    assert energies is not None
    assert np.abs(energies.balance).max() < 1e-4 * energies.exchanged
    assert abs(r["shaft.w"][-1]) < 1e-8
    assert any("sticks" in cause for cause in r.events[-1].causes)


@both_backends
def test_a_joint_rubs_beside_a_contact(backend: str) -> None:
    """A mass slides down to a floor, bounces there, and is stuck to it by what presses."""
    body = """
  Joints.PrismaticWithFriction slide(n={0, 1}, s(start=1, fixed=true), v(fixed=true), mu=0.5);
  Parts.Body mass(m=2);
  Forces.WorldForce push;
  Contacts.PrismaticStops stops(n={0, 1}, s_min=0, e=0.5);
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
  connect(slide.frame_a, stops.frame_a);
  connect(slide.frame_b, stops.frame_b);
  connect(push.frame_b, mass.frame_a);
  push.force = {8, 0};
"""
    r = run(body, 3, backend)
    falls, rises = G - 2, G + 2  # m*g less and more 0.5*8 N, over 2 kg
    first = np.sqrt(2 / falls)
    assert r.events[0].time == pytest.approx(first, abs=1e-9)
    up = 0.5 * falls * first
    assert r.events[1].time == pytest.approx(first + up / rises, abs=1e-8)
    again = first + up / rises + np.sqrt(up**2 / rises / falls)
    assert r.events[2].time == pytest.approx(again, abs=1e-8)
    assert r["slide.s"][-1] == pytest.approx(0, abs=1e-8)


def test_friction_alone_is_no_missing_drive() -> None:
    """The joint connects its own flange, which needs no drive then."""
    model = planarc.load("PlanarMultiBody.Examples.Loops.RubbingCrankSlider")
    assert not [w for w in model.warnings if w.code == "F319"]


DRIVEN = """
  Modelica.Mechanics.Translational.Sources.Position source(exact=true, s_ref={law});
  Joints.PrismaticWithFriction slide(mu=0.2);
  Parts.Body mass(m=2, I=0.1);
equation
  connect(source.flange, slide.axis);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
"""


@both_backends
@pytest.mark.parametrize(
    "law",
    ["0.3*sin(3*time)", "0.3*cos(3*time)", "if time < 0.5 then 0 else (time - 0.5)^2"],
    ids=["moving", "at its turn", "at rest for a while"],
)
def test_friction_against_a_given_motion(law: str, backend: str) -> None:
    """No force moves it, and friction acts all the same, also once it has turned round."""
    result = run(DRIVEN.format(law=law), 2.0, backend=backend)
    v, friction = result["slide.v"], result["slide.friction"]
    moving = np.abs(v) > 1e-4
    assert np.allclose(friction[moving], -0.2 * 2 * G * np.sign(v[moving]))
    assert {-1, 1} == {*np.sign(v[moving])} or "then 0" in law


@both_backends
def test_friction_of_a_slide_that_a_crank_drives(backend: str) -> None:
    """It begins at its dead centre, where it does not slide yet."""
    body = """
  Joints.Revolute main(drivenFlange=true), crank, pin;
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed source(w_fixed=5);
  Parts.BodyShape arm(r={0.2, 0}, m=1), rod(r={0.6, 0}, m=1, I=0.03);
  Joints.PrismaticWithFriction slide(mu=0.2, s(start=0.8));
  Parts.Body piston(m=1, I=0.1);
equation
  connect(source.flange, main.axis);
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, arm.frame_a);
  connect(arm.frame_b, crank.frame_a);
  connect(crank.frame_b, rod.frame_a);
  connect(rod.frame_b, pin.frame_a);
  connect(pin.frame_b, piston.frame_a);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, piston.frame_a);
"""
    result = run(body, 2.0, backend=backend)
    v, pressure, friction = (result[f"slide.{n}"] for n in ("v", "pressure", "friction"))
    moving = np.abs(v) > 1e-4
    assert np.allclose(friction[moving], -0.2 * (pressure * np.sign(v))[moving])
    assert pressure[moving].min() > 1


def test_exported_friction_against_a_given_motion() -> None:
    """What machine code alone decides."""
    pytest.importorskip("llvmlite")
    body = DRIVEN.format(law="0.3*sin(3*time)")
    result = run(body, 2.0, backend="native", tolerance=1e-8, solver="exported")
    v, friction = result["slide.v"], result["slide.friction"]
    moving = np.abs(v) > 1e-4
    assert np.allclose(friction[moving], -0.2 * 2 * G * np.sign(v[moving]))
    assert {-1, 1} == {*np.sign(v[moving])}
