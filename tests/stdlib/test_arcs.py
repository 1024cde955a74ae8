"""Arcs by law: hills, bowls and rockers, against what touches them and what they touch.

`arcGap` is held by how a rocker rolls, and rolls over its end.
"""

from __future__ import annotations

from math import acos, cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from tests.stdlib.small import G, both_backends, run

FLOORS = {
    "plane": "HalfPlane {}",
    "edge": "Segment {}(a={{-2, -0.01}}, b={{2, -0.01}}, R=0.01)",
    "block": "Polygon {}(vertices=[-2,-1; 2,-1; 2,0; -2,0])",
}
ARC = "redeclare Contacts.Arc {}(R={}, r={{{}, {}}}, angle1={!r}, angle2={!r}, h={!r})"


def body(name: str, x: float, y: float, phi: float = 0.0, w: float = 0.0, v: str = "0, 0") -> str:
    return (
        f"  Parts.Body {name}(m=1, I=0.02, r(start={{{x!r}, {y!r}}}, each fixed=true),\n"
        f"    v(start={{{v}}}, each fixed=true), phi(start={phi!r}, fixed=true),\n"
        f"    w(start={w!r}, fixed=true));\n"
    )


def on_world(first: str, second: str, law: str) -> str:
    """A contact of the body `a`, with the first contour, and the world."""
    return (
        f"  Contacts.Contact c({first}, {second}, {law});\n"
        "equation\n  connect(a.frame_a, c.frame_a);\n  connect(world.frame_b, c.frame_b);\n"
    )


def energy(r: Any, height: Any) -> Any:
    speed = r["a.v[1]"] ** 2 + r["a.v[2]"] ** 2 + 0.02 * r["a.w"] ** 2
    return speed / 2 + G * height


@both_backends
@pytest.mark.parametrize("radius", [0.0, 0.1])
def test_what_slides_down_a_hill_leaves_it_at_two_thirds(radius: float, backend: str) -> None:
    contour = f"Contacts.Circle contour1(R={radius})" if radius else "Contacts.Point contour1"
    hill = ARC.format("contour2", 0.5, 0, 0, 0.0, pi, 0.01)
    top, tilt = 0.51 + radius, 0.1
    text = body("a", top * sin(tilt), top * cos(tilt)) + on_world(
        "redeclare " + contour, hill, "mu=0"
    )
    r = run(text, 1, backend)
    (leaves,) = r.events
    at = int(np.argmin(np.abs(r["time"] - leaves.time)))
    height = r["a.r[2]"][at] / top
    assert height == pytest.approx(2 / 3 * cos(tilt), abs=1e-7)
    assert leaves.causes == ("`c` of `a` and the ground: lets go",)


@both_backends
def test_a_ball_leaves_a_bowl_at_its_end_and_comes_back(backend: str) -> None:
    """It is let go within the left end, and leaves the right one, lower, along its tangent."""
    ball = "redeclare Contacts.Circle contour1(R=0.1)"
    bowl = ARC.format("contour2", 0.61, 0, 0, -pi, -0.8, 0.01)
    r = run(
        body("a", -0.5 * cos(0.2), -0.5 * sin(0.2)) + on_world(ball, bowl, "mu=0"),
        2,
        backend,
        tolerance=1e-11,
    )
    assert np.ptp(energy(r, r["a.r[2]"])) < 1e-7
    leaves = r.events[0]
    at = int(np.argmin(np.abs(r["time"] - leaves.time)))
    x, y = r["a.r[1]"][at], r["a.r[2]"][at]
    assert (x, y) == pytest.approx((0.5 * cos(0.8), -0.5 * sin(0.8)), abs=1e-7)
    speed = sqrt(2 * G * 0.5 * (sin(0.8) - sin(0.2)))
    assert r["a.v[2]"][at] == pytest.approx(speed * cos(0.8), abs=1e-6)


def quarter(swing: float, radius: float, low: float) -> float:
    """The time in which a rocker rolls from its turning point to its middle; its centre of mass is
    `low` below the centre of its round."""
    lean = radius - low

    def rate(u: float) -> float:
        phi = swing * sin(u)
        mass = 0.02 + radius**2 + low**2 - 2 * radius * low * cos(phi)
        drop = 2 * G * low * (cos(phi) - cos(swing))
        return swing * cos(u) * sqrt(mass / drop)

    assert lean > 0
    return float(quad(rate, 0, pi / 2, epsabs=1e-13, epsrel=1e-13)[0])


@pytest.mark.parametrize(
    ("floor", "first", "backend"),
    [("plane", True, "native"), ("plane", False, "numpy"), ("edge", True, "numpy"),
     ("block", True, "native"), ("block", False, "native")],
)  # fmt: skip
def test_a_rocker_rolls_with_its_period(floor: str, first: bool, backend: str) -> None:
    names = ("contour1", "contour2") if first else ("contour2", "contour1")
    frames = ("frame_a", "frame_b") if first else ("frame_b", "frame_a")
    radius, low, swing = 0.51, 0.3, 0.4
    centre = body("a", -radius * swing + low * sin(swing), radius - low * cos(swing), phi=swing)
    arc = ARC.format(names[0], 0.5, 0, low, -pi + 0.2, -0.2, 0.01)
    text = centre + (
        f"  Contacts.Contact c({arc}, redeclare Contacts.{FLOORS[floor].format(names[1])}, mu=2);\n"
        f"equation\n  connect(a.frame_a, c.{frames[0]});\n"
        f"  connect(world.frame_b, c.{frames[1]});\n"
    )
    half = 2 * quarter(swing, radius, low)
    r = run(text, half, backend, tolerance=1e-11)
    assert r["a.phi"][-1] == pytest.approx(-swing, abs=1e-7)
    assert r["a.w"][-1] == pytest.approx(0, abs=1e-6)
    np.testing.assert_allclose(
        r["a.r[1]"], -radius * r["a.phi"] + low * np.sin(r["a.phi"]), atol=1e-7
    )
    assert not [e for e in r.events if "impact" in str(e.causes)]


