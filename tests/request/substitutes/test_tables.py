"""A library whose tables are written in C works with planarc's own in their place."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.core.resources import stdlib
from planarc.request.request import Request
from planarc.request.substitutes import substitute

TABLE_TYPES = """\
within Modelica.Blocks;
package Types
  type Smoothness = enumeration(LinearSegments, ContinuousDerivative, ConstantSegments,
    MonotoneContinuousDerivative1, MonotoneContinuousDerivative2, ModifiedContinuousDerivative);
  type Extrapolation = enumeration(HoldLastPoint, LastTwoPoints, Periodic, NoExtrapolation);
  type TimeEvents = enumeration(Always, AtDiscontinuities, NoTimeEvents);
  class ExternalCombiTable1D
    extends ExternalObject;
    function constructor
      input Real table[:, :];
      output ExternalCombiTable1D tableID;
    external "C" tableID = init(table);
    end constructor;
  end ExternalCombiTable1D;
end Types;
"""
TABLES = """\
within Modelica.Blocks;
package Tables
  package Internal
    function getTable1DValue
      input Modelica.Blocks.Types.ExternalCombiTable1D tableID;
      input Integer icol;
      input Real u;
      output Real y;
    external "C" y = ModelicaStandardTables_CombiTable1D_getValue(tableID, icol, u);
    end getTable1DValue;
  end Internal;
end Tables;
"""
MODEL = """\
model M
  import Modelica.Blocks.Types.*;
  parameter ExternalCombiTable1D table = ExternalCombiTable1D(
    table={rows}, columns={{3, 2}}, smoothness=Smoothness.{smoothness}{more});
  Real y = Modelica.Blocks.Tables.Internal.getTable1DValue(table, 2, time - 1);
  Real low = Modelica.Blocks.Tables.Internal.getTable1DAbscissaUmin(table);
  Real high = Modelica.Blocks.Tables.Internal.getTable1DAbscissaUmax(table);
end M;
"""
PLANE = """\
model M
  import Modelica.Blocks.Types.*;
  parameter ExternalCombiTable2D table = ExternalCombiTable2D(
    table={{0, 1, 3; 0, 10, 30; 2, 12, 32}}, smoothness=Smoothness.{smoothness});
  Real z = Modelica.Blocks.Tables.Internal.getTable2DValue(table, time, 1 + 2*time);
  Real low[2] = Modelica.Blocks.Tables.Internal.getTable2DAbscissaUmin(table);
  Real high[2] = Modelica.Blocks.Tables.Internal.getTable2DAbscissaUmax(table);
end M;
""".replace("{{", "[").replace("}}", "]")


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """The embedded library as a user's, with tables in C."""
    blocks = tmp_path / "Modelica" / "Blocks"
    shutil.copytree(stdlib() / "Modelica", blocks.parent)
    shutil.rmtree(blocks / "Tables")
    shutil.rmtree(blocks / "Types")
    (blocks / "Tables.mo").write_text(TABLES, "utf-8")
    (blocks / "Types.mo").write_text(TABLE_TYPES, "utf-8")
    return tmp_path


def run(text: str, library: Path) -> compiler.Result:
    request = Request(text=text, libraries=(library,))
    compiled = compiler.compile_model(request, Backend.NUMPY)
    return compiler.run(compiled, RunOptions(stop=4, intervals=40, backend=Backend.NUMPY))


def test_a_table_is_interpolated_and_extrapolated(library: Path) -> None:
    text = MODEL.format(rows="[0, 1, 5; 1, 3, 6; 2, 4, 7]", smoothness="LinearSegments", more="")
    result = run(text, library)
    u = result.time - 1
    expected = np.interp(u, [-1, 0, 1, 2, 3], [-1, 1, 3, 4, 5])
    assert result["y"] == pytest.approx(expected)
    assert (result["low"][0], result["high"][0]) == (0, 2)


