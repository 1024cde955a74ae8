"""Polygons by law: against half planes, segments, circles, points and each other.

`polygonEdges`, `polygonCrossing` and `polygonHollow` are held by what a `Polygon` does and refuses.
"""

from __future__ import annotations

from functools import cache
from math import cos, sin, sqrt
from typing import Any

import numpy as np
import pytest

import planarc

both_backends = pytest.mark.parametrize("backend", ["native", "numpy"])

G = 9.81
BOX = "Contacts.Polygon {}(vertices=[-0.1,-0.1; 0.1,-0.1; 0.1,0.1; -0.1,0.1])"
HEAD = "model Test\n  import PlanarMultiBody.*;\n  inner World world{};\n"


@cache
def model(body: str, backend: str, world: str = "") -> planarc.Model:
    return planarc.load(HEAD.format(world) + body + "end Test;\n", backend=backend)


def box(name: str, x: float, y: float, v: float = 0.0, phi: float = 0.0) -> str:
    return (
        f"  Parts.Body {name}(m=1, I=0.01, r(start={{{x!r}, {y!r}}}, each fixed=true),\n"
        f"    v(start={{{v!r}, 0}}, each fixed=true), phi(start={phi!r}, fixed=true),\n"
        "    w(start=0, fixed=true));\n"
    )


def contact(name: str, contour1: str, contour2: str, law: str) -> str:
    return f"  Contacts.Contact {name}(redeclare {contour1}, redeclare {contour2}, {law});\n"


def joined(*pairs: tuple[str, str]) -> str:
    return "equation\n" + "".join(f"  connect({a}, {b});\n" for a, b in pairs)


ROCKING = """
  parameter Real tilt(unit="rad")=0.2;
  Parts.Body body(m=1, I=(0.2^2 + 0.8^2)/12,
    r(start={{0.4*sin(tilt), 0.4*cos(tilt) + 0.1*sin(tilt)}}, each fixed=true),
    v(each start=0, each fixed=true), phi(start=-tilt, fixed=true), w(start=0, fixed=true));
  Contacts.Contact contact(
    redeclare Contacts.Polygon {block}(vertices=[-0.1,-0.4; 0.1,-0.4; 0.1,0.4; -0.1,0.4]),
    redeclare Contacts.{floor}, e=0, mu=10);
equation
  connect(body.frame_a, contact.{frame});
  connect(world.frame_b, contact.{other});
"""


@pytest.mark.parametrize(
    ("floor", "first", "backend"),
    [("HalfPlane {}", True, "native"), ("HalfPlane {}", False, "numpy"),
     ("Segment {}(a={{-1,-0.01}}, b={{1,-0.01}}, R=0.01)", True, "native"),
     ("Polygon {}(vertices=[-1,-1; 1,-1; 1,0; -1,0])", True, "numpy"),
     ("Polygon {}(vertices=[-1,0; 1,0; 1,-1; -1,-1])", False, "native")],
)  # fmt: skip
def test_a_rocking_polygon_strikes_at_the_known_times(
    floor: str, first: bool, backend: str
) -> None:
    """The times of a block with given points, whichever contour comes first."""
    names = ("contour1", "contour2") if first else ("contour2", "contour1")
    frames = ("frame_a", "frame_b") if first else ("frame_b", "frame_a")
    text = ROCKING.format(
        block=names[0], floor=floor.format(names[1]), frame=frames[0], other=frames[1]
    )
    r = model(text, backend).simulate(
        stop_time=2.5, backend=backend, tolerance=1e-13, solver="cvode-adams"
    )
    known = [0.563675757046, 1.253475910082, 1.799165833335, 2.256553860618]
    np.testing.assert_allclose([e.time for e in r.events], known, rtol=0, atol=1e-9)


@both_backends
def test_a_polygon_slides_off_the_edge_of_another_without_a_blow(backend: str) -> None:
    """The corner of the table takes over; the block tips when its centre has passed it."""
    table = "Contacts.Polygon contour2(vertices=[-1,-1; 0,-1; 0,0; -1,0])"
    text = box("a", -0.5, 0.1, 3.0) + contact("c", BOX.format("contour1"), table, "mu=0.1")
    text += joined(("a.frame_a", "c.frame_a"), ("world.frame_b", "c.frame_b"))
    r = model(text, backend).simulate(stop_time=0.2, backend=backend, tolerance=1e-10)
    passes, tips = r.events
    a = 0.1 * G
    assert passes.time == pytest.approx((3 - sqrt(9 - 0.8 * a)) / a, abs=1e-7)
    # Its corner presses 0.1 m behind the centre, and the edge of the table rises to balance it:
    # the normal force stays m*g, and goes through a point mu*0.1 m ahead of the centre.
    x = 0.5 - 0.1 * 0.1
    assert tips.time == pytest.approx((3 - sqrt(9 - 2 * a * x)) / a, abs=1e-7)
    before = r["time"] < tips.time
    np.testing.assert_allclose(r["a.v[1]"][before], 3 - a * r["time"][before], atol=1e-9)
    assert r["a.w"][-1] < 0


