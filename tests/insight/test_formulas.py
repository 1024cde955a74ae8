"""Figures may show expressions of variables."""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc import Result
from planarc.stages import study
from planarc.view.page.figures import choose_figures, shown_names

TEXT = """model Swings
  Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
  parameter Real k = 4;
equation
  der(x) = v;
  der(v) = -k*x;
  annotation(Documentation(figures={Figure(plots={Plot(title="Energy", curves={
    Curve(y=(v^2 + k*x^2)/2), Curve(y=-der(v)*v), Curve(y=atan2(x, 1.0)), Curve(y=x),
    Curve(y=if x > 0 then x else 0), Curve(y=gone + x), Curve(x=x, y=2*v)})})}));
end Swings;
"""


@pytest.fixture(scope="module")
def result() -> Result:
    return planarc.load(TEXT).simulate(3, tolerance=1e-9)


def test_expressions_become_curves(result: Result) -> None:
    found = {s.name: s.values for s in study(result.rows).series}
    assert list(found) == ["(v^2 + k*x^2)/2", "-der(v)*v", "atan2(x, 1.0)"]
    t = result.time
    assert np.max(np.abs(found["(v^2 + k*x^2)/2"] - 2)) < 1e-6
    assert np.max(np.abs(found["-der(v)*v"] + 8 * np.cos(2 * t) * np.sin(2 * t))) < 1e-6
    assert np.max(np.abs(found["atan2(x, 1.0)"] - np.arctan(np.cos(2 * t)))) < 1e-6


def test_the_page_shows_them_with_the_variables_of_their_figure(result: Result) -> None:
    figure = choose_figures(result.rows, insight=study(result.rows))[0]
    assert figure.title == "Energy"
    assert figure.curves == ("(v^2 + k*x^2)/2", "-der(v)*v", "atan2(x, 1.0)", "x")
    assert figure.on
    assert "(v^2 + k*x^2)/2" in result.animate().text


def test_where_only_variables_are_drawn_they_are_left_out(result: Result) -> None:
    assert shown_names(result.rows) == ("x",)
