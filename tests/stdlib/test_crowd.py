"""Contacts by steps, in crowds and between two contours: closed forms, balances, convergence."""

from __future__ import annotations

from math import cos, log, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

from planarc.core.diagnostic import PlanarcError
from tests.stdlib.small import FREE, G, both_backends, model, run

BODY = """
  Parts.Body {name}(m={m}, I={I}, r(start={{{x!r}, {y!r}}}, each fixed=true),
    v(start={{{v!r}, {u!r}}}, each fixed=true), phi(start={phi!r}, fixed=true),
    w(start={w!r}, fixed=true));
"""
BALL = 2.0, 0.008, 0.1  # mass, inertia, radius


def body(name: str, x: float, y: float, **given: float) -> str:
    values: dict[str, Any] = {"m": BALL[0], "I": BALL[1], "v": 0.0, "u": 0.0, "phi": 0.0, "w": 0.0}
    return BODY.format(name=name, x=x, y=y, **{**values, **given})


def crowd(bodies: dict[str, str], law: str, more: str = "") -> str:
    """Bodies, by name and declaration, that meet each other and what `more` says."""
    radii = "" if "R=" in more else f"R=fill({BALL[2]}, {len(bodies)}), "
    joined = "".join(
        f"  connect({name}.frame_a, crowd.frame_a[{i}]);\n" for i, name in enumerate(bodies, 1)
    )
    return (
        "".join(bodies.values())
        + f"  Contacts.Crowd crowd(n={len(bodies)}, {radii}{law}{more});\nequation\n"
        + joined
        + "  connect(world.frame_b, crowd.frame_b);\n"
    )


def floor(angle: float = 0.0, length: float = 20.0) -> str:
    x, y = length * cos(angle), length * sin(angle)
    return f", walls=[{-x!r}, {-y!r}, {x!r}, {y!r}]"


def on_slope(angle: float, law: str) -> str:
    at = body("ball", -BALL[2] * sin(angle), BALL[2] * cos(angle))
    return crowd({"ball": at}, law, floor(angle))


def energy(
    r: Any, names: list[str], m: float = BALL[0], inertia: float = BALL[1], g: float = G
) -> Any:
    return sum(
        m * (r[f"{n}.v[1]"] ** 2 + r[f"{n}.v[2]"] ** 2) / 2
        + inertia * r[f"{n}.w"] ** 2 / 2
        + m * g * r[f"{n}.frame_a.r[2]"]
        for n in names
    )


# One ball


@both_backends
def test_a_ball_that_is_dropped_comes_to_rest(backend: str) -> None:
    r = run(crowd({"ball": body("ball", 0, 0.4)}, "e=0.5", floor()), 3, backend)
    y = r["ball.frame_a.r[2]"]
    assert y[-1] == pytest.approx(0.1, abs=1e-6) and y.min() > 0.1 - 1e-9
    assert np.ptp(y[-50:]) < 1e-12
    assert r["crowd.f[1,2]"][-1] == pytest.approx(BALL[0] * G, rel=1e-9)
    assert r["crowd.f_b[2]"][-1] == pytest.approx(-BALL[0] * G, rel=1e-9)


@both_backends
@pytest.mark.parametrize("mu", [0.6, 0.1])
def test_a_ball_on_a_slope_rolls_or_slides(mu: float, backend: str) -> None:
    """Uniform acceleration is followed exactly."""
    angle, (m, inertia, R) = 0.5, BALL
    r = run(on_slope(angle, f"e=0, mu={mu}"), 1, backend)
    along = r["ball.frame_a.r[1]"] * cos(angle) + r["ball.frame_a.r[2]"] * sin(angle)
    if mu > tan(angle) * inertia / (inertia + m * R**2):
        a = G * sin(angle) / (1 + inertia / (m * R**2))
        spin = a / R
    else:
        a, spin = G * (sin(angle) - mu * cos(angle)), mu * m * G * cos(angle) * R / inertia
    assert along[-1] == pytest.approx(-a / 2, rel=1e-6)
    assert r["ball.w"][-1] == pytest.approx(spin, rel=1e-6)


@both_backends
def test_a_bar_sticks_where_friction_holds_it_and_slides_where_not(backend: str) -> None:
    angle = 0.4
    for mu, a in ((0.5, 0.0), (0.3, G * (sin(angle) - 0.3 * cos(angle)))):
        bar = body("bar", -0.05 * sin(angle), 0.05 * cos(angle), phi=angle)
        text = crowd({"bar": bar}, f"e=0, mu={mu}", f", R={{0.05}}, length={{0.6}}{floor(angle)}")
        r = run(text, 0.5, backend)
        way = np.hypot(r["bar.frame_a.r[1]"][-1] - r["bar.frame_a.r[1]"][0],
                       r["bar.frame_a.r[2]"][-1] - r["bar.frame_a.r[2]"][0])  # fmt: skip
        assert way == pytest.approx(a / 8, rel=1e-5, abs=1e-7)
        assert r["bar.phi"][-1] == pytest.approx(angle, abs=1e-6)


