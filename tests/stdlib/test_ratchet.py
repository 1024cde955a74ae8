"""`Ratchet` by the geometry of its teeth, with both back ends."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import planarc
from tests.stdlib.small import G, both_backends, run

R, DEPTH, NOSE, ARM, POST = 0.05, 0.01, 0.001, 0.07, (0.07, 0.055)
#: A wheel at the origin, a pawl that lies on it from the side `side` with its weight.
WINCH = """
  Joints.Revolute shaft(drivenFlange=true{start});
  Parts.Body wheel(m=1, I=5e-3);
  Modelica.Mechanics.Rotational.Sources.{drive};
  Parts.FixedTranslation post(r={{{x}, 0.055}}, animation=false);
  Joints.Revolute hinge(phi(start=0, fixed=true), w(start=0, fixed=true));
  Parts.Body pawl(r_CM={{{arm}/2, 0}}, m=0.05, I=2e-5);
  Contacts.Ratchet ratchet(n={n}, R=0.05, depth=0.01, r={{{arm}, 0}}, clockwise={clockwise}{law});
equation
  connect(drive.flange, shaft.axis);
  connect(world.frame_b, shaft.frame_a);
  connect(shaft.frame_b, wheel.frame_a);
  connect(world.frame_b, post.frame_a);
  connect(post.frame_b, hinge.frame_a);
  connect(hinge.frame_b, pawl.frame_a);
  connect(pawl.frame_a, ratchet.frame_a);
  connect(wheel.frame_a, ratchet.frame_b);
"""
LOADED = "ConstantTorque drive(tau_constant={})"
TURNING = "ConstantSpeed drive(w_fixed={}, phi(start=0, fixed=true))"
FREE_START = ", phi(start={}, fixed=true), w(start={}, fixed=true)"


def winch(drive: str, n: int = 12, side: int = 1, start: str = "", law: str = "") -> str:
    """`side` is 1 for a wheel that turns counter-clockwise, -1 for its mirror image."""
    return WINCH.format(
        drive=drive, n=n, start=start, law=law, x=side * POST[0], arm=-side * ARM,
        clockwise="true" if side < 0 else "false",
    )  # fmt: skip


def outline(n: int, side: int) -> Any:
    """The corners of the wheel, at its angle 0."""
    corners = []
    for k in range(n):
        for radius, angle in ((R, k), (R - DEPTH, k + 1)):
            turn = 2 * pi * angle / n
            corners.append((radius * cos(turn), side * radius * sin(turn)))
    return np.array(corners)


def distance(phi: Any, psi: Any, n: int, side: int) -> Any:
    """From the nose's centre to the nearest of all edges, wheel at `phi` and pawl at `psi`."""
    x = side * POST[0] - side * ARM * np.cos(psi)
    y = POST[1] - side * ARM * np.sin(psi)
    p = (x + 1j * y) * np.exp(-1j * np.asarray(phi))
    corners = outline(n, side) @ (1, 1j)
    least = np.inf
    for a, b in zip(corners, np.roll(corners, -1), strict=True):
        along = np.clip(((p - a) * np.conj(b - a)).real / abs(b - a) ** 2, 0, 1)
        least = np.minimum(least, np.abs(p - a - along * (b - a)))
    return least


def rest(n: int) -> tuple[float, float]:
    """The angles of wheel and pawl where the nose lies on a back and at a face, near phi = 0."""
    foot = (R - DEPTH) * np.exp(2j * pi / n)
    back = (foot - R) / abs(foot - R)
    normal = back / 1j  # away from the wheel, of the back that begins at the angle 0
    # NOSE from the back, and NOSE from the face at 2*pi/n: its centre in the wheel.
    face = -1j * np.exp(2j * pi / n)
    rows = np.array([[normal.real, normal.imag], [face.real, face.imag]])
    centre = np.linalg.solve(rows, [(R * normal.conjugate()).real + NOSE, NOSE]) @ (1, 1j)

    def miss(psi: float) -> float:
        return abs(POST[0] - ARM * cos(psi) + 1j * (POST[1] - ARM * sin(psi))) - abs(centre)

    psi = brentq(miss, 0.0, 0.4, xtol=1e-15)
    at = POST[0] - ARM * cos(psi) + 1j * (POST[1] - ARM * sin(psi))
    return float(np.angle(at / centre)), psi


@both_backends
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("n", [12, 7])
def test_a_load_is_stopped_by_the_next_face(n: int, side: int, backend: str) -> None:
    """It stands where the nose lies in a corner, which repeats with the teeth."""
    phi, psi = rest(n)
    pitch = 2 * pi / n
    for start in (0.3, 20.0):
        begin = FREE_START.format(start * side, 0)
        r = run(winch(LOADED.format(-0.1 * side), n, side, begin), 1, backend)
        end = side * r["shaft.phi"][-1]
        turned = (end - phi - (pi if side < 0 else 0)) / pitch  # its first tip lies opposite
        assert turned == pytest.approx(round(turned), abs=1e-7)
        assert start - 1.2 * pitch < end < start
        assert side * r["hinge.phi"][-1] == pytest.approx(psi, abs=1e-8)
        away = distance(r["shaft.phi"], r["hinge.phi"], n, side)
        assert away.min() > NOSE - 1e-8


