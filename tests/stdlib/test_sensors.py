"""Sensors on a double pendulum: what they tell is what the bodies do."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]

MODEL = """
  Joints.Revolute a(phi(start=0.3, fixed=true), w(start=1, fixed=true));
  Joints.Revolute b(phi(start=0.5, fixed=true), w(start=-2, fixed=true));
  Parts.BodyShape upper(r={0.8, 0}, m=1, I=0.1), lower(r={0.6, 0}, m=0.7, I=0.05);
  Sensors.CutForceAndTorque cut;
  Sensors.CutForce force(resolveInFrame=Types.ResolveInFrameAB.world);
  Sensors.CutTorque torque;
  Sensors.Power power;
  Sensors.AbsolutePosition r(resolveInFrame=Types.ResolveInFrameA.world);
  Sensors.AbsoluteVelocity v(resolveInFrame=Types.ResolveInFrameA.frame_a);
  Sensors.AbsoluteAcceleration acc(resolveInFrame=Types.ResolveInFrameA.frame_resolve);
  Sensors.AbsoluteAngle angle;
  Sensors.AbsoluteAngularVelocity speed;
  Sensors.AbsoluteSensor all(get_v=true, get_a=true, get_phi=true, get_w=true, get_z=true);
  Sensors.RelativePosition r_rel;
  Sensors.RelativeVelocity v_rel;
  Sensors.RelativeAcceleration a_rel(resolveInFrame=Types.ResolveInFrameAB.world);
  Sensors.RelativeAngle phi_rel;
  Sensors.RelativeAngularVelocity w_rel;
  Sensors.RelativeSensor relative(get_v_rel=true, get_a_rel=true, get_phi_rel=true,
    get_w_rel=true, get_z_rel=true);
  Sensors.Distance distance;
  Sensors.TransformAbsoluteVector turn(frame_r_in=Types.ResolveInFrameA.frame_a);
  Sensors.TransformRelativeVector turn2(frame_r_in=Types.ResolveInFrameAB.frame_a,
    frame_r_out=Types.ResolveInFrameAB.frame_b);
equation
  connect(world.frame_b, a.frame_a);
  connect(a.frame_b, upper.frame_a);
  connect(upper.frame_b, b.frame_a);
  connect(b.frame_b, cut.frame_a);
  connect(cut.frame_b, force.frame_a);
  connect(force.frame_b, torque.frame_a);
  connect(torque.frame_b, power.frame_a);
  connect(power.frame_b, lower.frame_a);
  connect(lower.frame_b, r.frame_a);
  connect(lower.frame_b, v.frame_a);
  connect(lower.frame_b, acc.frame_a);
  connect(acc.frame_resolve, upper.frame_a);
  connect(lower.frame_b, angle.frame_a);
  connect(lower.frame_b, speed.frame_a);
  connect(lower.frame_b, all.frame_a);
  connect(upper.frame_a, r_rel.frame_a);
  connect(lower.frame_b, r_rel.frame_b);
  connect(upper.frame_a, v_rel.frame_a);
  connect(lower.frame_b, v_rel.frame_b);
  connect(upper.frame_a, a_rel.frame_a);
  connect(lower.frame_b, a_rel.frame_b);
  connect(upper.frame_a, phi_rel.frame_a);
  connect(upper.frame_a, w_rel.frame_a);
  connect(lower.frame_b, w_rel.frame_b);
  connect(lower.frame_b, phi_rel.frame_b);
  connect(upper.frame_a, relative.frame_a);
  connect(lower.frame_b, relative.frame_b);
  connect(upper.frame_a, distance.frame_a);
  connect(lower.frame_b, distance.frame_b);
  connect(lower.frame_a, turn.frame_a);
  connect(upper.frame_a, turn2.frame_a);
  connect(lower.frame_a, turn2.frame_b);
  turn.r_in = {1, 2};
  turn2.r_in = {1, 2};
