"""Impacts of points of mechanisms, beside a system in absolute coordinates made by hand.

Each body has (x, y, phi); pins and the contact are rows of Jacobians. Poisson's law with Coulomb's
friction is solved for the one contact by its own few cases.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model

HEAD = """
model Mechanism
  import PlanarMultiBody.*;
  inner World world(gravityType=Types.GravityTypes.NoGravity);
  parameter Real e(unit="1")=0;
  parameter Real mu(unit="1")=0;
  Contacts.Contact contact(e=e, mu=mu);
  Parts.Fixed wall;
  Parts.FixedTranslation tip(r={0, 0});
"""
PENDULUM = (
    HEAD
    + """
  Joints.Revolute pin1(phi(start=0.3, fixed=true), w(start=0, fixed=true));
  Joints.Revolute pin2(phi(start=0.3, fixed=true), w(start=0, fixed=true));
  Parts.FixedTranslation rod(r={1, 0});
  Parts.Body body1(m=1, I=0.1, r_CM={0.5, 0});
  Parts.Body body2(m=1, I=0.1, r_CM={0.5, 0});
equation
  connect(world.frame_b, pin1.frame_a);
  connect(pin1.frame_b, rod.frame_a);
  connect(pin1.frame_b, body1.frame_a);
  connect(rod.frame_b, pin2.frame_a);
  connect(pin2.frame_b, body2.frame_a);
  connect(pin2.frame_b, tip.frame_a);
  connect(tip.frame_b, contact.frame_a);
  connect(wall.frame_b, contact.frame_b);
end Mechanism;
"""
)
FOURBAR = (
    HEAD
    + """
  Joints.Revolute pin1(phi(start=1, fixed=true), w(start=0, fixed=true));
  Joints.Revolute pin2(phi(start=-0.5));
  Joints.Revolute pin3(phi(start=-1));
  Joints.Revolute pin4;
  Parts.FixedTranslation crank(r={0.4, 0});
  Parts.FixedTranslation coupler(r={1, 0});
  Parts.FixedTranslation rocker(r={0.8, 0});
  Parts.FixedTranslation ground(r={1, 0});
  Parts.Body body1(m=1, I=0.1, r_CM={0.2, 0});
  Parts.Body body2(m=1, I=0.1, r_CM={0.5, 0});
  Parts.Body body3(m=1, I=0.1, r_CM={0.4, 0});
equation
  connect(world.frame_b, pin1.frame_a);
  connect(pin1.frame_b, crank.frame_a);
  connect(pin1.frame_b, body1.frame_a);
  connect(crank.frame_b, pin2.frame_a);
  connect(pin2.frame_b, coupler.frame_a);
  connect(pin2.frame_b, body2.frame_a);
  connect(coupler.frame_b, pin3.frame_a);
  connect(pin3.frame_b, rocker.frame_a);
  connect(pin3.frame_b, body3.frame_a);
  connect(rocker.frame_b, pin4.frame_b);
  connect(world.frame_b, ground.frame_a);
  connect(ground.frame_b, pin4.frame_a);
  connect(pin2.frame_b, tip.frame_a);
  connect(tip.frame_b, contact.frame_a);
  connect(wall.frame_b, contact.frame_b);
