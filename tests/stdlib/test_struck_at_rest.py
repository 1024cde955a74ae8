"""Rigid touches that are closed when a speed is given, by law: an impact as of what comes so."""

from __future__ import annotations

from typing import Any

import pytest

from tests.stdlib.small import FREE, G, both_backends, run

WAYS = [("native", "cvode-bdf"), ("numpy", "cvode-bdf"), ("native", "exported")]
ways = pytest.mark.parametrize(("backend", "solver"), WAYS)

HUNG = """
  Joints.Prismatic guide(n={0, 1}, s(start=%s, fixed=true), v(start=0, fixed=true));
  Parts.Body body(m=2, I=0.1);
  %s;
equation
  connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, body.frame_a);
  connect(world.frame_b, %s.frame_a);
  connect(body.frame_a, %s.frame_b);
  when time > 0.3 then
    reinit(guide.v, %s);
  end when;
"""
STOP = ("0", "Contacts.PrismaticStops stop(n={0, 1}, s_min=0, e=0.5)", "stop", "stop")
ROPE = ("-1", "Contacts.Rope stop(length=1, e=0.5)", "stop", "stop")
DRIVEN = """
  Joints.Prismatic floor(n={{0, 1}}, drivenFlange=true);
  Modelica.Mechanics.Translational.Sources.{drive}(exact=true);
  Modelica.Blocks.Sources.{signal};
  Parts.Body ball(m=2, I=0.008, r(start={{0, 0.1}}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.HalfPlane contour2, e=0.5);
equation
  connect(world.frame_b, floor.frame_a);
  connect(signal.y, {given});
  connect(drive.flange, floor.axis);
  connect(floor.frame_b, contact.frame_b);
  connect(ball.frame_a, contact.frame_a);
"""
RAMP = ("Position drive", "Ramp signal(height=1, duration=1, startTime=0.3)", "drive.s_ref")
STEP = ("Speed drive", "Step signal(height=1, startTime=0.3)", "drive.v_ref")
BRICK = """
  Parts.Body brick(m=2, I=0.1, r(start={0, 0.1}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true), enforceStates=true);
  Contacts.Contact contact(redeclare Contacts.%s, redeclare Contacts.HalfPlane contour2, %s);
equation
  connect(brick.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
  when time > 0.3 then
    %s
  end when;
"""
#: A body that does not turn rests with one point on a floor whose speed jumps along it.
SLED = """
  Joints.Prismatic floor(drivenFlange=true);
  Modelica.Mechanics.Translational.Sources.Speed drive(exact=true);
  Modelica.Blocks.Sources.Step signal(height=0.3, startTime=0.3);
  Joints.Prismatic guide(s(fixed=true), v(fixed=true));
  Joints.Prismatic lift(n={0, 1}, s(fixed=true), v(fixed=true));
  Parts.Body body(m=2, I=0.1);
  Contacts.Contact contact(redeclare Contacts.Point contour1(points={{0, 0}}),
    redeclare Contacts.HalfPlane contour2, mu=0.5);
equation
  connect(world.frame_b, floor.frame_a);
  connect(signal.y, drive.v_ref);
  connect(drive.flange, floor.axis);
  connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, lift.frame_a);
  connect(lift.frame_b, body.frame_a);
  connect(body.frame_a, contact.frame_a);
  connect(floor.frame_b, contact.frame_b);
"""
CARTS = """
  Joints.Prismatic left(s(start=-0.1, fixed=true), v(fixed=true)), right(s(start=0.1, fixed=true),
    v(fixed=true));
  Parts.Body a(m=1), b(m=3);
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=0.1), e=0.5);
  Forces.WorldForce push, pull;
equation
  connect(world.frame_b, left.frame_a);
  connect(world.frame_b, right.frame_a);
  connect(left.frame_b, a.frame_a);
  connect(right.frame_b, b.frame_a);
  connect(a.frame_a, contact.frame_a);
  connect(b.frame_a, contact.frame_b);
  connect(push.frame_b, a.frame_a);
  connect(pull.frame_b, b.frame_a);
  push.force = {5, 0};
  pull.force = {-5, 0};
  when time > 0.3 then
    reinit(left.v, 1);
  end when;
"""
GEARS = """
  Parts.Fixed axle(r={0.15, 0});
  Joints.Revolute driver(drivenFlange=true, phi(fixed=true)),
    driven(phi(fixed=true), w(fixed=true));
  Modelica.Mechanics.Rotational.Sources.Speed drive(exact=true);
  Modelica.Blocks.Sources.Step signal(height=2, offset=2, startTime=0.5);
  Parts.Body wheel(m=1, I=0.05);
  Contacts.GearPair gears(Ra=0.05, Rb=0.1, backlash=1e-3, e=0);
  Forces.WorldTorque brake;
equation
  connect(world.frame_b, driver.frame_a);
  connect(axle.frame_b, driven.frame_a);
  connect(signal.y, drive.w_ref);
  connect(drive.flange, driver.axis);
  connect(driver.frame_b, gears.frame_a);
  connect(driven.frame_b, wheel.frame_a);
  connect(wheel.frame_a, gears.frame_b);
  connect(wheel.frame_a, brake.frame_b);
  brake.torque = -0.2*driven.w;
"""
#: A pendulum on a rope, and beside it a slide that begins to slide at 0.3*g/5 s.
SWING = """
  Parts.Body bob(m=2, I=0.01, r(start={0, -1}, each fixed=true), v(start={%s, 0}, each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Rope rope(length=1, e=0.5);
  Joints.PrismaticWithFriction slide(mu=0.3, s(fixed=true), v(fixed=true));
  Parts.Body mass(m=1);
  Forces.WorldForce pull;
equation
  connect(world.frame_b, rope.frame_a);
  connect(bob.frame_a, rope.frame_b);
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
  connect(pull.frame_b, mass.frame_a);
  pull.force = {5*time, 0};
"""