@both_backends
def test_back_and_face_bear_pawl_and_load(backend: str) -> None:
    """Two forces of one nose: the moments about both axes give them."""
    r = run(winch(LOADED.format(-0.1), start=FREE_START.format(0.3, 0)), 1, backend)
    phi, psi = float(r["shaft.phi"][-1]), float(r["hinge.phi"][-1])
    at = POST[0] - ARM * cos(psi) + 1j * (POST[1] - ARM * sin(psi))
    lever = at - complex(*POST)
    pitch = 2 * pi / 12
    tooth = np.floor((np.angle(at) - phi) / pitch) * pitch + phi
    foot = (R - DEPTH) * np.exp(1j * (tooth + pitch))
    back = (foot - R * np.exp(1j * tooth)) / abs(foot - R * np.exp(1j * tooth)) / 1j
    face = -1j * np.exp(1j * (tooth + pitch))

    def moments(force: complex) -> list[float]:
        return [(lever.conjugate() * force).imag, -(np.conj(at) * force).imag]

    bears = np.linalg.solve(
        np.array([moments(back), moments(face)]).T,
        [-0.05 * G * ARM / 2 * cos(psi), 0.1],
    )
    pushes = bears @ np.array([back, face])
    assert r["ratchet.f[1]"][-1] == pytest.approx(pushes.real, rel=1e-6)
    assert r["ratchet.f[2]"][-1] == pytest.approx(pushes.imag, rel=1e-6)
    found = sorted(float(np.ravel(r[f"ratchet.{name}.f_n"])[-1]) for name in ("odd", "even"))
    np.testing.assert_allclose(found, sorted(bears), rtol=1e-6)
    assert min(bears) > 0


@both_backends
@pytest.mark.parametrize(("n", "side"), [(12, 1), (9, -1)])
def test_the_pawl_falls_in_behind_every_tip(n: int, side: int, backend: str) -> None:
    """It follows all edges, never enters the wheel, and does the same with every tooth."""
    r = run(winch(TURNING.format(3 * side), n, side), 4, backend)
    away = distance(r["shaft.phi"], r["hinge.phi"], n, side)
    assert away.min() > NOSE - 1e-8
    held = np.hypot(r["ratchet.f[1]"], r["ratchet.f[2]"]) > 1e-6
    np.testing.assert_allclose(away[held], NOSE, atol=1e-7)
    assert 0.3 < held.mean() < 0.99
    falls = [e.time for e in r.events if any("impact" in c for c in e.causes)][2:]
    period = 2 * pi / n / 3
    # Pawls that leap land once a tooth; the time between is that of a tooth.
    landings = np.diff(falls)
    landings = landings[landings > period / 2]
    np.testing.assert_allclose(landings, period, atol=1e-6)
    assert len(landings) >= int(4 / period) - 3


@both_backends
def test_a_pawl_that_slides_takes_no_energy(backend: str) -> None:
    """From landing to tip: what the wheel loses lifts the pawl."""
    r = run(winch(LOADED.format(0), start=FREE_START.format(0, 3.0)), 2, backend)
    psi = r["hinge.phi"]
    energy = 2.5e-3 * r["shaft.w"] ** 2 - 0.05 * G * ARM / 2 * np.sin(psi)
    energy = energy + (2e-5 + 0.05 * (ARM / 2) ** 2) / 2 * r["hinge.w"] ** 2
    impacts = [e.time for e in r.events if any("impact" in c for c in e.causes)]
    assert len(impacts) > 2
    for begin, end in zip(impacts, [*impacts[1:], 2.0], strict=True):
        rows = (r["time"] > begin + 1e-9) & (r["time"] < end - 1e-9)
        np.testing.assert_allclose(energy[rows], energy[rows][0], atol=1e-8)
    assert (np.diff(energy) < 1e-8).all()
    assert energy[-1] < energy[0]


@both_backends
def test_teeth_that_yield_hold_the_load_too(backend: str) -> None:
    law = ", law=Types.ContactLaw.Compliant, c=1e7, e=0.3"
    r = run(winch(LOADED.format(-0.1), start=FREE_START.format(0.3, 0), law=law), 1, backend)
    phi, _ = rest(12)
    turned = (r["shaft.phi"][-1] - phi) / (2 * pi / 12)
    assert turned == pytest.approx(round(turned), abs=5e-3)
    assert abs(r["shaft.w"][-1]) < 1e-2


def test_events_are_told_in_words_of_the_ratchet() -> None:
    run = planarc.load("examples/ratchet_and_pawl.pmo").simulate()
    told = {c for e in run.events for c in e.causes}
    for kind in ("even", "odd"):
        assert {f"`ratchet` {verb} an {kind} tooth" for verb in ("passes", "goes past")} <= told
    assert not any("integer" in cause for cause in told)