def test_a_smooth_table_meets_its_points_and_a_parabola(library: Path) -> None:
    rows = "[" + "; ".join(f"{x}, {x * x}, 0" for x in range(-2, 6)) + "]"
    result = run(MODEL.format(rows=rows, smoothness="ContinuousDerivative", more=""), library)
    u = result.time - 1
    whole = np.isclose(u, np.round(u))
    assert result["y"][whole] == pytest.approx(u[whole] ** 2)
    assert result["y"] == pytest.approx(u**2, abs=0.15)


def test_a_table_with_two_inputs_is_bilinear(library: Path) -> None:
    result = run(PLANE.replace("{smoothness}", "LinearSegments"), library)
    u1, u2 = result.time, 1 + 2 * result.time
    assert result["z"] == pytest.approx(10 * u2 + u1)
    assert (result["low[1]"][0], result["low[2]"][0]) == (0, 1)
    assert (result["high[1]"][0], result["high[2]"][0]) == (2, 3)


def test_steps_of_a_table_with_two_inputs_go_on_as_planes(library: Path) -> None:
    result = run(PLANE.replace("{smoothness}", "ConstantSegments"), library)
    u1, u2 = result.time, 1 + 2 * result.time
    beyond = (u1 > 2) | (u2 > 3)
    assert result["z"] == pytest.approx(np.where(beyond, 10 * u2 + u1, np.where(u2 < 3, 10, 30)))


def test_a_smooth_table_with_two_inputs_is_refused(library: Path) -> None:
    result = run(PLANE.replace("{smoothness}", "ContinuousDerivative"), library)
    assert "only interpolated linearly or by steps" in str(result.ended)


def test_a_table_over_time_finds_all_functions_that_it_calls(library: Path) -> None:
    table = "Modelica.Blocks.Sources.CombiTimeTable t(table=[0, 1; 4, 9]);"
    result = run(f"model M\n  {table}\nend M;", library)
    assert result["t.y[1]"] == pytest.approx(1 + 2 * result.time)


def test_a_table_in_a_file_is_read(library: Path, tmp_path: Path) -> None:
    (tmp_path / "table.txt").write_text("#1\ndouble t(2, 3)\n0 1 5\n1 3 6\n", "utf-8")
    more = f', fileName="{(tmp_path / "table.txt").as_posix()}", tableName="t"'
    text = MODEL.format(rows="[0.0]", smoothness="LinearSegments", more=more)
    result = run(text, library)
    assert result["y"] == pytest.approx(1 + 2 * (result.time - 1))
    assert (result["low"][0], result["high"][0]) == (0, 1)


def test_a_plane_in_a_file_is_read(library: Path, tmp_path: Path) -> None:
    (tmp_path / "plane.csv").write_text("u\n0;1;3\n0;10;30\n2;12;32\n", "utf-8")
    where = f'fileName="{(tmp_path / "plane.csv").as_posix()}", delimiter=";", nHeaderLines=1'
    text = PLANE.replace("table=[0, 1, 3; 0, 10, 30; 2, 12, 32]", f"table=[0.0], {where}")
    result = run(text.replace("{smoothness}", "LinearSegments"), library)
    assert result["z"] == pytest.approx(10 * (1 + 2 * result.time) + result.time)


def test_a_table_that_a_function_in_c_gives_is_refused(library: Path) -> None:
    text = MODEL.format(rows="[0.0]", smoothness="LinearSegments", more=', tableName="own"')
    with pytest.raises(PlanarcError, match="no file is named: give `fileName`"):
        run(text, library)


def test_other_files_stay_as_they_are() -> None:
    from planarc.core.source import Source
    from planarc.parse.parser import parse_file, parse_text

    stored = parse_text(Source("Types.mo", TABLE_TYPES.replace("Modelica.Blocks", "My.Blocks")))
    assert substitute(stored, parse_file) is stored
    stored = parse_text(Source("Math.mo", "within Modelica; package Math end Math;"))
    assert substitute(stored, parse_file) is stored
    stored = parse_text(Source("M.mo", "model M end M;"))
    assert substitute(stored, parse_file) is stored
