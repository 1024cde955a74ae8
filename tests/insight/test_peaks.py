"""Drives and joints of a run: who supplies power, and how much each carries."""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc.insight.study import study
from planarc.ir.insight import DRIVES
from planarc.view.page.figures import LIMIT, choose_figures

MODEL = """
model Driven "A rod that a torque holds up and swings"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(drivenFlange=true, phi(fixed=true), w(start=2, fixed=true));
  PlanarMultiBody.Parts.FixedTranslation rod(r={0.5, 0});
  PlanarMultiBody.Parts.PointMass bob(m=2);
  Modelica.Mechanics.Rotational.Sources.Torque motor;
  Modelica.Blocks.Sources.RealExpression held(y=2*9.81*0.5*cos(hinge.phi));
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  connect(rod.frame_b, bob.frame_a);
  connect(motor.flange, hinge.axis);
  connect(held.y, motor.tau);
  annotation(experiment(StopTime=3, Interval=0.001, Tolerance=1e-9));
end Driven;
"""


@pytest.fixture(scope="module")
def result() -> planarc.Result:
    return planarc.load(MODEL).simulate()


def test_a_drive_has_its_torque_and_its_power(result: planarc.Result) -> None:
    insight = study(result.rows)
    (figure,) = [curves for title, curves, _ in insight.figures if title == DRIVES]
    assert figure == ("motor.tau", "motor power")
    (power,) = [s.values for s in insight.series if s.name == "motor power"]
    np.testing.assert_allclose(power, result["motor.tau"] * result["hinge.w"], atol=1e-9)
    first = choose_figures(result.rows, None, insight)[0]
    assert (first.title, first.on) == (DRIVES, True)


def test_peaks_and_mean_squares_are_those_of_a_turning_mass(result: planarc.Result) -> None:
    """The torque holds the weight, so the rod turns evenly: the hinge bears m*g and m*w^2*r."""
    peaks = {p.name: p for p in study(result.rows).peaks}
    assert peaks["motor.tau"].value == pytest.approx(9.81, rel=1e-6)
    assert peaks["motor.tau"].time == pytest.approx(0, abs=1e-3)
    turned = 6.0
    mean = 0.5 + np.sin(2 * turned) / (4 * turned)  # of cos^2 over the turn
    assert peaks["motor.tau"].rms == pytest.approx(9.81 * np.sqrt(mean), rel=1e-5)
    weight, pull = 2 * 9.81, 2 * 2.0**2 * 0.5
    # Along the rod m*w^2*r + m*g*sin(phi), and across m*g*cos(phi).
    assert peaks["hinge force"].largest == pytest.approx(weight + pull, rel=1e-5)


def test_equal_curves_are_shown_once_and_few_in_a_figure() -> None:
    columns = "\n".join(f"  Real x{i}(start={i}, fixed=true);" for i in range(20))
    laws = "\n".join(f"  der(x{i}) = -x{i};" for i in range(20))
    text = f"model M\n{columns}\n  Real y = x3;\nequation\n{laws}\nend M;"
    figures = choose_figures(planarc.load(text).simulate(stop_time=1).rows)
    (figure,) = [f for f in figures if f.on]
    assert len(figure.curves) == LIMIT
    assert "y" not in figure.curves
