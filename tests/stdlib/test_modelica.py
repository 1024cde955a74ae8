"""The part of the Modelica library: values, units, older names."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import pytest


def test_constants_have_their_values(run: Callable[..., Any]) -> None:
    expected = {
        "pi": math.pi,
        "e": math.e,
        "D2R": math.radians(1),
        "R2D": math.degrees(1),
        "eps": sys.float_info.epsilon,
        "small": sys.float_info.min,
        "inf": sys.float_info.max,
        "g_n": 9.80665,
    }
    lines = [f"  Real v_{name} = Modelica.Constants.{name};" for name in expected]
    result = run("\n".join(lines))
    for name, value in expected.items():
        assert result[f"v_{name}"][0] == pytest.approx(value, rel=1e-15), name


@pytest.mark.parametrize("package", ["Modelica.Units.SI", "Modelica.SIunits"])
def test_both_names_of_the_units_give_the_same_types(run: Callable[..., Any], package: str) -> None:
    result = run(f"  {package}.Angle a = time;\n  {package}.MomentOfInertia J = 2;")
    assert (result.columns["a"].unit, result.columns["a"].display_unit) == ("rad", "deg")
    assert result.columns["J"].unit == "kg.m2"


def test_a_model_may_carry_an_icon(run: Callable[..., Any]) -> None:
    result = run("  extends Modelica.Icons.Example;\n  Real x = time;")
    assert result["x"][-1] == 1.0