def behind(r: Any, t: float) -> int:
    """The row right behind an event."""
    return int(r["time"].searchsorted(t + 1e-9)) - 1


@ways
@pytest.mark.parametrize("hung", [STOP, ROPE])
def test_what_is_set_to_a_speed_against_its_stop_rebounds(
    hung: tuple[str, ...], backend: str, solver: str
) -> None:
    """A stop that bears the body, and a rope on which it hangs: v = e*1, 2*(1 + e) N.s."""
    r = run(HUNG % (*hung, -1), 0.35, backend, solver=solver)
    at = behind(r, 0.3)
    assert r["guide.v"][at] == pytest.approx(0.5, rel=1e-9)
    assert r.events[0].causes[0].endswith(": impact of 3 N.s, lets go")
    assert r["guide.s"].min() >= float(hung[0]) - 1e-9
    last, since = r["guide.s"][-1] - float(hung[0]), 0.05
    assert last == pytest.approx(0.5 * since - G / 2 * since**2, rel=1e-6)


@ways
@pytest.mark.parametrize("given", [RAMP, STEP])
def test_a_floor_that_starts_with_a_jerk_strikes_what_lies_on_it(
    given: tuple[str, ...], backend: str, solver: str
) -> None:
    """The ball leaves the floor with e times the floor's speed; the drive's own jump is told."""
    drive, signal, to = given
    r = run(DRIVEN.format(drive=drive, signal=signal, given=to), 0.35, backend, solver=solver)
    assert r["ball.v[2]"][behind(r, 0.3)] == pytest.approx(1.5, rel=1e-9)
    assert r["contact.gap[1]"].min() >= -1e-9
    assert solver == "exported" or [w.code for w in r.warnings] == ["R438"]


@ways
def test_friction_takes_its_part_in_the_impact_of_what_rests(backend: str, solver: str) -> None:
    """A ball that slides through its impact: v = 1 - mu*(1 + e), w = -mu*(1 + e)*m*R/I."""
    knock = "reinit(brick.v[1], 1); reinit(brick.v[2], -1);"
    body = BRICK % ("Circle contour1(R=0.1)", "e=0.5, mu=0.1", knock)
    r = run(body, 0.35, backend, solver=solver)
    at = behind(r, 0.3)
    assert r["brick.v[2]"][at] == pytest.approx(0.5, rel=1e-9)
    assert r["brick.v[1]"][at] == pytest.approx(1 - 0.1 * 1.5, rel=1e-9)
    assert r["brick.w"][at] == pytest.approx(-0.1 * 1.5 * 2 * 0.1 / 0.1, rel=1e-9)


@ways
@pytest.mark.parametrize("v", [0.2, 1e-3])
def test_what_sticks_and_is_given_a_speed_slides(v: float, backend: str, solver: str) -> None:
    """The way is v^2/(2*mu*g)."""
    points = "Point contour1(points={{-0.1, -0.1}, {0.1, -0.1}})"
    body = BRICK % (points, "mu=0.5", f"reinit(brick.v[1], {v});")
    r = run(body, 0.35, backend, solver=solver)
    assert r["brick.r[1]"][-1] == pytest.approx(v**2 / G, rel=1e-4, abs=1e-9)


