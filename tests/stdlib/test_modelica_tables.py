"""Tables: through their points, smooth between them, monotone where promised; and mathematics."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator

from planarc.core.diagnostic import PlanarcError

HEAD = """
  import Modelica.Blocks.{Sources, Tables};
  import Modelica.Blocks.Types.{Extrapolation, Smoothness};
"""
X = np.array([0.0, 0.1, 0.3, 0.45, 0.5, 0.8, 1.0])
Y = np.array([0.0, 0.2, 1.0, 1.1, 1.15, 2.0, 2.0])
TABLE = "[" + "; ".join(f"{x}, {y}" for x, y in zip(X, Y, strict=True)) + "]"


@pytest.fixture
def table(run: Callable[..., Any]) -> Callable[..., Any]:
    return lambda body, **options: run(HEAD + body, **options)


def values(result: Any, name: str) -> tuple[Any, Any]:
    """Times and values after events."""
    rows = np.append(np.diff(result.time) > 0, True)
    return result.time[rows], result[name][rows]


@pytest.mark.usual
@pytest.mark.parametrize(
    ("smoothness", "law"),
    [
        ("LinearSegments", lambda t: np.interp(t, X, Y)),
        ("ConstantSegments", lambda t: Y[np.searchsorted(X, t + 1e-12) - 1]),
        ("ContinuousDerivative", lambda t: Akima1DInterpolator(X, Y)(t)),
        ("ModifiedContinuousDerivative", lambda t: Akima1DInterpolator(X, Y, method="makima")(t)),
    ],
)
def test_both_kinds_of_table_follow_the_law(
    table: Callable[..., Any], smoothness: str, law: Callable[[Any], Any]
) -> None:
    kind = f"table={TABLE}, smoothness=Smoothness.{smoothness}"
    result = table(
        f"  Tables.CombiTable1Ds static({kind}, u=time);\n  Sources.CombiTimeTable timed({kind});"
    )
    for name in ("static.y[1]", "timed.y[1]"):
        t, y = values(result, name)
        np.testing.assert_allclose(y, law(t), atol=1e-9)


@pytest.mark.parametrize("which", [1, 2])
def test_monotone_tables_do_not_overshoot(table: Callable[..., Any], which: int) -> None:
    smoothness = f"Smoothness.MonotoneContinuousDerivative{which}"
    result = table(f"  Tables.CombiTable1Ds t(table={TABLE}, smoothness={smoothness}, u=time);")
    y = result["t.y[1]"]
    assert np.all(np.diff(y) >= -1e-12)
    assert (y[0], y[-1]) == pytest.approx((0, 2))
    np.testing.assert_allclose(y[np.rint(X * 100).astype(int)], Y, atol=1e-12)


@pytest.mark.usual
@pytest.mark.parametrize(
    ("extrapolation", "before", "after"),
    [("HoldLastPoint", 0, 2), ("LastTwoPoints", -1, 2), ("Periodic", 2, 0)],
)
def test_beyond_the_ends(
    table: Callable[..., Any], extrapolation: str, before: float, after: float
) -> None:
    # At -0.5 and at 1.0 + 0.0: two periods of the table fit between -0.5 and 1.5.
    kind = f"table=[0, 0; 0.25, 0.5; 0.5, 2; 1, 2], extrapolation=Extrapolation.{extrapolation}"
    result = table(
        f"""
  Tables.CombiTable1Ds first({kind}, u=-0.5);
  Tables.CombiTable1Ds last({kind}, u=2);
  Sources.CombiTimeTable timed({kind}, shiftTime=0.5);
""",
        stop=2.5,
    )
    assert result["first.y[1]"][0] == pytest.approx(before)
    assert result["last.y[1]"][0] == pytest.approx(after)
    _, y = values(result, "timed.y[1]")
    assert y[0] == pytest.approx(before)
    assert y[-1] == pytest.approx(after)


@pytest.mark.parametrize(
    ("extrapolation", "before", "after"),
    [("HoldLastPoint", 0, 3), ("LastTwoPoints", -1, 7), ("Periodic", 2, 1)],
)
def test_steps_go_on_beyond_the_ends_as_the_line_through_the_last_two_points(
    table: Callable[..., Any], extrapolation: str, before: float, after: float
) -> None:
    kind = "table=[0, 0; 0.5, 1; 1, 2; 1.5, 3], smoothness=Smoothness.ConstantSegments"
    kind += f", extrapolation=Extrapolation.{extrapolation}"
    result = table(
        f"""
  Tables.CombiTable1Ds first({kind}, u=-0.5);
  Tables.CombiTable1Ds last({kind}, u=3.5);
  Sources.CombiTimeTable timed({kind}, shiftTime=0.5);