end Mechanism;
"""
)


def turned(phi: float, r: Sequence[float]) -> Any:
    c, s = np.cos(phi), np.sin(phi)
    return np.array([c * r[0] - s * r[1], s * r[0] + c * r[1]])


def point(body: int, bodies: int, lever: Any) -> Any:
    """The velocity of a point of a body from (x', y', phi') of all centres of mass."""
    row = np.zeros((2, 3 * bodies))
    row[:, 3 * body : 3 * body + 2] = np.eye(2)
    row[:, 3 * body + 2] = -lever[1], lever[0]
    return row


def impulses(a: Any, u: Any, e: float, mu: float) -> Any:
    """Poisson's law for one contact: a phase that ends the approach, and one that gives back."""

    def phase(start: Any, floor: float) -> Any:
        # Of a mechanism of one freedom both rows say nearly the same: rounding is larger there.
        for near, closed, way in product((1e-12, 1e-10), (False, True), (0, 1, -1)):
            rows, right = [], []
            if closed:
                rows.append(a[0])
                right.append(-start[0])
            else:
                rows.append([1.0, 0.0])
                right.append(floor)
            if way == 0:
                rows.append(a[1])
                right.append(-start[1])
            else:
                rows.append([way * mu, 1.0])
                right.append(0.0)
            if np.linalg.cond(np.array(rows)) > 1e10:
                continue
            x = np.linalg.solve(np.array(rows), np.array(right))
            end = a @ x + start
            if (
                x[0] >= floor - near
                and end[0] >= -near
                and (abs(x[1]) <= mu * x[0] + near if way == 0 else way * end[1] >= -near)
            ):
                return x
        raise AssertionError("no case")

    first = phase(u, 0.0)
    return first + phase(a @ first + u, e * first[0]) if e else first


def jumps(model: Model, given: dict[str, float], speed: Any) -> tuple[Any, Any, float, float]:
    """The bodies' velocities after an impact, ours and by hand; kinetic energy before, after."""
    names = [f"body{i}" for i in (1, 2, 3) if f"body{i}.m" in given]
    count, p = len(names), given
    angles = {n.removesuffix(".start"): v for n, v in given.items() if n.endswith(".start")}
    given = {n: v for n, v in given.items() if not n.endswith(".start")}
    angle = given["wall.phi"]
    far = 1e3 * np.array([np.sin(angle), -np.cos(angle)])
    apart = model.simulate(
        stop_time=1e-9,
        intervals=1,
        parameters={**given, "wall.r[1]": far[0], "wall.r[2]": far[1]},
        start=angles,
    )
    centre = [turned(apart[f"{b}.phi"][0], [p[f"{b}.r_CM[1]"], p[f"{b}.r_CM[2]"]]) for b in names]
    origin = [np.array([apart[f"{b}.frame_a.r[{k}]"][0] for k in (1, 2)]) for b in names]
    mass = np.diag([m for b in names for m in (p[f"{b}.m"], p[f"{b}.m"], p[f"{b}.I"])])
    pins = [point(0, count, -centre[0])]
    for k in range(1, count):
        here = origin[k] - origin[k - 1] - centre[k - 1]
        pins.append(point(k, count, -centre[k]) - point(k - 1, count, here))
    if count == 3:
        end = turned(apart["body3.phi"][0], [p["rocker.r[1]"], p["rocker.r[2]"]])
        pins.append(point(2, count, end - centre[2]))
    held = np.vstack(pins)
    arm = turned(apart["body2.phi"][0], [p["tip.r[1]"], p["tip.r[2]"]])
    normal = np.array([-np.sin(angle), np.cos(angle)])
    contact = np.array([normal, [normal[1], -normal[0]]]) @ point(1, count, arm - centre[1])
    rates = [speed[0], speed[0] + speed[1]] if count == 2 else [speed[0]]
    drive = np.vstack([np.eye(3 * count)[3 * i + 2] for i in range(len(rates))])
    whole = np.vstack([held, drive])
    before = np.linalg.solve(whole, np.concatenate([np.zeros(len(held)), rates]))
    sign = 1.0 if contact[0] @ before < 0 else -1.0
    before *= sign
    size = len(mass)
    kkt = np.block([[mass, held.T], [held, np.zeros((len(held), len(held)))]])
    given_by = np.linalg.solve(kkt, np.vstack([contact.T, np.zeros((len(held), 2))]))[:size]
    x = impulses(contact @ given_by, contact @ before, given["e"], given["mu"])
    after = before + given_by @ x
    place = origin[1] + arm
    start = {**angles, **{f"pin{i + 1}.w": sign * w for i, w in enumerate(speed)}}
    met = model.simulate(
        stop_time=1e-9,
        intervals=1,
        parameters={**given, "wall.r[1]": place[0], "wall.r[2]": place[1]},
        start=start,
    )
    ours = np.array([met[f"{b}.w"][0] for b in names])
    by_hand = after[2::3]
    energies = [float(v @ mass @ v) / 2 for v in (before, after)]
    return ours, by_hand, *energies


def a_pendulum(rng: Any) -> tuple[dict[str, float], Any]:
    given = {
        "rod.r[1]": rng.uniform(0.3, 2),
        "rod.r[2]": rng.uniform(-0.5, 0.5),
        "pin1.phi.start": rng.uniform(-3, 3),
        "pin2.phi.start": rng.uniform(-3, 3),
    }
    return given, rng.uniform(-5, 5, 2)


def a_fourbar(rng: Any) -> tuple[dict[str, float], Any]:
    given = {
        "crank.r[1]": rng.uniform(0.2, 0.4),
        "coupler.r[1]": rng.uniform(0.9, 1.1),
        "rocker.r[1]": rng.uniform(0.7, 0.9),
        "rocker.r[2]": 0.0,
    }
    return given, rng.uniform(-5, 5, 1)


@pytest.mark.usual
@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize(
    ("text", "make"), [(PENDULUM, a_pendulum), (FOURBAR, a_fourbar)], ids=["double", "four-bar"]
)
def test_velocities_jump_as_those_of_a_system_in_absolute_coordinates(
    text: str, make: Callable[[Any], tuple[dict[str, float], Any]], backend: str
) -> None:
    model = planarc.load(text, backend=backend)
    rng = np.random.default_rng(17)
    for count in range(100 if backend == "native" else 10):
        given, speed = make(rng)
        for body in (1, 2, 3) if text is FOURBAR else (1, 2):
            given[f"body{body}.m"] = rng.uniform(0.2, 5)
            given[f"body{body}.I"] = rng.uniform(0.02, 0.5)
            given[f"body{body}.r_CM[1]"] = rng.uniform(0, 1)
            given[f"body{body}.r_CM[2]"] = rng.uniform(-0.2, 0.2)
        given |= {"tip.r[1]": rng.uniform(0.2, 1.5), "tip.r[2]": rng.uniform(-0.5, 0.5)}
        given |= {"wall.phi": rng.uniform(-3, 3), "e": rng.uniform(0, 0.9)}
        given["mu"] = rng.uniform(0, 0.5) if count % 2 else 0.0
        if text is FOURBAR and count % 2:  # one freedom: how much friction bears is left open
            given["e"] = 0.0
        ours, by_hand, before, after = jumps(model, given, speed)
        np.testing.assert_allclose(ours, by_hand, rtol=0, atol=1e-10)
        assert after <= before * (1 + 1e-12)


@pytest.mark.usual
@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_an_impact_stops_what_it_hardly_moves(backend: str) -> None:
    """The normal is nearly square to the path of the point."""
    model = planarc.load(FOURBAR, backend=backend)
    tip = [0.6, -0.05]
    given = {"tip.r[1]": tip[0], "tip.r[2]": tip[1], "wall.r[2]": -1e3}

    def begun(w: float) -> Any:
        return model.simulate(stop_time=1e-9, intervals=1, parameters=given, start={"pin1.w": w})

    free = begun(1.0)
    arm = turned(free["body2.phi"][0], tip)
    end = np.array([free[f"body2.frame_a.r[{k}]"][0] for k in (1, 2)])
    path = free["body1.w"][0] * turned(np.pi / 2, end) + free["body2.w"][0] * turned(np.pi / 2, arm)
    given |= {"wall.r[1]": (end + arm)[0], "wall.r[2]": (end + arm)[1]}
    for off in (1e-2, 1e-3, 1e-4):
        given["wall.phi"] = float(np.arctan2(path[1], path[0])) + off
        meets, parts = (begun(w)["pin1.w"][0] for w in (4.0, -4.0))
        assert (meets, parts) == pytest.approx((0.0, -4.0), abs=1e-12)
