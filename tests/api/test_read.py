"""Results that are read from files."""

from __future__ import annotations

from pathlib import Path

import pytest

import planarc

FOUR_BAR = Path(__file__).parents[2] / "examples" / "four_bar.pmo"


@pytest.fixture(scope="module")
def run() -> planarc.Result:
    return planarc.load(FOUR_BAR).simulate(1)


@pytest.mark.parametrize("suffix", [".csv", ".mat"])
def test_a_result_is_read_as_it_was(run: planarc.Result, tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"run{suffix}"
    run.to_csv(file) if suffix == ".csv" else run.to_mat(file)
    read = planarc.read(str(file), FOUR_BAR)
    assert read["revA.phi"].tolist() == run["revA.phi"].tolist()
    assert (read.unit("revA.phi"), len(read)) == ("rad", len(run))
    assert read.at("revA.phi", 0.55) == run.at("revA.phi", 0.55)
    assert read.animate(tmp_path / "moving.svg").exists()


def test_a_table_of_another_tool_is_read_without_a_model(tmp_path: Path) -> None:
    file = tmp_path / "measured.csv"
    file.write_text('"time","x [mm]"\n0,1\n2,3\n', "utf-8")
    read = planarc.read(file)
    assert (read.names, read.unit("x"), read.at("x", 1.0)) == (("x",), "mm", 2.0)
    assert read["x"].tolist() == [1.0, 3.0]


def test_what_cannot_be_read_is_told(run: planarc.Result, tmp_path: Path) -> None:
    with pytest.raises(planarc.UsageError, match="V503"):
        planarc.read(tmp_path / "nosuch.csv")
    with pytest.raises(planarc.UsageError, match="V502"):
        planarc.read(FOUR_BAR)
    with pytest.raises(planarc.UsageError, match="C202"):
        planarc.read(3)  # type: ignore[arg-type]
    with pytest.raises(planarc.UsageError, match="C290"):
        planarc.read(run.to_csv(tmp_path / "run.csv"), FOUR_BAR.with_name("pendulum.pmo"))


def test_notebooks_complete_names_and_show_a_model(run: planarc.Result) -> None:
    model = planarc.load(FOUR_BAR)
    for thing in (run, model.parameters, model.variables, model.states):
        assert set(thing._ipython_key_completions_()) == set(thing)
    assert "revA.phi" in model.equilibrium()._ipython_key_completions_()
    shown = model._repr_html_()
    assert "FourBar: Four bars in a loop" in shown
    assert "<td>crankBody.m</td><td>1</td><td>kg</td><td>Mass</td>" in shown