""",
        stop=4,
    )
    assert result["first.y[1]"][0] == pytest.approx(before)
    assert result["last.y[1]"][0] == pytest.approx(after)
    _, y = values(result, "timed.y[1]")
    assert (y[0], y[-1]) == pytest.approx((before, after))


@pytest.mark.parametrize("extrapolation", ["HoldLastPoint", "LastTwoPoints", "Periodic"])
def test_a_table_of_one_row_is_a_constant(table: Callable[..., Any], extrapolation: str) -> None:
    kind = f"table=[0.5, 7], extrapolation=Extrapolation.{extrapolation}"
    result = table(
        f"  Tables.CombiTable1Ds static({kind}, u=time);\n  Sources.CombiTimeTable timed({kind});"
    )
    for name in ("static.y[1]", "timed.y[1]"):
        assert result[name] == pytest.approx(np.full(len(result.time), 7.0))


def test_columns_offsets_and_scales(table: Callable[..., Any]) -> None:
    result = table(
        """
  Tables.CombiTable1Dv two(table=[0, 0, 5; 1, 2, 4], u={time, 0.5});
  Tables.CombiTable1Ds one(table=[0, 0, 5; 1, 2, 4], columns={3}, u=0.5);
  Sources.CombiTimeTable timed(
    table=[0, 0, 5; 1, 2, 4], timeScale=2, offset={10, 20}, startTime=0.5, shiftTime=0);
"""
    )
    t, y = values(result, "two.y[1]")
    np.testing.assert_allclose(y, 2 * t, atol=1e-12)
    assert result["two.y[2]"][-1] == 4.5
    assert result["one.y[1]"][-1] == 4.5
    t, y = values(result, "timed.y[2]")
    np.testing.assert_allclose(y, np.where(t < 0.5, 20, 25 - t / 2), atol=1e-9)


def test_a_jump_is_met_exactly(table: Callable[..., Any]) -> None:
    result = table(
        """
  Sources.CombiTimeTable force(table=[0, 1; 0.35, 1; 0.35, 4; 1, 4]);
  Real v(start=0, fixed=true);
equation
  der(v) = force.y[1];
"""
    )
    exact = np.where(result.time < 0.35, result.time, 0.35 + 4 * (result.time - 0.35))
    np.testing.assert_allclose(result["v"], exact, atol=1e-9)


def test_jumps_at_the_ends_of_a_table(table: Callable[..., Any]) -> None:
    """At equal times the last row counts; beyond a jump at the end its value is held."""
    result = table(
        """
  Sources.CombiTimeTable load(table=[0, 7; 0, 0; 0.2, 10; 0.2, 3; 0.2, 10; 0.4, 10; 0.4, 2]);
  Sources.CombiTimeTable saw(
    table=[0, 7; 0, 0; 0.25, 1; 0.25, 5], extrapolation=Extrapolation.Periodic);
  Real work(start=0, fixed=true);
  Real area(start=0, fixed=true);
equation
  der(work) = load.y[1];
  der(area) = saw.y[1];
"""
    )
    t = result.time
    worked = [0, 1, 3, 4.2]
    knots = np.interp(t, [0, 0.2, 0.4, 1], worked)
    exact = np.where(t < 0.2, 25 * t**2, knots)
    np.testing.assert_allclose(result["work"], exact, atol=1e-8)
    assert result["load.y[1]"][0] == 0
    assert result["load.y[1]"][-1] == 2
    np.testing.assert_allclose(
        result["area"], np.floor(t / 0.25 + 1e-9) / 8 + 2 * (t % 0.25) ** 2, atol=5e-7
    )


def test_a_smooth_table_drives_a_shaft(table: Callable[..., Any]) -> None:
    result = table(
        f"""
  Tables.CombiTable1Ds cam(
    table={TABLE}, smoothness=Smoothness.ContinuousDerivative, u=0.1 + 0.8*time);
  Modelica.Mechanics.Rotational.Sources.Position drive(exact=true);
  Modelica.Mechanics.Rotational.Components.Inertia wheel(J=1);
equation
  connect(cam.y[1], drive.phi_ref);
  connect(drive.flange, wheel.flange_a);