"""


class Seen:
    """A result, with plane vectors as complex numbers."""

    def __init__(self, result: Any) -> None:
        self.of = lambda name: np.broadcast_to(result[name], result.time.shape)
        phi1, phi2 = self.of("a.phi"), self.of("b.phi")
        w1, w2 = self.of("a.w"), self.of("b.w")
        z1, z2 = self.of("a.z"), self.of("b.z")
        self.e1, self.e2 = np.exp(1j * phi1), np.exp(1j * (phi1 + phi2))
        self.w2 = w2
        self.tip = 0.8 * self.e1 + 0.6 * self.e2
        self.v = 0.8j * w1 * self.e1 + 0.6j * (w1 + w2) * self.e2
        self.a = (
            0.8 * (1j * z1 - w1**2) * self.e1 + 0.6 * (1j * (z1 + z2) - (w1 + w2) ** 2) * self.e2
        )
        # As an observer on the upper link sees it.
        turn = self.e2 / self.e1
        self.seen = 0.8 + 0.6 * turn, 0.6j * w2 * turn, 0.6 * (1j * z2 - w2**2) * turn

    def vector(self, name: str) -> Any:
        return self.of(f"{name}[1]") + 1j * self.of(f"{name}[2]")


@pytest.fixture
def seen(run: Run) -> Seen:
    return _seen(run)


@cache
def _seen(run: Run) -> Seen:
    return Seen(run(MODEL))


def test_motion_against_the_world(seen: Seen) -> None:
    for name, expected in {
        "r.r": seen.tip,
        "v.v": seen.v / seen.e2,
        "acc.a": seen.a / seen.e1,
        "all.r": seen.tip,
        "all.v": seen.v,
        "all.a": seen.a,
    }.items():
        np.testing.assert_allclose(seen.vector(name), expected, atol=1e-9, err_msg=name)
    for name in ("angle.phi", "all.phi"):
        np.testing.assert_allclose(seen.of(name), seen.of("a.phi") + seen.of("b.phi"))
    for name in ("speed.w", "all.w"):
        np.testing.assert_allclose(seen.of(name), seen.of("a.w") + seen.of("b.w"), atol=1e-12)
    np.testing.assert_allclose(seen.of("all.z"), seen.of("a.z") + seen.of("b.z"), atol=1e-9)


def test_motion_against_a_turning_frame(seen: Seen) -> None:
    r, v, a = seen.seen
    for name, expected in {
        "r_rel.r_rel": r,
        "v_rel.v_rel": v,
        "a_rel.a_rel": a * seen.e1,
        "relative.r_rel": r,
        "relative.v_rel": v,
        "relative.a_rel": a,
    }.items():
        np.testing.assert_allclose(seen.vector(name), expected, atol=1e-9, err_msg=name)
    for name, coordinate in {
        "phi_rel.phi_rel": "b.phi",
        "w_rel.w_rel": "b.w",
        "relative.phi_rel": "b.phi",
        "relative.w_rel": "b.w",
        "relative.z_rel": "b.z",
    }.items():
        np.testing.assert_allclose(seen.of(name), seen.of(coordinate), atol=1e-9)
    np.testing.assert_allclose(seen.of("distance.distance"), np.abs(seen.tip))


def test_loads_in_a_connection(seen: Seen) -> None:
    """The hinge carries the weight and the inertia of the lower link, and no torque."""
    load = 0.7 * (seen.vector("lower.body.a_CM") + 9.81j)
    np.testing.assert_allclose(seen.vector("force.force"), load, atol=1e-9)
    np.testing.assert_allclose(seen.vector("cut.force"), load / seen.e2, atol=1e-9)
    np.testing.assert_allclose(seen.of("torque.torque"), 0, atol=1e-9)
    np.testing.assert_allclose(seen.of("cut.torque"), 0, atol=1e-9)


def test_power_raises_the_energy_behind_it(seen: Seen) -> None:
    v, w = seen.vector("lower.body.v_CM"), seen.of("lower.body.w")
    load = 0.7 * (seen.vector("lower.body.a_CM") + 9.81j)
    rate = (load * v.conj()).real + 0.05 * seen.of("lower.body.z") * w
    np.testing.assert_allclose(seen.of("power.power"), rate, atol=1e-8)


def test_vectors_are_turned_and_keep_their_length(seen: Seen) -> None:
    np.testing.assert_allclose(seen.vector("turn.r_out"), (1 + 2j) * seen.e2, atol=1e-12)
    np.testing.assert_allclose(seen.vector("turn2.r_out"), (1 + 2j) * seen.e1 / seen.e2, atol=1e-12)
