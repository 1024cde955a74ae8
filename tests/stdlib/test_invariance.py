"""Turned or mirrored as a whole, gravity included, a mechanism moves as it did before.

A loop of bars, a loop of rods without angles and a cam are each built anew: with every vector and
start angle turned or mirrored. Joint coordinates stay (or change their sign), contact and rod
forces stay, and reactions turn with the ground. Curves are closed and symmetric, or lie in a
turned frame, so that the mirrored cam is the same curve walked the other way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

Run = Callable[..., Any]


@dataclass(frozen=True)
class Pose:
    """The mechanism is mirrored at the x-axis where `side` is -1, then turned by `angle`."""

    angle: float = 0.0
    side: int = 1

    def vector(self, x: float, y: float) -> str:
        z = complex(x, self.side * y) * np.exp(1j * self.angle)
        return f"{{{float(z.real)}, {float(z.imag)}}}"

    def local(self, x: float, y: float) -> str:
        """A vector in a body, which is mirrored but not turned."""
        return f"{{{x!r}, {self.side * y!r}}}"

    def start(self, phi: float) -> str:
        return repr(self.side * phi)

    @property
    def world(self) -> str:
        return f"n={self.vector(0, -1)}"

    def fixed(self, name: str, x: float, y: float) -> str:
        return f"Parts.Fixed {name}(r={self.vector(x, y)}, phi={self.angle!r});"


PLAIN = Pose()
POSES = {
    "turned": Pose(0.9),
    "turned far": Pose(-2.6),
    "mirrored": Pose(0.0, -1),
    "mirrored and turned": Pose(2.2, -1),
}


def four_bar(p: Pose) -> str:
    return f"""
  {p.fixed("A", 0, 0)} {p.fixed("D", 1, 0.1)}
  Joints.Revolute revA(phi(start={p.start(1)}, fixed=true), w(start={p.start(2)}, fixed=true));
  Joints.Revolute revB(phi(start={p.start(-0.46)})), revC(phi(start={p.start(1.05)}));
  Joints.Revolute revD(phi(start={p.start(1.59)}));
  Parts.BodyShape crank(r={{0.4, 0}}, m=1, I=0.0134);
  Parts.BodyShape coupler(r={{0.9, 0}}, r_CM={p.local(0.45, 0.1)}, m=2, I=0.14);
  Parts.BodyShape rocker(r={{0.8, 0}}, m=1.5, I=0.08);
equation
  connect(A.frame_b, revA.frame_a);
  connect(revA.frame_b, crank.frame_a);
  connect(crank.frame_b, revB.frame_a);
  connect(revB.frame_b, coupler.frame_a);
  connect(coupler.frame_b, revC.frame_a);
  connect(D.frame_b, revD.frame_a);
  connect(revD.frame_b, rocker.frame_a);
  connect(rocker.frame_b, revC.frame_b);
"""


def rods(p: Pose) -> str:
    return f"""
  {p.fixed("A", 0, 0)} {p.fixed("D", 1, 0.2)}
  Joints.Revolute revA(phi(start={p.start(1)}, fixed=true), w(start={p.start(2)}, fixed=true));
  Joints.Revolute revD(phi(start={p.start(1.4)}));
  Parts.BodyShape crank(r={{0.4, 0}}, r_CM={p.local(0.2, 0.1)}, m=1, I=0.0134);
  Parts.BodyShape rocker(r={{0.8, 0}}, m=1.5, I=0.08);
  Joints.JointRRWithMass rod(L=0.9, m=0.7, lengthFraction=0.3);
equation
  connect(A.frame_b, revA.frame_a);
  connect(revA.frame_b, crank.frame_a);
  connect(crank.frame_b, rod.frame_a);
  connect(D.frame_b, revD.frame_a);
  connect(revD.frame_b, rocker.frame_a);
  connect(rocker.frame_b, rod.frame_b);
"""


def cam(p: Pose) -> str:
    # The follower's face looks down at the cam from above; mirrored, up from below.
    side = "" if p.side > 0 else "switchSide=true, "
    circumference = np.pi * (3 * 0.23 - np.sqrt((0.45 + 0.08) * (0.15 + 0.24)))
    s1 = 0.24 if p.side > 0 else circumference / 2 - 0.24
    return f"""
  {p.fixed("ground", 0, 0)}
  Joints.Revolute hinge(phi(start={p.start(0.8)}, fixed=true), w(fixed=true));
  Parts.Body cam(m=2, I=0.01, r_CM={p.local(0.2, 0.03)});
  Joints.CurveCurveJoint contact(redeclare Curves.Ellipse curve1(a=0.15, b=0.08),
    redeclare Curves.StraightLine curve2({side}s_min=-0.2, s_max=0.2), s1(start={s1}));
  Joints.Prismatic slide(n={p.local(0, 1)}, s(start=0.12));
  Parts.Body follower(m=0.5);
equation
  connect(ground.frame_b, hinge.frame_a);
  connect(hinge.frame_b, cam.frame_a);
  connect(hinge.frame_b, contact.frame_a);
  connect(ground.frame_b, slide.frame_a);
  connect(slide.frame_b, follower.frame_a);
  connect(slide.frame_b, contact.frame_b);
"""


#: The model; what changes its sign in a mirror, what stays; the reaction that turns.
MECHANISMS = {
    "four-bar": (four_bar, ("revA.phi", "revB.phi", "revD.w"), (), "A.frame_b"),
    "rods": (rods, ("revA.phi", "revD.phi"), ("rod.frod",), "D.frame_b"),
    "cam": (cam, ("hinge.phi", "hinge.w"), ("slide.s", "contact.f_N"), "hinge.frame_a"),
}


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("name", MECHANISMS)
def test_a_mechanism_does_not_know_how_it_stands(run: Run, name: str, pose: str) -> None:
    build, odd, even, reaction = MECHANISMS[name]
    p = POSES[pose]
    plain, other = (run(build(q), world=q.world) for q in (PLAIN, p))
    assert plain.ended is None and other.ended is None
    for variable in (*odd, *even):
        expected = plain[variable] * (p.side if variable in odd else 1)
        scale = max(1.0, float(np.max(np.abs(expected))))
        np.testing.assert_allclose(other[variable], expected, atol=2e-6 * scale, err_msg=variable)
    force, moved = (r[f"{reaction}.f[1]"] + 1j * r[f"{reaction}.f[2]"] for r in (plain, other))
    expected = (force if p.side > 0 else force.conj()) * np.exp(1j * p.angle)
    np.testing.assert_allclose(moved, expected, atol=2e-5 * np.max(np.abs(force)))
