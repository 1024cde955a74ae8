"""The part of the Modelica library: values, units, older names."""

from __future__ import annotations

import math
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.catalog.survey import survey
from planarc.core.resources import stdlib
from planarc.request.request import Request

#: Protected variables of the friction here, which that of the Modelica Standard Library lacks.
OWN = ("way", "side", "starts", "barred", "v_slip", "a_slip", "v_jump", "f_slide", "f_hold")


def test_planar_mechanisms_need_no_names_that_the_standard_library_lacks(tmp_path: Path) -> None:
    """Users load that library, and then it stands in the place of the part that is here."""
    shutil.copytree(stdlib() / "Modelica", tmp_path / "Modelica")
    for file in (tmp_path / "Modelica" / "Mechanics").rglob("*.pmo"):
        text = file.read_text(encoding="utf-8")
        renamed = re.sub(rf"\b({'|'.join(OWN)})\b", r"\1_elsewhere", text)
        file.write_text(renamed, encoding="utf-8")
    found = survey(Request(class_name="PlanarMultiBody", libraries=(tmp_path,)))
    assert found.total.good > 100
    assert [cause.names for cause in found.causes()] == []


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


def test_units_of_what_drives_need_agree() -> None:
    """Of formulas whose both sides are types of the library; a wrong unit would be warned of."""
    model = planarc.load("""model Units
  Modelica.Units.SI.ElectricCharge q = 3;
  Modelica.Units.SI.Voltage u = q/C;
  parameter Modelica.Units.SI.Capacitance C = 2;
  Modelica.Units.SI.Current i = u*G;
  parameter Modelica.Units.SI.Conductance G = 5;
  Modelica.Units.SI.Torque tau = k*i;
  parameter Modelica.Units.SI.ElectricalTorqueConstant k = 7;
  Modelica.Units.SI.Torque bending = E*J*L_inverse;
  parameter Modelica.Units.SI.ModulusOfElasticity E = 11;
  parameter Modelica.Units.SI.SecondMomentOfArea J = 13;
  parameter Real L_inverse(unit="m-1") = 17;
  Modelica.Units.SI.Force thrust = q_m*v;
  parameter Modelica.Units.SI.MassFlowRate q_m = 19;
  Modelica.Units.SI.Velocity v = volume/A;
  parameter Modelica.Units.SI.VolumeFlowRate volume = 23;
  parameter Modelica.Units.SI.Area A = 29;
  Modelica.Units.SI.HeatFlowRate loss = K*dT;
  parameter Modelica.Units.SI.ThermalConductance K = 31;
  Modelica.Units.SI.TemperatureDifference dT = loss*R + 37;
  parameter Modelica.Units.SI.ThermalResistance R = 1/41;
end Units;
""")
    assert not model.warnings
    result = model.simulate(1)
    assert result["tau"][0] == pytest.approx(7 * 5 * 1.5)
    assert result["bending"][0] == pytest.approx(11 * 13 * 17)
    assert result["thrust"][0] == pytest.approx(19 * 23 / 29)


def test_a_model_may_carry_an_icon(run: Callable[..., Any]) -> None:
    result = run("  extends Modelica.Icons.Example;\n  Real x = time;")
    assert result["x"][-1] == 1.0