"""
    )
    law = Akima1DInterpolator(X, Y)
    u = 0.1 + 0.8 * result.time
    inside = np.min(np.abs(u[:, None] - X), axis=1) > 1e-6
    np.testing.assert_allclose(result["wheel.w"], 0.8 * law(u, 1), atol=1e-8)
    np.testing.assert_allclose(result["wheel.a"][inside], (0.8**2 * law(u, 2))[inside], atol=1e-6)


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("Tables.CombiTable1Ds t(table=[0, 1; 2, 3; 1, 4], u=0)", "sort the rows"),
        (
            "Sources.CombiTimeTable t(table=[0, 1; 1, 2; 1, 3; 2, 4],"
            " smoothness=Smoothness.ContinuousDerivative)",
            "sort the rows",
        ),
    ],
)
def test_bad_tables_are_refused(table: Callable[..., Any], block: str, message: str) -> None:
    assert message in table(f"  {block};").ended.message


def test_a_table_stands_in_the_model_or_in_a_file(
    table: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "t.csv"
    file.write_text("0,1\n2,3\n", "utf-8")
    for block in ("Sources.CombiTimeTable", "Tables.CombiTable1Ds", "Tables.CombiTable1Dv"):
        given = "" if block.startswith("Sources") else ", u=time"
        given = ", u={time}" if block.endswith("v") else given
        with pytest.raises(PlanarcError, match="no file is named: give `fileName`"):
            table(f"  {block} t(tableOnFile=true{given});")
        on_file = f'tableOnFile=true, fileName="{file.as_posix()}"'
        both = table(f"  {block} t(table=[0, 1; 2, 4], {on_file}{given});")
        assert "there is a table beside the one in the file" in both.ended.message


def test_functions_of_vectors(run: Callable[..., Any]) -> None:
    result = run(
        """
  import Modelica.Math.Vectors;
  Real norm2 = Vectors.norm({3, 4*cos(0*time)});
  Real norm1 = Vectors.norm({3, -4}, 1);
  Real norm3 = Vectors.norm({1, 2, 2}, 3);
  Real largest = Vectors.norm({3, -4}, Modelica.Constants.inf);
  Real e[2] = Vectors.normalize({3, 4});
  Real back[3] = Vectors.reverse({1, 2, 3});
  Integer place = Vectors.find(3, {1, 3, 3});
  Real between = Vectors.interpolate({0, 1, 3}, {0, 10, 10}, 2*time);
  Boolean same = Vectors.isEqual({1, 2}, {1, 2.1}, 0.2);
  Real angle = Modelica.Math.atan3(0, -1, 10);
  Real area = Modelica.Math.asinh(-2) + Modelica.Math.acosh(2);
  Real sine = Modelica.Math.sin(time) + Modelica.Math.atan2(1, -1);
""",
    )
    expected = {
        "norm2": 5, "norm1": 7, "norm3": 17 ** (1 / 3), "largest": 4, "e[1]": 0.6, "e[2]": 0.8,
        "back[1]": 3, "place": 2, "between": 10, "same": 1, "angle": 3 * np.pi,
        "area": np.arcsinh(-2) + np.arccosh(2), "sine": np.sin(1) + np.arctan2(1, -1),
    }  # fmt: skip
    for name, value in expected.items():
        assert result[name][-1] == pytest.approx(value), name
    np.testing.assert_allclose(
        result["between"], np.interp(2 * result.time, [0, 1, 3], [0, 10, 10]), atol=1e-12
    )


def test_conversions_and_their_inverses(run: Callable[..., Any]) -> None:
    expected = {"deg": 180 / np.pi, "rpm": 30 / np.pi, "kmh": 3.6, "degC": 1 - 273.15,
                "day": 1 / 86400, "hour": 1 / 3600, "minute": 1 / 60, "bar": 1e-5,
                "kWh": 1 / 3.6e6}  # fmt: skip
    lines = []
    for unit in expected:
        lines.append(f"  Real to_{unit} = Modelica.Units.Conversions.to_{unit}(1);")
        lines.append(f"  Real back_{unit} = Modelica.Units.Conversions.from_{unit}(to_{unit});")
    result = run("\n".join(lines))
    for unit, value in expected.items():
        assert result[f"to_{unit}"][0] == pytest.approx(value), unit
        assert result[f"back_{unit}"][0] == pytest.approx(1), unit


def test_tables_are_read_from_files(table: Callable[..., Any], tmp_path: Path) -> None:
    """Columns by number; the second one where none is asked for."""
    file = tmp_path / "tables.txt"
    file.write_text("#1\ndouble curve(3,3)\n0 0 5\n1 2 6\n2 4 9\n", "utf-8")
    where = f'tableOnFile=true, fileName="{file.as_posix()}", tableName="curve"'
    text = f"""
  Tables.CombiTable1Ds one({where}, u=time);
  Tables.CombiTable1Dv two({where}, columns={{3, 2}}, u={{time, 2*time}});
  Sources.CombiTimeTable timed({where}, columns={{3}});
"""
    result = table(text, stop=2)
    assert result["one.y[1]"] == pytest.approx(2 * result.time)
    assert result["two.y[2]"] == pytest.approx(4 * result.time)
    for name in ("two.y[1]", "timed.y[1]"):
        assert result[name] == pytest.approx(np.interp(result.time, [0, 1, 2], [5, 6, 9]))
    file.write_text("#1\ndouble curve(3,3)\n0 1 5\n1 3 6\n2 5 9\n", "utf-8")
    assert table(text, stop=2)["one.y[1]"] == pytest.approx(1 + 2 * result.time)
