"""A model of one line, so that a study of many points is quick."""

from __future__ import annotations

import pytest

import planarc
from planarc import Model

DECAY = """
model Decay "x = x0*exp(-k*t)"
  parameter Real k = 1;
  parameter Integer n = 2;
  parameter Boolean linear = true annotation(Evaluate=true);
  parameter Real c[2] = {1, 2};
  Real x(start=1, fixed=true);
  Real y = if linear then x else x^2;
equation
  der(x) = -k*x;
  assert(k < 50, "k is too large");
  annotation(experiment(StopTime=1, Tolerance=1e-8));
end Decay;
"""


@pytest.fixture(scope="session")
def decay() -> Model:
    return planarc.load(DECAY)
