"""A result in Python: arrays, tables, curves, pages."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc import Model, Result, UsageError
from planarc.view.table.files import read_table


@pytest.fixture(scope="module")
def result(four_bar: Model) -> Result:
    return four_bar.simulate(1, intervals=100)


def test_columns_have_units_and_the_length_of_time(result: Result) -> None:
    assert len(result) == len(result.time) == len(result["revA.phi"]) == 101
    assert (result.unit("revA.phi"), result.unit("time")) == ("rad", "s")
    assert result.units["crankBody.m"] == "kg"
    assert "crankBody.m" in result
    assert result.description("revA.w").startswith("Relative")


def test_an_array_has_an_axis_for_each_subscript(result: Result) -> None:
    position = result["couplerBody.r_0CM"]
    assert position.shape == (101, 2)
    assert np.array_equal(position[:, 1], result["couplerBody.r_0CM[2]"])
    assert (result.unit("couplerBody.r_0CM"), result.unit("crank.r")) == ("m", "m")
    assert result.at("couplerBody.r_0CM", [0.0, 1.0]).tolist() == position[[0, -1]].tolist()
    assert result.select(["crank.r", "revA.w"]) == ["crank.r[1]", "crank.r[2]", "revA.w"]
    with pytest.raises(UsageError, match=r"no variable `couplerBody\.r_0`"):
        result["couplerBody.r_0"]


def test_a_result_is_gone_through_by_name(result: Result) -> None:
    assert tuple(result) == result.names
    assert dict.fromkeys(result).keys() >= {"revA.phi", "crankBody.m"}


def test_values_between_the_rows_lie_between(result: Result) -> None:
    between = result.at("revA.phi", [0.0, 0.005, 0.01])
    assert between[1] == pytest.approx((between[0] + between[2]) / 2)


def test_variables_are_selected_by_list_and_pattern(result: Result) -> None:
    assert result.select(r"^rev[AB]\.phi$") == ["revA.phi", "revB.phi"]
    assert "crankBody.m" not in result.select()
    with pytest.raises(UsageError, match="regular expression"):
        result.select("(")
    with pytest.raises(UsageError, match="no variable"):
        result.select(["revA.fi"])


def test_tables_hold_the_same_numbers(result: Result, tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    frame, dataset = result.to_pandas(), result.to_xarray(["revA.phi"])
    assert np.array_equal(frame["revA.phi"], result["revA.phi"])
    assert frame.index.name == "time"
    assert frame.attrs["units"]["revA.phi"] == "rad"
    assert np.array_equal(dataset["revA.phi"], result["revA.phi"])
    assert dataset["revA.phi"].attrs["units"] == "rad"
    for path in (result.to_csv(tmp_path / "a.csv"), result.to_mat(str(tmp_path / "b"))):
        assert np.allclose(read_table(path)["revA.phi"], result["revA.phi"], atol=0)


def test_tables_with_each_time_once_keep_what_is_behind_an_event() -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    run = planarc.load("model M Real x = if time < 0.5 then 1 else 2; end M;").simulate(1)
    assert np.any(np.diff(run.time) == 0)
    dataset, frame = run.to_xarray(once=True), run.to_pandas(once=True)
    assert float(dataset["x"].sel(time=0.5)) == 2
    assert float(dataset["x"].sel(time=0.7004, method="nearest")) == 2
    assert dataset.interp(time=[0.2, 0.8])["x"].values == pytest.approx([1, 2])
    assert frame["x"].reindex([0.5]).tolist() == [2]
    assert len(frame) == len(np.unique(run.time))
    assert len(run.to_pandas()) == len(run.time)


def test_a_table_may_hold_some_variables_and_units(result: Result, tmp_path: Path) -> None:
    some = result.to_csv(tmp_path / "a.csv", ["revA.phi", "revB.phi"], units=True)
    head = some.read_text("utf-8").splitlines()[0]
    assert "rad" in head
    assert set(read_table(some).columns) == {"revA.phi", "revB.phi"}
    assert "revA.w" not in read_table(result.to_mat(tmp_path / "a.mat", r"phi$"))


def test_a_table_that_cannot_be_written_says_so(result: Result, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no folder"):
        result.to_csv(tmp_path / "nowhere" / "a.csv")


def test_curves_are_those_asked_for(result: Result) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    axes = result.plot("revD.phi", x="revA.phi")
    assert np.array_equal(axes.lines[0].get_xdata(), result["revA.phi"])
    assert np.array_equal(axes.lines[0].get_ydata(), result["revD.phi"])
    assert axes.get_xlabel() == "revA.phi [rad]"
    assert len(result.plot().lines) == 4
    listed = result.plot(["revA.phi", "revD.phi"])
    assert len(listed.lines) == 2
    with pytest.raises(UsageError, match="no variable"):
        result.plot("revD.fi")


def test_a_notebook_shows_the_moving_mechanism(result: Result, tmp_path: Path) -> None:
    shown = result._repr_html_()
    assert shown.startswith("<iframe srcdoc=")
    assert "<script" not in shown  # it is inside the frame, escaped
    saved = result.animate(curves=["revD.phi"]).save(tmp_path / "a.html").read_text("utf-8")
    assert "revD.phi" in saved
    assert "FourBar" in result.report(tmp_path / "b.html").read_text("utf-8")
    with pytest.raises(UsageError, match="no variable"):
        result.report(tmp_path / "c.html", ["revD.fi"])


def test_the_page_tells_how_near_dead_points_are(result: Result, tmp_path: Path) -> None:
    page = result.report(tmp_path / "page.html").read_text("utf-8")
    assert "smallest singular value" in page
    assert "smallest singular value" in result.animate().text


def test_a_missing_package_is_named(result: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, call in (
        ("pandas", result.to_pandas),
        ("xarray", result.to_xarray),
        ("matplotlib", result.plot),
    ):
        monkeypatch.setitem(sys.modules, name, None)
        monkeypatch.setitem(sys.modules, f"{name}.pyplot", None)
        with pytest.raises(UsageError) as caught:
            call()
        (found,) = caught.value.diagnostics
        assert f"`{name}`" in found.message
        assert "pip install" in str(found.hint)


def test_what_a_notebook_shows_of_analyses_is_short(four_bar: Model) -> None:
    found = (
        (four_bar.linearize("equilibrium"), "natural [rad/s]"),
        (four_bar.equilibrium(), "revA.phi"),
        (four_bar.parameters, "Mass"),
        (four_bar.variables, "Cut force"),
    )
    for what, words in found:
        assert len(repr(what)) < 300
        assert words in what._repr_html_()
    sensitivities = four_bar.sensitivities(["crankBody.m"], stop_time=0.1)
    assert "by crankBody.m" in repr(sensitivities)
    assert len(repr(sensitivities)) < 200
    assert four_bar.variables._repr_html_().count("<tr>") <= 202