BOUNCES = """
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1), e=0.7, mu=0.1);
equation
  connect(ball.frame_a, contact.frame_a);
  connect(world.frame_b, contact.frame_b);
"""


def test_both_formulations_give_the_same() -> None:
    """A crowd's pair, and a Contact that tells its gap by its own equations."""
    ball = body("ball", 0, 0.5, v=0.6, w=3.0)
    steps = {"contact": "stepping", "fixed_step": 1e-3}
    one = run(crowd({"ball": ball}, "e=0.7, mu=0.1", floor()), 2, "native", **steps)
    other = run(ball + BOUNCES, 2, "native", **steps)
    for name in ("ball.frame_a.r[1]", "ball.frame_a.r[2]", "ball.v[2]", "ball.w"):
        np.testing.assert_allclose(one[name], other[name], atol=1e-9)
    np.testing.assert_allclose(one["crowd.f[1,2]"], other["contact.f_n[1]"], atol=1e-6)


def order(errors: list[float], halvings: int = 1) -> float:
    """The order with which errors shrink, where each step is half the one before."""
    x = -log(2) * np.arange(len(errors)) * halvings
    return float(np.polyfit(x, np.log(errors), 1)[0])


def test_steps_converge_to_events() -> None:
    """Impacts are found at the ends of steps, so that the error is of first order."""
    text = body("ball", 0, 0.5, v=0.6) + BOUNCES
    exact = run(text, 1.2, "native", intervals=150)
    rows = np.searchsorted(exact.time, np.linspace(0, 1.2, 151))
    errors = []
    for h in 0.008 / 2.0 ** np.arange(6):
        r = run(text, 1.2, "native", contact="stepping", fixed_step=float(h), intervals=150)
        off = [r[n] - exact[n][rows] for n in ("ball.frame_a.r[1]", "ball.frame_a.r[2]")]
        errors.append(float(np.sqrt(np.mean(np.square(off)))))
    assert 0.75 < order(errors) < 1.6
    assert errors[-1] < 1e-3


def test_two_bodies_part_as_by_events() -> None:
    """Off their centres, without friction: Newton's and Poisson's laws are one there."""
    bodies = body("one", 0, 0, v=2.0) + body("two", 0.5, 0.07, I=0.02)
    law = "e=0.6"
    exact = run(
        bodies + f"""
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1),
    redeclare Contacts.Circle contour2(R=0.1), {law});
equation
  connect(one.frame_a, contact.frame_a);
  connect(two.frame_a, contact.frame_b);
""", 0.5, "native", FREE)  # fmt: skip
    both = {"one": body("one", 0, 0, v=2.0), "two": body("two", 0.5, 0.07, I=0.02)}
    names = [f"{n}.v[{i}]" for n in both for i in (1, 2)]
    errors = []
    for h in 4e-3 / 2.0 ** np.arange(6):
        r = run(crowd(both, law), 0.5, "native", FREE, fixed_step=float(h))
        errors.append(max(abs(r[n][-1] - exact[n][-1]) for n in names))
    assert errors[-1] < 1e-3 and errors[-1] < errors[0] / 8


# Many