@both_backends
def test_boxes_stand_on_each_other_edge_on_edge(backend: str) -> None:
    count = 3
    text = "".join(box(f"a[{i}]".replace("[", "").replace("]", ""), 0.0, 0.1 + 0.2 * i)
                   for i in range(count))  # fmt: skip
    text += contact("c0", BOX.format("contour1"), "Contacts.HalfPlane contour2", "mu=0.4")
    pairs = [("a0.frame_a", "c0.frame_a"), ("world.frame_b", "c0.frame_b")]
    for i in range(1, count):
        text += contact(f"c{i}", BOX.format("contour1"), BOX.format("contour2"), "mu=0.4")
        pairs += [(f"a{i}.frame_a", f"c{i}.frame_a"), (f"a{i - 1}.frame_a", f"c{i}.frame_b")]
    r = model(text + joined(*pairs), backend).simulate(stop_time=1, backend=backend)
    for i in range(count):
        assert np.ptp(r[f"a{i}.r[2]"]) < 1e-12 and np.ptp(r[f"a{i}.phi"]) < 1e-12
        points = 2 if i == 0 else 8
        force = sum(r[f"c{i}.f_n[{k}]"][-1] for k in range(1, points + 1))
        assert force == pytest.approx((count - i) * G)


@both_backends
def test_a_circle_meets_a_side_and_a_corner_of_a_polygon(backend: str) -> None:
    """Without friction: the normal impulse turns the velocity about the line to what is touched."""
    for x in (0.0, 0.12):
        text = box("ball", x, 0.5) + contact(
            "c", BOX.format("contour1"), "Contacts.Circle contour2(R=0.05)", "e=1"
        )
        text += joined(("ball.frame_a", "c.frame_b"), ("world.frame_b", "c.frame_a"))
        r = model(text, backend).simulate(stop_time=0.4, backend=backend, tolerance=1e-10)
        height = 0.15 if x <= 0.1 else 0.1 + sqrt(0.05**2 - (x - 0.1) ** 2)
        meets = sqrt(2 * (0.5 - height) / G)
        assert r.events[0].time == pytest.approx(meets, abs=1e-9)
        n = np.array([0.0, 1.0]) if x <= 0.1 else np.array([x - 0.1, height - 0.1]) / 0.05
        v = np.array([0, -G * meets])
        v = v - 2 * (v @ n) * n - np.array([0, G * (r["time"][-1] - meets)])
        np.testing.assert_allclose([r["ball.v[1]"][-1], r["ball.v[2]"][-1]], v, atol=1e-8)


@both_backends
def test_points_fall_on_a_slope_of_a_polygon(backend: str) -> None:
    """What slides down a side keeps the acceleration of the slope."""
    angle = 0.3
    wedge = "Contacts.Polygon contour2(vertices={{-1, 0}, {1, 0}, {-1, %r}})" % (
        2 * sin(angle) / cos(angle)
    )
    x, y = 0.0, sin(angle) / cos(angle)
    text = box("a", x, y) + contact("c", "Contacts.Point contour1", wedge, "mu=0.1")
    text += joined(("a.frame_a", "c.frame_a"), ("world.frame_b", "c.frame_b"))
    r = model(text, backend).simulate(stop_time=0.5, backend=backend, tolerance=1e-10)
    speed = np.hypot(r["a.v[1]"][-1], r["a.v[2]"][-1])
    assert speed == pytest.approx(0.5 * G * (sin(angle) - 0.1 * cos(angle)), abs=1e-8)
    assert r["c.f_n[1]"][-1] == pytest.approx(G * cos(angle))


@both_backends
def test_a_corner_meets_a_side_in_flight(backend: str) -> None:
    """Two free boxes: momentum and moment of momentum stay, and energy where e = 1."""
    text = box("a", 0.0, 0.0, 1.0, 0.3) + box("b", 0.5, 0.07, -1.0)
    text += contact("c", BOX.format("contour1"), BOX.format("contour2"), "e=1, mu=0.2")
    text += joined(("a.frame_a", "c.frame_a"), ("b.frame_a", "c.frame_b"))
    world = "(gravityType=Types.GravityTypes.NoGravity)"
    r = model(text, backend, world).simulate(stop_time=0.4, backend=backend, tolerance=1e-10)
    assert len(r.events) >= 1
    for k in (1, 2):
        total = r[f"a.v[{k}]"] + r[f"b.v[{k}]"]
        np.testing.assert_allclose(total, total[0], atol=1e-12)
    spin = sum(
        0.01 * r[f"{n}.w"] + r[f"{n}.r[1]"] * r[f"{n}.v[2]"] - r[f"{n}.r[2]"] * r[f"{n}.v[1]"]
        for n in ("a", "b")
    )
    np.testing.assert_allclose(spin, spin[0], atol=1e-10)
    energy = sum(
        (r[f"{n}.v[1]"] ** 2 + r[f"{n}.v[2]"] ** 2 + 0.01 * r[f"{n}.w"] ** 2) / 2 for n in "ab"
    )
    assert energy[-1] <= energy[0] * (1 + 1e-12)
    assert r["c.gap[1]"].min() > -1e-9


def test_a_polygon_is_drawn_filled() -> None:
    from planarc.view.item import Kind
    from planarc.view.scene import make_scene

    text = box("a", 0.0, 0.1) + contact(
        "c", BOX.format("contour1"), "Contacts.HalfPlane contour2", "e=0"
    )
    text += joined(("a.frame_a", "c.frame_a"), ("world.frame_b", "c.frame_b"))
    r: Any = model(text, "native").simulate(stop_time=0.1)
    items = [i for i in make_scene(r.rows).items if i.kind is Kind.CURVE]
    (outline,) = (i for i in items if len(i.points) == 5)
    assert outline.points[0] == outline.points[-1]
    assert outline.shape == "cam"
