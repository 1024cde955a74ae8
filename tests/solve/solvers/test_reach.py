"""A loop is followed however coarse the rows are: no step may close it in another way."""

from __future__ import annotations

import numpy as np
import pytest

import planarc

PUMP = """
model Pump "A pump whose shaft turns at a given speed"
  import PlanarMultiBody.{Joints, Parts};
  inner PlanarMultiBody.World world;
  Joints.Revolute main(drivenFlange=true);
  Modelica.Mechanics.Rotational.Sources.ConstantSpeed motor(w_fixed=6);
  Parts.FixedTranslation crank(r={0.1, 0}), rod(r={0.4, 0});
  Joints.Revolute bigEnd, smallEnd;
  Parts.Body piston(m=0.6, I=0);
  Joints.Prismatic cylinder(n={1, 0}, s(start=0.5));
equation
  connect(motor.flange, main.axis);
  connect(world.frame_b, main.frame_a);
  connect(main.frame_b, crank.frame_a);
  connect(crank.frame_b, bigEnd.frame_a);
  connect(bigEnd.frame_b, rod.frame_a);
  connect(rod.frame_b, smallEnd.frame_a);
  connect(smallEnd.frame_b, piston.frame_a);
  connect(piston.frame_a, cylinder.frame_b);
  connect(world.frame_b, cylinder.frame_a);
end Pump;
"""


@pytest.fixture(scope="module")
def pump() -> planarc.Model:
    return planarc.load(PUMP)


@pytest.mark.parametrize("interval", [1, 3])
@pytest.mark.parametrize(
    ("backend", "solver"),
    [
        ("native", "cvode-bdf"),
        ("native", "lsoda"),
        ("numpy", "cvode-adams"),
        ("numpy", "scipy-bdf"),
    ],
)
def test_a_driven_loop_keeps_its_assembly(
    pump: planarc.Model, backend: str, solver: str, interval: float
) -> None:
    result = pump.simulate(30, interval=interval, solver=solver, backend=backend)
    assert result.ended is None
    phi, s = result["main.phi"], result["cylinder.s"]
    assert s == pytest.approx(0.1 * np.cos(phi) + np.sqrt(0.16 - (0.1 * np.sin(phi)) ** 2))


def test_only_loops_shorten_steps() -> None:
    """An arm that turns by itself takes steps of any length: nothing is solved for its angle."""
    text = """
    model Rotor
      inner PlanarMultiBody.World world(g=0);
      PlanarMultiBody.Joints.Revolute axis(phi(fixed=true), w(start=1000, fixed=true));
      PlanarMultiBody.Parts.Body rotor(m=1, I=1);
    equation
      connect(world.frame_b, axis.frame_a);
      connect(axis.frame_b, rotor.frame_a);
    end Rotor;"""
    turned = planarc.load(text).simulate(1, intervals=2)
    assert turned.statistics.steps < 100 < turned["axis.phi"][-1]