def gas(lengths: bool) -> tuple[str, list[str]]:
    rng = np.random.default_rng(17)
    bodies, n = {}, 16
    for i in range(n):
        v, u, w = rng.normal(size=3).tolist()
        at = 0.5 * (i % 4) + 0.4, 0.5 * (i // 4) + 0.4
        bodies[f"b{i}"] = body(f"b{i}", *at, v=v, u=u, w=w, phi=float(rng.uniform(0, 3)))
    more = f", length={{{', '.join(str(0.2 * (i % 2)) for i in range(n))}}}" if lengths else ""
    walls = ", walls=[0, 0, 3, 0; 3, 0, 3, 3; 3, 3, 0, 3; 0, 3, 0, 0]"
    return crowd(bodies, f"e=0, mu=0{more}", walls), list(bodies)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_energy_never_grows(e: float, mu: float) -> None:
    text, names = gas(lengths=True)
    for g in (0.0, G):
        given = {"crowd.e": e, "crowd.mu": mu, "world.g": g}
        r = run(text, 1.2, "native", fixed_step=1e-3, intervals=1200, parameters=given)
        found, kinetic = energy(r, names, g=g), energy(r, names, g=0.0)
        # A step adds m*g^2*h^2 at most where a body comes to rest.
        assert np.diff(found).max() < (1e-10 if g == 0 else 1e-5) * found[0]
        assert kinetic[-1] < kinetic[0] or e == 1 or g > 0


def test_an_elastic_gas_keeps_its_energy() -> None:
    text, names = gas(lengths=False)
    given = {"crowd.e": 1.0, "world.g": 0.0}
    r = run(text, 4, "native", fixed_step=1e-3, parameters=given)
    found = energy(r, names, g=0.0)
    assert found[-1] == pytest.approx(found[0], rel=1e-6)
    assert abs(r["b3.v[1]"][-1] - r["b3.v[1]"][0]) > 0.1


@both_backends
def test_momenta_balance(backend: str) -> None:
    """Bodies that meet far from everything, with friction."""
    both = {
        "one": body("one", 0, 0, v=2.0, w=5.0),
        "two": body("two", 0.5, 0.07, m=0.5, w=-2.0, phi=0.7),
        "three": body("three", 0.9, 0.1, v=-1.0),
    }
    text = crowd(both, "e=0.8, mu=0.3, length={0, 0.3, 0}")
    r = run(text, 1, backend, FREE, fixed_step=1e-3)
    m = {"one": 2.0, "two": 0.5, "three": 2.0}
    for i in (1, 2):
        p = sum(m[n] * r[f"{n}.v[{i}]"] for n in m)
        np.testing.assert_allclose(p, p[0], atol=1e-9)
    spin = sum(
        m[n] * (r[f"{n}.frame_a.r[1]"] * r[f"{n}.v[2]"] - r[f"{n}.frame_a.r[2]"] * r[f"{n}.v[1]"])
        + BALL[1] * r[f"{n}.w"]
        for n in m
    )
    np.testing.assert_allclose(spin, spin[0], atol=2e-3)
    assert abs(r["two.w"][-1] + 2) > 0.1


def test_a_pile_rests_and_weighs_what_its_bodies_weigh() -> None:
    n, R = 36, 0.05
    text = f"""
  parameter Integer n={n};
  Parts.Body ball[n](each m=1, each I=0.00125,
    r(start={{{{0.12*mod(i - 1, 6) + 0.01*sin(i*i), 0.06 + 0.11*div(i - 1, 6)}} for i in 1:n}},
      each fixed=true), v(each fixed=true), phi(each fixed=true), w(each fixed=true));
  Contacts.Crowd crowd(n=n, R=fill({R}, n), e=0.2, mu=0.4,
    walls=[-0.1, 0, 0.72, 0; -0.1, 0, -0.1, 2; 0.72, 0, 0.72, 2]);
equation
  connect(ball.frame_a, crowd.frame_a);
  connect(world.frame_b, crowd.frame_b);
"""
    r = run(text, 3, "native", fixed_step=2e-3)
    x = np.array([[r[f"ball[{i}].frame_a.r[{k}]"] for i in range(1, n + 1)] for k in (1, 2)])
    for row in range(0, x.shape[2], 25):
        apart = np.hypot(*(x[:, :, None, row] - x[:, None, :, row])) + 9 * np.eye(n)
        assert apart.min() > 2 * R * (1 - 1e-4)
        assert x[1, :, row].min() > R * (1 - 1e-4)
    speeds = [abs(r[f"ball[{i}].v[{k}]"][-1]) for i in range(1, n + 1) for k in (1, 2)]
    assert max(speeds) < 0.02
    assert np.mean(r["crowd.f_b[2]"][-100:]) == pytest.approx(-n * G, rel=0.01)


# Bodies that joints hold


def test_a_crowd_hangs_on_joints() -> None:
    """A pendulum's bob strikes a wall where its hinge would have a stop, at events."""
    arm = """
  Joints.Revolute hinge(phi(start=-0.5, fixed=true), w(fixed=true));
  Parts.FixedTranslation rod(r={{1, 0}});
  Parts.Body bob(m=2, I=0.01);
  {held}
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
  {connected}
"""
    stop = "Contacts.RevoluteStops stop(phi_min=-Modelica.Constants.pi/2, phi_max=9, e=0.5);"
    at = "connect(hinge.frame_a, stop.frame_a); connect(hinge.frame_b, stop.frame_b);"
    many = "Contacts.Crowd many(n=1, R={0.1}, e=0.5, walls=[-0.1, -9, -0.1, 9]);"
    to = "connect(rod.frame_b, many.frame_a[1]); connect(world.frame_b, many.frame_b);"
    exact = run(arm.format(held=stop, connected=at), 1.2, "native")
    errors = []
    for h in 4e-3 / 2.0 ** np.arange(5):
        r = run(arm.format(held=many, connected=to), 1.2, "native", fixed_step=float(h))
        errors.append(abs(r["hinge.phi"][-1] - exact["hinge.phi"][-1]))
    assert errors[0] < 0.1 and errors[-1] < errors[0] / 4


@both_backends
def test_closed_loops_are_stepped(backend: str) -> None:
    """A slider-crank whose slider meets a stop: its speed jumps, the loop holds."""
    text = """
  Joints.Revolute crank(phi(start=1, fixed=true), w(start=-2, fixed=true));
  Parts.BodyShape arm(m=1, r={0.3, 0}, r_CM={0.15, 0}, I=0.01);
  Parts.BodyShape rod(m=1, r={0.8, 0}, r_CM={0.4, 0}, I=0.05);
  Joints.Revolute elbow;
  Joints.Revolute pin;
  Joints.Prismatic slide(n={1, 0});
  Parts.Body slider(m=2, I=0.01);
  Contacts.Crowd many(n=1, R={0.1}, e=0.5, walls=[1.15, -1, 1.15, 1]);
equation
  connect(world.frame_b, crank.frame_a);
  connect(crank.frame_b, arm.frame_a);
  connect(arm.frame_b, elbow.frame_a);
  connect(elbow.frame_b, rod.frame_a);
  connect(rod.frame_b, pin.frame_a);
  connect(pin.frame_b, slide.frame_b);
  connect(world.frame_b, slide.frame_a);
  connect(slider.frame_a, slide.frame_b);
  connect(slide.frame_b, many.frame_a[1]);
  connect(world.frame_b, many.frame_b);
"""
    r = run(text, 1, backend, fixed_step=1e-3)
    assert r["slide.s"].max() < 1.05 + 1e-6
    assert r["slide.s"].max() > 1.045
    loop = 0.3 * np.sin(r["crank.phi"]) + 0.8 * np.sin(r["rod.frame_a.phi"])
    np.testing.assert_allclose(loop, 0, atol=1e-9)


def test_the_energy_of_a_loose_double_pendulum_is_kept() -> None:
    """No contact closes: what is left is the midpoint rule, of second order."""
    two = """
  Joints.Revolute one(phi(start=0, fixed=true), w(fixed=true));
  Joints.Revolute two(phi(start=1, fixed=true), w(fixed=true));
  Parts.BodyShape a(m=1, r={1, 0}, r_CM={0.5, 0}, I=0.1);
  Parts.BodyShape b(m=1, r={1, 0}, r_CM={0.5, 0}, I=0.1);
{crowd}
equation
  connect(world.frame_b, one.frame_a);
  connect(one.frame_b, a.frame_a);
  connect(a.frame_b, two.frame_a);
  connect(two.frame_b, b.frame_a);
{connected}"""
    many = "  Contacts.Crowd many(n=1, R={0.1}, walls=[-9, -9, 9, -9]);"
    held = "  connect(b.frame_b, many.frame_a[1]);\n  connect(world.frame_b, many.frame_b);\n"
    exact = run(two.replace("{crowd}", "").replace("{connected}", ""), 1, "native")
    text = two.replace("{crowd}", many).replace("{connected}", held)
    errors = [
        abs(run(text, 1, "native", fixed_step=h)["two.phi"][-1] - exact["two.phi"][-1])
        for h in (4e-3, 2e-3, 1e-3)
    ]
    assert order(errors) > 1.8


# What cannot be


def test_bodies_that_start_in_each_other_are_named() -> None:
    both = {"one": body("one", 0, 0), "two": body("two", 0.15, 0)}
    with pytest.raises(PlanarcError, match=r"`one.frame_a` and `two.frame_a` overlap by 0.05 m"):
        run(crowd(both, "e=0"), 1, "native", FREE)


def test_the_choice_is_known_by_its_words() -> None:
    from planarc.core.unknown import UnknownName

    with pytest.raises(UnknownName, match="stepping"):
        model(on_slope(0.1, "e=0"), "", "native").simulate(contact="steping")


def test_the_rest_takes_the_time_of_the_series() -> None:
    """The bounces of e end at (1 + e)/(1 - e)*sqrt(2h/g), but for the last ones within a step."""
    e, height = 0.5, 0.3
    r = run(crowd({"ball": body("ball", 0, 0.1 + height)}, f"e={e}", floor()), 2, "native",
            fixed_step=2e-4)  # fmt: skip
    moving = r.time[np.abs(r["ball.v[2]"]) > 1e-3][-1]
    assert moving == pytest.approx((1 + e) / (1 - e) * sqrt(2 * height / G), abs=0.02)
