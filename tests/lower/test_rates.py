"""Derivatives that annotations give are taken as they are given: `noDerivative`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.options import Backend

MOTION = """
function motion
  input Real q[3];
  input Real t;
  output Real y;
algorithm
  y := q[1];
  annotation(derivative({still}=q) = motion_der);
end motion;
function motion_der
  input Real q[3];
  input Real t;
  input Real t_der;
  output Real y;
algorithm
  y := q[2]*t_der;
  {second}
end motion_der;
function motion_der2
  input Real q[3];
  input Real t;
  input Real t_der;
  input Real t_der2;
  output Real y;
algorithm
  y := q[3]*t_der^2 + q[2]*t_der2;
end motion_der2;
"""
SECOND = "annotation(derivative(noDerivative=q, order=2) = motion_der2);"
MODEL = """
model M
  Real x, v = der(x), a = der(v);
  Real q[3] = {{time^2, 5, 7*time}};
equation
  x = motion(q, 3*time);
end M;
"""


@pytest.fixture(params=[b.value for b in Backend])
def run(request: pytest.FixtureRequest) -> Any:
    def simulate(model: str, still: str = "noDerivative", second: str = SECOND) -> Any:
        text = MOTION.format(still=still, second=second) + model
        return planarc.load(text, "M", backend=request.param).simulate(2)

    return simulate


def test_derivatives_are_those_that_are_given(run: Any) -> None:
    result = run(MODEL.format())
    t = result.time
    assert result["x"] == pytest.approx(t**2)
    assert result["v"] == pytest.approx(np.full(len(t), 15.0))
    assert result["a"] == pytest.approx(9 * 7 * t)


def test_what_no_annotation_gives_is_differentiated(run: Any) -> None:
    result = run(MODEL.format().replace("5, 7*time", "time^3, 0"), second="")
    assert result["v"] == pytest.approx(3 * result.time**3)
    assert result["a"] == pytest.approx(9 * result.time**2)


def test_inputs_said_to_rest_are_differentiated_as_they_are(run: Any) -> None:
    result = run(MODEL.format(), still="zeroDerivative")
    assert result["v"] == pytest.approx(2 * result.time)
    assert result["a"] == pytest.approx(np.full(len(result.time), 2.0))


def test_what_nothing_reads_is_not_differentiated(run: Any) -> None:
    result = run(MODEL.format().replace("time^2", "(if time < 1 then time else 2*time - 1)"))
    assert not [name for name in result.names if name.startswith("der(q")]
    assert not [w for w in result.warnings if w.code == "R438"]


def test_a_value_may_be_found_from_what_it_gives(run: Any) -> None:
    """Its own derivatives are then those of the value: what is given does not hold them."""
    result = run(
        """
model M
  Real x = time^3, u, w = der(u), z = der(w);
equation
  x = motion({u, 5, 7}, time);
end M;
"""
    )
    assert result["u"] == pytest.approx(result.time**3)
    assert result["w"] == pytest.approx(3 * result.time**2)
    assert result["z"] == pytest.approx(6 * result.time)


def test_a_motion_from_a_table_moves_with_its_own_acceleration() -> None:
    """Between the points of a table the angle is a straight line, on which no torque acts."""
    text = """
model M
  Modelica.Mechanics.Rotational.Sources.Move move;
  Modelica.Mechanics.Rotational.Components.Inertia load(J=2);
  parameter Real t[11] = linspace(0, 1, 11);
  Modelica.Blocks.Sources.CombiTimeTable path(
    table=transpose({t, 0.5*t.^2, t, fill(1.0, 11)}), columns=2:4);
equation
  connect(path.y, move.u);
  connect(move.flange, load.flange_a);
end M;
"""
    result = planarc.load(text).simulate(1)
    assert result["load.w"] == pytest.approx(result.time)
    assert result["move.flange.tau"] == pytest.approx(np.full(len(result.time), -2.0))
    assert not result.warnings
