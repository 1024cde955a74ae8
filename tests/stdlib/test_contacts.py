"""Contacts by law: impacts, rest, sliding, sticking, rocking, with both back ends.

A `PartialTouch` is a `RigidTouch` or a `CompliantTouch` with its `damping`: both are held by what
they do in a `Contact`; the contours, each a `BaseContour`, by what touches them.
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import Any

import numpy as np
import pytest

import planarc
from tests.stdlib.small import FREE, G, both_backends, run

BALL = """
  Parts.Body ball(m=2, I=0.008, r(start={{{x!r}, {y!r}}}, each fixed=true),
    v(start={{{v!r}, 0}}, each fixed=true), phi(start=0, fixed=true), w(start=0, fixed=true));
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.HalfPlane contour2(angle={angle!r}), {law});
equation
  connect(ball.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""
BRICK = """
  Parts.Body brick(m=3, I=0.1, r(start={{{x!r}, {y!r}}}, each fixed=true),
    v(start={{{v!r}, 0}}, each fixed=true), phi(start={phi!r}, fixed=true),
    w(start=0, fixed=true));
  Contacts.Contact contact(
    redeclare Contacts.Point contour1(points={{{{-0.2, -0.1}}, {{0.2, -0.1}}}}),
    redeclare Contacts.HalfPlane contour2(angle={angle!r}), {law});
equation
  connect(brick.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""
COMPLIANT = "law=Types.ContactLaw.Compliant, c=1e8, "


def ball(law: str, y: float = 0.1, v: float = 0.0, angle: float = 0.0) -> str:
    return BALL.format(x=0.0, y=y, v=v, angle=angle, law=law)


def on_slope(law: str, angle: float) -> str:
    """A brick at rest on a slope."""
    x, y = -0.1 * sin(angle), 0.1 * cos(angle)
    return BRICK.format(x=x, y=y, v=0.0, phi=angle, angle=angle, law=law)


def kinetic(r: Any, body: str, mass: float, inertia: float) -> Any:
    speed = r[f"{body}.v[1]"] ** 2 + r[f"{body}.v[2]"] ** 2
    return mass * speed / 2 + inertia * r[f"{body}.w"] ** 2 / 2


# The compliant law


@both_backends
def test_a_body_at_rest_penetrates_by_what_its_weight_needs(backend: str) -> None:
    r = run(ball(COMPLIANT + "e=0.3"), 1, backend)
    depth = (2 * G / 1e8) ** (2 / 3)
    assert r["contact.gap[1]"][-1] == pytest.approx(-depth, rel=1e-3)


@both_backends
@pytest.mark.parametrize("e", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("exponent", [1, 1.5])
def test_the_compliant_law_gives_back_the_restitution(
    e: float, exponent: float, backend: str
) -> None:
    body = f"""
  Joints.Prismatic slide(n={{1, 0}}, s(start=1, fixed=true), v(start=-2, fixed=true));
  Parts.Body mass(m=2);
  Contacts.Contact contact(redeclare Contacts.HalfPlane contour2(angle=-Modelica.Constants.pi/2),
    law=Types.ContactLaw.Compliant, c=1e6, e={e}, exponent={exponent});
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
  connect(mass.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""
    r = run(body, 0.7, backend, intervals=10000)
    assert r["slide.v"][-1] == pytest.approx(2 * e, rel=1e-6)
    lost = np.trapezoid(r["contact.lossPower"], r["time"])
    assert 4 * (1 - e**2) == pytest.approx(lost, rel=0.01)


@both_backends
def test_a_yielding_ball_slides_until_it_rolls_and_sticks_on_a_slope(backend: str) -> None:
    r = run(ball(COMPLIANT + "e=0.5, mu=0.3", v=1.0), 2, backend)
    assert r["ball.v[1]"][-1] == pytest.approx(1 / (1 + 0.4), rel=1e-6)
    assert r["contact.slip[1]"][-1] == pytest.approx(0, abs=1e-9)
    r = run(on_slope(COMPLIANT + "e=0.5, mu=0.5", -0.2), 1, backend)
    assert abs(r["contact.slip[1]"][-1]) < 1e-7


PRESSED = """
  Joints.Prismatic slide(n={{0, 1}}, s(start={s!r}, fixed=true), v(start={v!r}, fixed=true));
  Parts.Body ball(m=1);
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    law=Types.ContactLaw.Compliant, c=1e6, e={e});
  {more};
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, ball.frame_a);
  connect(ball.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
  {equations};
"""
DEPTH = (G / 1e6) ** (2 / 3)  # in which the ball rests


def pressed(s: float, v: float, more: str = "", equations: str = "", e: float = 0.5) -> str:
    text = PRESSED.format(s=s, v=v, e=e, more=more, equations=equations)
    return "\n".join(line for line in text.splitlines() if line.strip() != ";")


@both_backends
def test_bodies_that_touch_at_the_start_rebound_as_those_that_meet(backend: str) -> None:
    """A blow of 2 m/s, from where the surfaces are just apart, just touch, and bear the weight."""
    meets, touches, bears = (
        run(pressed(s, -2), 0.02, backend, intervals=2000, tolerance=1e-9)
        for s in (0.1 + 1e-9, 0.1 - 1e-6, 0.1 - DEPTH)
    )
    for r, near in ((touches, 1e-4), (bears, 1e-3)):
        assert r["contact.f_n[1]"].max() == pytest.approx(meets["contact.f_n[1]"].max(), rel=near)
        assert r["slide.v"].max() == pytest.approx(meets["slide.v"].max(), rel=near)
    assert meets["slide.v"].max() == pytest.approx(0.5 * 2, rel=0.05)


@both_backends
def test_what_rests_is_struck_as_what_comes_with_that_speed(backend: str) -> None:
    """A hammer as heavy as the ball hands it all its 2 m/s, by the rigid law."""
    more = """Joints.Prismatic guide(n={0, 1}, s(start=0.5, fixed=true), v(start=-1, fixed=true));
  Parts.Body hammer(m=1);
  Contacts.Contact blow(redeclare Contacts.HalfPlane contour2(r={0, 0.1}), e=1)"""
    equations = """connect(world.frame_b, guide.frame_a);
  connect(guide.frame_b, hammer.frame_a);
  connect(hammer.frame_a, blow.frame_a);
  connect(ball.frame_a, blow.frame_b)"""
    body = pressed(0.1 - DEPTH, 0.0, more, equations)
    r = run(body, 0.3, backend, intervals=30000, tolerance=1e-9)
    struck = next(e.time for e in r.events if "impact of" in e.causes[0])
    speed = -sqrt(1 + 2 * G * (0.3 + DEPTH))
    at = r["time"].searchsorted(struck, "right")
    assert r["slide.v"][at] == pytest.approx(speed, rel=1e-2)
    alone = run(pressed(0.1 + 1e-9, speed), 0.02, backend, intervals=2000, tolerance=1e-9)
    soon = slice(at, r["time"].searchsorted(struck + 0.01))
    assert r["contact.f_n[1]"][soon].max() == pytest.approx(alone["contact.f_n[1]"].max(), rel=1e-3)


@both_backends
def test_what_is_pressed_on_rings_with_its_restitution_and_a_continuous_force(
    backend: str,
) -> None:
    """A blow on a ball under 1 kN, which never parts: each swing back is lower, and few happen."""
    more = "Forces.WorldForce load"
    r = run(
        pressed(0.1 - 0.01, -2, more, "connect(load.frame_b, ball.frame_a);\n"
                "  load.force = {0, -1000}", e=0.9),
        0.3, backend, intervals=30000, tolerance=1e-9,
    )  # fmt: skip
    force, speed = r["contact.f_n[1]"], r["slide.v"]
    assert force[1:].min() > 0
    for event in r.events:
        first, last = (r["time"].searchsorted(event.time, side) for side in ("left", "right"))
        assert last - first > 1
        assert force[first] == pytest.approx(force[last - 1], rel=1e-4)
    turns = np.flatnonzero((speed[1:-1] > speed[:-2]) & (speed[1:-1] >= speed[2:])) + 1
    peaks = speed[turns][speed[turns] > 0.05]
    assert len(peaks) >= 2
    assert (peaks[1:] < 0.7 * peaks[:-1]).all()
    assert abs(speed[-1]) < 1e-3
    assert len(r.events) < 10


@both_backends
def test_what_starts_deep_in_the_floor_is_thrown_out(backend: str) -> None:
    """Leaving takes D*e of what the floor stores, with (1 + e)*D = log((1 + D)/(1 - e*D))."""
    damping = 1.43275
    assert 1.5 * damping == pytest.approx(np.log((1 + damping) / (1 - 0.5 * damping)), rel=1e-5)
    r = run(pressed(0.1 - 0.02, 0.0), 0.02, backend, intervals=2000, tolerance=1e-9)
    given = 1e6 * 0.02**2.5 / 2.5 * (1 - 0.5 * damping)
    assert r["slide.v"].max() ** 2 / 2 == pytest.approx(given - G * 0.02, rel=1e-2)


def test_the_compliant_law_tends_to_the_rigid_one() -> None:
    """The time of contact, and with it the difference, goes with c^(-2/5)."""
    rigid = run(ball("e=0.5", y=1.1), 0.6, "native")["ball.r[2]"][-1]
    differences = []
    for c in ("1e7", "1e9", "1e11"):
        law = f"law=Types.ContactLaw.Compliant, c={c}, e=0.5"
        differences.append(abs(run(ball(law, y=1.1), 0.6, "native")["ball.r[2]"][-1] - rigid))
    orders = np.diff(np.log10(differences)) / 2
    np.testing.assert_allclose(orders, -0.4, atol=0.05)


# The rigid law


@both_backends
def test_a_ball_rests_at_the_end_of_the_geometric_series(backend: str) -> None:
    r = run(ball("e=0.5", y=1.1), 2, backend)
    rest = 3 * sqrt(2 / G)
    assert r["contact.rigid[1].rest"][-1] == pytest.approx(rest, abs=1e-9)
    touches = np.broadcast_to(r["contact.touches[1]"], r["time"].shape)
    assert r["time"][touches > 0][0] == pytest.approx(rest, abs=1e-9)
    assert r["contact.f_n[1]"][-1] == pytest.approx(2 * G)
    first = r.events[0]
    assert first.time == pytest.approx(sqrt(2 / G), abs=1e-10)
    impulse = 2 * 1.5 * sqrt(2 * G)
    assert first.causes == (f"`contact` of `ball` and the ground: impact of {impulse:.4g} N.s",)


@both_backends
@pytest.mark.parametrize("e", [0.5, 0.8, 0.95])
def test_many_bounces_end_at_the_right_time(e: float, backend: str) -> None:
    r = run(ball(f"e={e}", y=1.1), 18, backend, tolerance=1e-13, intervals=100)
    rest = (1 + e) / (1 - e) * sqrt(2 / G)
    assert r["contact.rigid[1].rest"][-1] == pytest.approx(rest, abs=1e-9)


@both_backends
def test_a_ball_slides_until_it_rolls(backend: str) -> None:
    r = run(ball("mu=0.3", v=1.0), 2, backend)
    assert r["ball.v[1]"][-1] == pytest.approx(1 / 1.4, abs=1e-9)
    assert r["ball.w"][-1] == pytest.approx(-10 / 1.4, abs=1e-8)
    (begins,) = r.events
    assert begins.time == pytest.approx((1 - 1 / 1.4) / (0.3 * G), abs=1e-9)
    assert begins.causes == ("`contact` of `ball` and the ground: sticks",)


@both_backends
def test_a_brick_on_a_slope_sticks_or_slides(backend: str) -> None:
    r = run(on_slope("mu=0.1", -0.2), 1, backend)
    along = np.hypot(r["brick.v[1]"][-1], r["brick.v[2]"][-1])
    assert along == pytest.approx(G * (sin(0.2) - 0.1 * cos(0.2)), abs=1e-8)
    assert r["contact.f_n[1]"][-1] + r["contact.f_n[2]"][-1] == pytest.approx(3 * G * cos(0.2))
    r = run(on_slope("mu=0.5", -0.2), 1, backend)
    assert np.ptp(r["brick.r[1]"]) < 1e-12
    friction = r["contact.f_t[1]"][-1] + r["contact.f_t[2]"][-1]
    assert abs(friction) == pytest.approx(3 * G * sin(0.2))


@both_backends
def test_a_brick_comes_to_rest_by_friction(backend: str) -> None:
    body = BRICK.format(x=0.0, y=0.1, v=1.0, phi=0.0, angle=0.0, law="mu=0.3")
    r = run(body, 1, backend)
    assert r["brick.r[1]"][-1] == pytest.approx(1 / (2 * 0.3 * G), abs=1e-8)
    assert r.events[0].time == pytest.approx(1 / (0.3 * G), abs=1e-8)


@both_backends
def test_a_tilted_brick_clatters_to_rest(backend: str) -> None:
    body = BRICK.format(x=0.0, y=0.5, v=0.0, phi=0.1, angle=0.0, law="e=0.3, mu=0.3")
    r = run(body, 2, backend, tolerance=1e-8)
    assert r["brick.phi"][-1] == pytest.approx(0, abs=1e-9)
    assert r["brick.r[2]"][-1] == pytest.approx(0.1, abs=1e-9)
    energy = kinetic(r, "brick", 3, 0.1) + 3 * G * r["brick.r[2]"]
    assert (np.diff(energy) < 1e-6).all()


@both_backends
def test_a_rocking_block_strikes_at_the_known_times(backend: str) -> None:
    block = planarc.load("PlanarMultiBody.Examples.Contacts.RockingBlock", backend=backend)
    r = block.simulate(
        backend=backend, tolerance=1e-13, solver="cvode-adams", parameters={"contact.mu": 10}
    )
    known = [0.563675757046, 1.253475910082, 1.799165833335, 2.256553860618]
    np.testing.assert_allclose([e.time for e in r.events], known, rtol=0, atol=1e-9)
    for event in r.events:
        (at,) = np.nonzero(np.abs(r["time"] - event.time) < 1e-12)
        ratio = r["body.w"][at[-1]] / r["body.w"][at[0]]
        assert ratio == pytest.approx(0.911764705882, abs=1e-9)


BLOCKS = """
  parameter Real m(unit="kg")=1;
  Joints.Prismatic slide1(n={1, 0}, s(start=1, fixed=true), v(start=0, fixed=true));
  Joints.Prismatic slide2(n={1, 0}, s(start=2, fixed=true), v(start=-1, fixed=true));
  Parts.Body light(m=1);
  Parts.Body heavy(m=m);
  Contacts.Contact wall(redeclare Contacts.HalfPlane contour2(angle=-Modelica.Constants.pi/2),
    e=1);
  Contacts.Contact blow(redeclare Contacts.HalfPlane contour2(angle=Modelica.Constants.pi/2),
    e=1);
equation
  connect(world.frame_b, slide1.frame_a);
  connect(world.frame_b, slide2.frame_a);
  connect(slide1.frame_b, light.frame_a);
  connect(slide2.frame_b, heavy.frame_a);
  connect(light.frame_a, wall.frame_a);
  connect(world.frame_b, wall.frame_b);
  connect(light.frame_a, blow.frame_a);
  connect(heavy.frame_a, blow.frame_b);
"""


@pytest.mark.parametrize(
    ("mass", "count", "backend"),
    [(1, 3, "native"), (1, 3, "numpy"), (100, 31, "native"), (100, 31, "numpy"),
     (1e4, 314, "native"), (1e6, 3141, "native")],
)  # fmt: skip
def test_collisions_of_two_blocks_and_a_wall_count_the_digits_of_pi(
    mass: float, count: int, backend: str
) -> None:
    no_gravity = "gravityType=PlanarMultiBody.Types.GravityTypes.NoGravity"
    r = run(BLOCKS, 20, backend, no_gravity, parameters={"m": mass})
    assert len(r.events) == count
    assert r["slide2.v"][-1] > r["slide1.v"][-1] > -1e-9


@both_backends
def test_a_ball_rolls_off_a_ledge_and_round_its_end(backend: str) -> None:
    body = """
  Parts.Body ball(m=1, I=0.004, r(start={0.5, 0.101}, each fixed=true), phi(fixed=true),
    v(start={1, 0}, each fixed=true), w(fixed=true));
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Segment contour2(a={0, 0}, b={1, 0}, R=0.001), mu=0.2);
equation
  connect(ball.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""
    r = run(body, 1.5, backend, tolerance=1e-8)
    assert [e.causes[0] for e in r.events[:3]] == [
        f"`contact` of `ball` and the ground: {what}" for what in ("sticks", "slides", "lets go")
    ]  # fmt: skip
    assert r["contact.gap[1]"].min() > -1e-7
    assert r["ball.r[2]"][-1] < -1


@both_backends
def test_a_ball_in_a_bowl_keeps_its_energy(backend: str) -> None:
    body = """
  Parts.Body ball(m=1, I=0.004, r(start={0.5, 0}, each fixed=true), phi(fixed=true),
    v(each fixed=true), w(fixed=true));
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=0.6, inside=true));
equation
  connect(ball.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""
    r = run(body, 2, backend)
    assert np.abs(r["contact.gap[1]"]).max() < 1e-7
    energy = kinetic(r, "ball", 1, 0.004) + G * r["ball.r[2]"]
    assert np.ptp(energy) < 1e-6


@both_backends
def test_a_cradle_passes_the_blow_on(backend: str) -> None:
    cradle = planarc.load("PlanarMultiBody.Examples.Contacts.NewtonsCradle", backend=backend)
    r = cradle.simulate(backend=backend, stop_time=1.4, tolerance=1e-8)
    assert r["hinge[5].phi"].max() == pytest.approx(0.5, abs=1e-3)
    for i in (2, 3, 4):
        assert np.abs(r[f"hinge[{i}].phi"]).max() < 1e-6
    assert len(r.events) == 1


@both_backends
@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams"])
def test_balls_that_hang_still_do_not_strike_each_other_by_errors(
    backend: str, solver: str
) -> None:
    """Ten blows in 10 s, of m*sqrt(2*g*l*(1 - cos(lift))) each, and none between them."""
    cradle = planarc.load("PlanarMultiBody.Examples.Contacts.NewtonsCradle", backend=backend)
    r = cradle.simulate(backend=backend, solver=solver)
    told = [cause for event in r.events for cause in event.causes]
    blows = [
        float(cause.partition("impact of ")[2].split()[0]) for cause in told if "impact" in cause
    ]
    np.testing.assert_allclose(blows, np.sqrt(2 * G * (1 - np.cos(0.5))), rtol=1e-3)
    assert len(blows) == 40
    assert len(r.events) < 20
    for i in (2, 3, 4):
        assert np.abs(r[f"hinge[{i}].phi"]).max() < 1e-5


@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams"])
def test_balls_hang_still_whatever_strikes_them(solver: str) -> None:
    """Differences of a state near zero are as long as suits it, so that the corrector does not move
    what does not depend on it."""
    cradle = planarc.load("PlanarMultiBody.Examples.Contacts.NewtonsCradle", backend="native")
    for lift in (0.51, 0.56, 0.57, 0.58, 0.69):
        r = cradle.simulate(solver=solver, parameters={"lift": lift})
        assert len(r.events) == 10
        for i in (2, 3, 4):
            assert np.abs(r[f"hinge[{i}].phi"]).max() < 1e-12


@both_backends
def test_energy_counts_what_impacts_took(backend: str) -> None:
    from planarc.insight.energy import find_energies

    r = run(ball("e=0.5, mu=0.2", y=1.1, v=1.0), 1.3, backend)
    energies = find_energies(r.rows, r.rows.program.mechanism)
    assert energies is not None
    assert np.abs(energies.balance).max() < 1e-3 * energies.exchanged
    assert energies.dissipated[-1] > 0.7 * 2 * G


def test_events_tell_the_bodies_that_meet() -> None:
    """By their parts with mass, the ground last, and the points that touch."""
    body = """
  Joints.Prismatic slide(n={1, 0}, s(start=0, fixed=true), v(start=1, fixed=true));
  Parts.FixedTranslation arm(r={0.2, 0}, animation=false);
  Parts.BodyShape bar(m=1, I=0.1, r={0.3, 0}, r_CM={0.1, 0});
  Parts.Body ball(m=1, I=0.1, r(start={0.7, 0}, each fixed=true), v(each fixed=true),
    phi(fixed=true), w(fixed=true));
  Contacts.Contact meet(redeclare Contacts.Point contour1(points={{0, 0.01}, {0, -0.01}}),
    redeclare Contacts.HalfPlane contour2(angle=Modelica.Constants.pi/2), e=1);
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, arm.frame_a);
  connect(arm.frame_b, bar.frame_a);
  connect(bar.frame_b, meet.frame_a);
  connect(ball.frame_a, meet.frame_b);
"""
    (meets,) = run(body, 0.3, "native", FREE).events
    assert [c.partition(": ")[0] for c in meets.causes] == [
        "`meet` (point 1) of `bar` and `ball`", "`meet` (point 2) of `bar` and `ball`",
    ]  # fmt: skip


@pytest.mark.usual
@both_backends
def test_a_carriage_on_redundant_guides_strikes_a_wall(backend: str) -> None:
    """As on one guide, and without a word about what the guides share at the blow."""
    body = """
  Joints.Prismatic lower(n={1, 0}, s(start=0, fixed=true), v(start=1, fixed=true));
  Joints.Prismatic upper(n={1, 0});
  Parts.FixedTranslation up(r={0, 1}), side(r={0, 1});
  Parts.Body carriage(m=2, I=1);
  Contacts.Contact contact(redeclare Contacts.Point contour1,
    redeclare Contacts.HalfPlane contour2(r={0.5, 0}, angle=Modelica.Constants.pi/2), e=0.5);
equation
  connect(world.frame_b, lower.frame_a);
  connect(world.frame_b, up.frame_a);
  connect(up.frame_b, upper.frame_a);
  connect(lower.frame_b, carriage.frame_a);
  connect(lower.frame_b, side.frame_a);
  connect(side.frame_b, upper.frame_b);
  connect(carriage.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""
    text = f"model Test\n  import PlanarMultiBody.*;\n  inner World world;\n{body}end Test;\n"
    carriage = planarc.load(text, backend=backend, redundant="accept")
    r = carriage.simulate(stop_time=1, backend=backend)
    assert r.events[0].causes == ("`contact` of `carriage` and the ground: impact of 3 N.s",)
    assert r["lower.v"][-1] == pytest.approx(-0.5, abs=1e-12)
    assert [w.code for w in r.warnings] == ["R416"]


@both_backends
def test_a_pendulum_strikes_a_wall_that_stands_upright(backend: str) -> None:
    """cos(pi/2) is 6e-17 to a computer: nothing may be divided by it. The wall is met as the rod
    hangs down, with the energy of the fall, and left with e times the speed."""
    result = run(
        """
  Joints.Revolute hinge(phi(start=-0.5, fixed=true), w(fixed=true));
  Parts.FixedTranslation rod(r={1, 0});
  Parts.Body bob(m=2, I=0.01);
  Contacts.Contact wall(redeclare Contacts.Circle contour1(R=0.1), e=0.5,
    redeclare Contacts.HalfPlane contour2(r={-0.1, 0}, angle=-Modelica.Constants.pi/2));
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
  connect(bob.frame_a, wall.frame_a);
  connect(world.frame_b, wall.frame_b);
""",
        1.5,
        backend,
    )
    first = result.events[0].time
    at = result.time.searchsorted(first)
    assert result["hinge.phi"][at] == pytest.approx(-np.pi / 2, abs=1e-9)
    speed = sqrt(2 * 2 * G * (1 - sin(0.5)) / (2 + 0.01))
    assert result["hinge.w"][at : at + 2] == pytest.approx([-speed, 0.5 * speed], rel=1e-8)


def test_forces_of_contacts_are_torn_and_those_of_joints_follow() -> None:
    """Of a chain of eight links: an acceleration for each, two forces for each contact."""
    body = """
  Joints.Revolute hinge[8](each phi(start=-0.2, fixed=true), each w(fixed=true));
  Parts.FixedTranslation rod[8](each r={1, 0});
  Parts.Body bob[8](each m=2, each I=0.01);
  Contacts.Contact floor[8](redeclare each Contacts.Circle contour1(R=0.1), each mu=0.3,
    redeclare each Contacts.HalfPlane contour2(r={0, -20}, angle=0.3));
equation
  connect(world.frame_b, hinge[1].frame_a);
  connect(rod[1:7].frame_b, hinge[2:8].frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
  connect(bob.frame_a, floor.frame_a);
  for i in 1:8 loop
    connect(world.frame_b, floor[i].frame_b);
  end for;
"""
    blocks = run(body, 0.01, "native").rows.program.blocks
    assert [len(b.tears) for b in blocks if not b.height] == [24]