@ways
def test_what_sticks_to_one_point_of_a_floor_that_starts_at_once_slides(
    backend: str, solver: str
) -> None:
    """No other point asks what happens; the body lags behind by v^2/(2*mu*g)."""
    r = run(SLED, 0.5, backend, solver=solver)
    assert r["floor.s"][-1] - r["guide.s"][-1] == pytest.approx(0.3**2 / G, rel=1e-4)
    assert r["guide.v"][-1] == pytest.approx(0.3, rel=1e-6)


@ways
def test_carts_that_press_each_other_keep_their_momentum(backend: str, solver: str) -> None:
    r = run(CARTS, 0.3 + 1e-6, backend, FREE, solver=solver)
    at = behind(r, 0.3)
    assert r["left.v"][at] == pytest.approx((1 - 0.5 * 3) / 4, rel=1e-9)
    assert r["right.v"][at] == pytest.approx(1.5 / 4, rel=1e-9)
    assert r["contact.gap[1]"].min() >= -1e-9


@ways
def test_gears_at_a_flank_keep_their_backlash_when_the_driver_jumps(
    backend: str, solver: str
) -> None:
    r = run(GEARS, 0.7, backend, FREE, solver=solver)
    assert r["gears.play"].max() <= 5e-4 + 1e-9
    assert r["driven.w"][behind(r, 0.5)] == pytest.approx(-2, rel=1e-6)


@both_backends
@pytest.mark.parametrize("v", [-1e-9, 1e-9, -1e-6])
def test_what_rounding_leaves_of_a_held_speed_is_no_impact(v: float, backend: str) -> None:
    r = run(HUNG % (*STOP, v), 1, backend)
    assert [e.causes for e in r.events] == [("time > 0.3",)]
    assert abs(r["guide.s"]).max() < 1e-6


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_errors_of_a_swing_do_not_slacken_its_rope(tolerance: float) -> None:
    """They are larger than all speeds that touches have had."""
    r = run(SWING % 3, 1.5, "native", tolerance=tolerance)
    assert [e.causes for e in r.events] == [("`slide`: slides",)]


@ways
def test_a_rope_that_slackens_lets_go(backend: str, solver: str) -> None:
    """Where v^2 = v0^2 - 2*g*(1 - cos(phi)) and the weight ask for no tension: in 0.481338 s."""
    r = run(SWING % 5.5, 0.55, backend, solver=solver, tolerance=1e-6)
    (slack,) = r.events
    assert slack.causes == ("`rope` of `bob` and the ground: lets go",)
    assert slack.time == pytest.approx(0.4813380, abs=1e-5)


@ways
def test_rounding_is_no_impact_of_a_bar_that_is_pushed_on_its_points(
    backend: str, solver: str
) -> None:
    """Of its four points only two are needed: it slides from 0.3*4*g/5 s on, and never parts."""
    points = "Point contour1(points={{-1, -0.1}, {-0.3, -0.1}, {0.3, -0.1}, {1, -0.1}})"
    push = "  Forces.WorldForce push;\nequation\n  push.force = {5*time, 0};\n"
    push += "  connect(push.frame_b, brick.frame_a);"
    body = (BRICK % (points, "mu=0.3", "")).replace("equation", push).partition("  when")[0]
    body = body.replace("m=2, I=0.1", "m=4, I=1, r_CM={0.2, 0}")
    r = run(body, 4, backend, tolerance=1e-8, solver=solver)
    since = 4 - 0.3 * 4 * G / 5
    assert r["brick.v[1]"][-1] == pytest.approx(5 * since**2 / 8, rel=1e-6)
    assert not [cause for e in r.events for cause in e.causes if "impact" in cause]


@ways
def test_an_impact_at_the_start_is_told(backend: str, solver: str) -> None:
    """And none of what only rests there."""
    body = (BRICK % ("Circle contour1(R=0.1)", "e=0.5", "")).partition("  when")[0]
    struck = body.replace("v(each fixed=true)", "v(start={0, -3}, each fixed=true)")
    (start,) = run(struck, 0.1, backend, solver=solver).events
    assert start.time == 0
    assert start.causes == ("`contact` of `brick` and the ground: impact of 9 N.s",)
    assert not run(body, 0.1, backend, solver=solver).events