@both_backends
def test_a_rocker_rolls_over_its_end_without_a_blow(backend: str) -> None:
    """Its end goes on rolling, so that it keeps its energy; where it turns back, too."""
    arc = ARC.format("contour1", 0.5, 0, 0.5, -pi / 2 - 0.3, -pi / 2 + 0.3, 0.02)
    text = body("a", 0.0, 0.02, w=-7.0, v="0.14, 0") + on_world(
        arc, "redeclare Contacts.HalfPlane contour2", "mu=5"
    )
    r = run(text, 1, backend, tolerance=1e-11)
    assert np.ptp(energy(r, r["a.r[2]"])) < 1e-6
    assert r["a.phi"].min() < -0.35
    on_end = r["a.phi"] < -0.31
    assert r["c.f_n[3]"][on_end].min() > 1 and np.abs(r["c.f_n[1]"][on_end]).max() < 1e-9
    assert r["c.gap[3]"].min() > -1e-9


@both_backends
def test_a_bridge_stands_on_its_ends(backend: str) -> None:
    arc = ARC.format("contour1", 0.5, 0, 0, 0.0, pi, 0.02)
    text = body("a", 0.0, 0.02) + on_world(
        arc, "redeclare Contacts." + FLOORS["block"].format("contour2"), "mu=0.5"
    )
    r = run(text, 1, backend)
    assert np.ptp(r["a.r[2]"]) < 1e-12 and np.ptp(r["a.phi"]) < 1e-12
    assert r["c.f_n[2]"][-1] == pytest.approx(G / 2)
    assert r["c.f_n[3]"][-1] == pytest.approx(G / 2)


def test_a_whole_ring_rolls_as_a_disc_does() -> None:
    """On a hill, of which it rolls down and from which it falls."""
    hill = ARC.format("contour2", 0.5, 0, 0, 0.0, pi, 0.01)
    found = []
    for first in (ARC.format("contour1", 0.09, 0, 0, 0.3, 0.3 + 2 * pi, 0.01),
                  "redeclare Contacts.Circle contour1(R=0.1)"):  # fmt: skip
        text = body("a", 0.61 * sin(0.2), 0.61 * cos(0.2)) + on_world(first, hill, "mu=0.8")
        r = run(text, 1, "native")
        found.append([r[v][-1] for v in ("a.r[1]", "a.r[2]", "a.w")])
    np.testing.assert_allclose(found[0], found[1], atol=1e-7)
    assert acos(found[0][1] / 0.61) > 0.5


@both_backends
@pytest.mark.parametrize("first", [True, False])
def test_a_block_slides_in_a_bowl_like_a_pendulum(first: bool, backend: str) -> None:
    """Its two lower corners stay on the wall: it turns about the centre of the bowl."""
    names = ("contour1", "contour2") if first else ("contour2", "contour1")
    frames = ("frame_a", "frame_b") if first else ("frame_b", "frame_a")
    depth, swing = sqrt(0.5**2 - 0.1**2) - 0.1, 0.5
    block = (
        f"redeclare Contacts.Polygon {names[0]}(vertices=[-0.1,-0.1; 0.1,-0.1; 0.1,0.1; -0.1,0.1])"
    )
    bowl = ARC.format(names[1], 0.51, 0, 0, -pi, 0.0, 0.01)
    text = body("a", depth * sin(swing), -depth * cos(swing), phi=swing) + (
        f"  Contacts.Contact c({block}, {bowl});\n"
        f"equation\n  connect(a.frame_a, c.{frames[0]});\n"
        f"  connect(world.frame_b, c.{frames[1]});\n"
    )
    r = run(text, 1, backend, tolerance=1e-11)
    np.testing.assert_allclose(r["a.r[1]"], depth * np.sin(r["a.phi"]), atol=1e-7)
    np.testing.assert_allclose(r["a.r[2]"], -depth * np.cos(r["a.phi"]), atol=1e-7)
    fall = 2 * G * depth * (np.cos(r["a.phi"]) - cos(swing)) / (0.02 + depth**2)
    np.testing.assert_allclose(r["a.w"] ** 2, fall, atol=1e-6)
    assert r["a.phi"].min() < -0.4


@pytest.mark.parametrize("second", ["Circle contour2(R=0.6, inside=true)",
                                    "Arc contour2(R=0.61, h=0.01)"])  # fmt: skip
def test_a_ball_at_the_centre_of_a_bowl_falls_freely(second: str) -> None:
    text = body("a", 0.0, 0.0) + on_world(
        "redeclare Contacts.Circle contour1(R=0.1)", "redeclare Contacts." + second, "e=0.5"
    )
    r = run(text, 0.4, "native")
    assert r.events[0].time == pytest.approx(sqrt(2 * 0.5 / G), abs=1e-9)
