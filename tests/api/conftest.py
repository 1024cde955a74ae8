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


#: A parallelogram: ground and coupler 1 m, cranks 0.5 m; all bars turn together or not at all.
PARALLELOGRAM = """
model Parallelogram
  import PlanarMultiBody.Joints.Revolute;
  import PlanarMultiBody.Parts;
  inner PlanarMultiBody.World world;
  Parts.Fixed ground(r={1, 0});
  Revolute A(phi(start=-1, fixed=true), w(fixed=true));
  Revolute B(phi(start=1));
  Revolute C(phi(start=1));
  Revolute D(phi(start=-1));
  Parts.FixedTranslation crank(r={0.5, 0});
  Parts.FixedTranslation coupler(r={1, 0});
  Parts.FixedTranslation rocker(r={0.5, 0});
  Parts.Body crankBody(m=1, I=0.1, r_CM={0.25, 0});
  Parts.Body couplerBody(m=2, I=0.2, r_CM={0.5, 0});
  Parts.Body rockerBody(m=3, I=0.3, r_CM={0.25, 0});
equation
  connect(world.frame_b, A.frame_a);
  connect(A.frame_b, crank.frame_a);
  connect(A.frame_b, crankBody.frame_a);
  connect(crank.frame_b, B.frame_a);
  connect(B.frame_b, coupler.frame_a);
  connect(B.frame_b, couplerBody.frame_a);
  connect(ground.frame_b, D.frame_a);
  connect(D.frame_b, rocker.frame_a);
  connect(D.frame_b, rockerBody.frame_a);
  connect(coupler.frame_b, C.frame_a);
  connect(C.frame_b, rocker.frame_b);
end Parallelogram;
"""

#: Crank 0.2 m, rod 0.7 m, on a level slide; only centres of mass matter for the closed forms.
SLIDER = """
model Slider
  import PlanarMultiBody.Joints;
  import PlanarMultiBody.Parts;
  inner PlanarMultiBody.World world;
  Joints.Revolute main(phi(start=-1, fixed=true), w(fixed=true));
  Joints.Revolute bigEnd(phi(start=1.2));
  Joints.Revolute smallEnd(phi(start=-0.2));
  Joints.Prismatic slide(n={1, 0}, s(start=0.8));
  Parts.BodyShape crank(r={0.2, 0}, r_CM={0.1, 0}, m=1, I=0.01);
  Parts.BodyShape rod(r={0.7, 0}, r_CM={0.35, 0}, m=2, I=0.05);
  Parts.Body slider(m=3, I=0);
equation
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, crank.frame_a);
  connect(crank.frame_b, bigEnd.frame_a);
  connect(bigEnd.frame_b, rod.frame_a);
  connect(rod.frame_b, smallEnd.frame_a);
  connect(smallEnd.frame_b, slider.frame_a);
  connect(slide.frame_b, slider.frame_a);
  connect(world.frame_b, slide.frame_a);
end Slider;
"""


@pytest.fixture(scope="session")
def parallelogram() -> Model:
    return planarc.load(PARALLELOGRAM)


@pytest.fixture(scope="session")
def slider() -> Model:
    return planarc.load(SLIDER)
