"""Models that several tests of the Python side use; each is compiled once."""

from __future__ import annotations

from pathlib import Path

import pytest

import planarc
from planarc import Model

ROOT = Path(__file__).parents[2]

PENDULUM = """
model Pendulum "A compound pendulum"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0.5, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.Body bob(m=2, I=0.3, r_CM={0.7, 0});
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bob.frame_a);
end Pendulum;
"""

LAG = """
model Lag "A filter of first order"
  parameter Real T = 2;
  parameter Integer n = 3;
  parameter Real c[2] = {1, 2};
  input Real u;
  output Real x(start=1, fixed=true);
  output Real y;
equation
  T*der(x) = u - x;
  y = c[1]*x + c[2]*u;
end Lag;
"""


@pytest.fixture(scope="session")
def pendulum() -> Model:
    return planarc.load(PENDULUM)


@pytest.fixture(scope="session")
def lag() -> Model:
    return planarc.load(LAG)


@pytest.fixture(scope="session")
def four_bar() -> Model:
    return planarc.load(ROOT / "examples" / "four_bar.pmo")


@pytest.fixture(scope="session")
def crank_slider() -> Model:
    return planarc.load(ROOT / "examples" / "crank_slider.pmo")
