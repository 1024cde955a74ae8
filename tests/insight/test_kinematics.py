"""Paths, velocities, forces and instant centres, against theorems of kinematics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc.insight.kinematics import find_layers


@pytest.fixture
def layers_of(run_of: Callable[..., Any]) -> Callable[..., Any]:
    def make(name: str, **options: Any) -> Any:
        result, _ = run_of(name, **options)
        found = find_layers(result, result.program.mechanism)
        return result, {layer.id: {m.name: m for m in layer.members} for layer in found}

    return make


def test_the_couplers_centre_lies_where_kennedy_says(layers_of: Callable[..., Any]) -> None:
    # Crank and coupler have their centre in B, rocker and coupler in C; so that of the coupler
    # against the ground is where the lines A-B and D-C meet.
    result, layers = layers_of("Loops.FourBar", tolerance=1e-8)
    centre = layers["centres"]["coupler"]
    a, d = np.array([0.0, 0.0]), np.array([1.0, 0.0])
    checked = 0
    for row in range(0, len(result.time), 7):
        b = np.array([result[f"crank.frame_b.r[{i}]"][row] for i in (1, 2)])
        c = np.array([result[f"rocker.frame_b.r[{i}]"][row] for i in (1, 2)])
        lines = np.array([b - a, d - c]).T
        if abs(result["coupler.body.w"][row]) < 0.1 or np.linalg.cond(lines) > 50:
            continue  # at rest, or parallel: the centre is far away
        meet = a + np.linalg.solve(lines, d - a)[0] * (b - a)
        assert (centre.x[row], centre.y[row]) == pytest.approx(tuple(meet), rel=1e-4, abs=1e-4)
        checked += 1
    assert checked > 30


def test_the_crank_turns_about_its_bearing(layers_of: Callable[..., Any]) -> None:
    result, layers = layers_of("Loops.FourBar")
    centre = layers["centres"]["crank"]
    turning = abs(result["crank.body.w"]) > 0.1
    np.testing.assert_allclose(centre.x[turning], 0.0, atol=1e-9)
    np.testing.assert_allclose(centre.y[turning], 0.0, atol=1e-9)
    assert not centre.on  # a bearing in the ground is no news


def test_velocities_are_the_derivatives_of_positions(layers_of: Callable[..., Any]) -> None:
    result, layers = layers_of("Loops.FourBar", intervals=4000)
    inner = slice(2, -2)
    for kind, order in (("velocities", 1), ("accelerations", 2)):
        for name, mark in layers[kind].items():
            for position, vector in ((mark.x, mark.u), (mark.y, mark.v)):
                slope = np.asarray(position)
                for _ in range(order):
                    slope = np.gradient(slope, result.time)
                size = np.max(np.abs(vector)) + 1e-9
                np.testing.assert_allclose(
                    slope[inner] / size, vector[inner] / size, atol=2e-2, err_msg=f"{kind} {name}"
                )


def test_the_ends_of_a_rod_move_alike_along_it(layers_of: Callable[..., Any]) -> None:
    # A rigid rod: the velocities of its ends have equal components along it.
    _, layers = layers_of("Loops.FourBar")
    b, c = layers["velocities"]["revB"], layers["velocities"]["revC"]
    dx, dy = c.x - b.x, c.y - b.y
    np.testing.assert_allclose(dx * b.u + dy * b.v, dx * c.u + dy * c.v, atol=1e-4)


def test_joint_forces_act_on_what_they_hold(layers_of: Callable[..., Any]) -> None:
    # All forces on the coupler give its centre of mass its acceleration: m*(a - g).
    result, layers = layers_of("Loops.FourBar")
    forces = layers["forces"]
    assert {"revB on coupler", "revD on rocker", "revA on crank"} <= set(forces)
    on_c = next(f for name, f in forces.items() if name.startswith("revC"))
    sign = 1 if "coupler" in on_c.name else -1
    m = result["coupler.m"][0]
    along = m * result["coupler.body.a_CM[1]"]
    total = forces["revB on coupler"].u + sign * on_c.u
    np.testing.assert_allclose(total, along, atol=1e-6 * np.abs(along).max())


def test_points_that_stand_still_have_no_path(layers_of: Callable[..., Any]) -> None:
    _, layers = layers_of("Loops.FourBar")
    assert {"revB", "revC", "coupler.body centre"} <= set(layers["paths"])
    assert not {"revA", "revD"} & set(layers["paths"])


def test_a_cams_force_acts_where_it_touches(layers_of: Callable[..., Any]) -> None:
    result, layers = layers_of("CurveCurveJoint.CamFollower")
    mark = layers["forces"]["contact on follower"]
    touch = result["contact.frame_a.r[1]"] + result["contact.r1[1]"]
    np.testing.assert_allclose(mark.x, touch, atol=1e-6)
    np.testing.assert_allclose(np.hypot(mark.u, mark.v), abs(result["contact.f_N"]), atol=1e-9)


@pytest.mark.parametrize(
    ("name", "body", "mass", "inertia"),
    [("Contacts.RockingBlock", "body", 1.0, (0.2**2 + 0.8**2) / 12),
     ("Contacts.OffTheLedge", "ball", 1.0, 0.004)],
)  # fmt: skip
def test_the_forces_of_contacts_are_those_that_bodies_feel(
    name: str, body: str, mass: float, inertia: float, layers_of: Callable[..., Any]
) -> None:
    """By Newton and Euler, where they act."""
    result, layers = layers_of(name, tolerance=1e-10)
    marks = layers["contacts"].values()
    assert {m.name.split()[1] for m in marks} == {"normal", "friction"}
    force = [sum(m.u for m in marks), mass * 9.81 * -1 + sum(m.v for m in marks)]
    for i, total in enumerate(force, 1):
        np.testing.assert_allclose(total, mass * result[f"{body}.a[{i}]"], atol=1e-7)
    x, y = (result[f"{body}.r[{i}]"] for i in (1, 2))
    torque = sum((m.x - x) * m.v - (m.y - y) * m.u for m in marks)
    np.testing.assert_allclose(torque, inertia * result[f"{body}.z"], atol=1e-7)
    assert any(np.abs(m.v).max() > 0.1 for m in marks)
