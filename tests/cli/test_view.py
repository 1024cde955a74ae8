"""`planarc view`: pages of results that were written before."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from planarc.cli.app import run

MODEL = """
model Swing "A rod that swings"
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=1, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.BodyShape rod(r={L, 0}, m=1);
  parameter Real L = 1;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, rod.frame_a);
  annotation(experiment(StopTime=1, Interval=0.1));
end Swing;
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "swing_model.pmo").write_text(MODEL, encoding="utf-8")
    return tmp_path


def data_of(path: Path) -> Any:
    page = path.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


def drawn(path: Path) -> set[str]:
    return {item["component"] for item in data_of(path)["scene"]["items"]}


def simulate(*arguments: str) -> None:
    assert run(["simulate", "swing_model.pmo", "Swing", "--no-report", "-q", *arguments]) == 0


def test_a_csv_called_like_its_class_finds_the_model(here: Path) -> None:
    simulate()
    assert run(["view", "Swing.csv", "--no-open"]) == 0
    assert "rod" in drawn(here / "Swing.html")


@pytest.mark.parametrize("name", ["run.csv", "run.mat"])
def test_a_result_tells_where_its_model_stands_and_what_was_set(here: Path, name: str) -> None:
    (here / "models").mkdir()
    (here / "swing_model.pmo").rename(here / "models" / "elsewhere.pmo")
    command = ["simulate", "models/elsewhere.pmo", "Swing", "--no-report", "-q", "-o", name]
    assert run([*command, "--set", "L=2.5"]) == 0
    assert run(["view", name, "-o", "page.html", "--no-open"]) == 0
    items = data_of(here / "page.html")["scene"]["items"]
    (rod,) = [i for i in items if i["component"] == "rod"]
    assert rod["length"] == 2.5


def test_structural_parameters_are_those_of_the_run(here: Path) -> None:
    simulate("--set", "rod.animation=false")
    assert run(["view", "Swing.csv", "--no-open"]) == 0
    assert "rod" not in drawn(here / "Swing.html")


def test_a_page_that_shows_the_motion_is_not_replaced_by_curves_alone(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["simulate", "swing_model.pmo", "Swing", "-q"]) == 0
    (here / "swing_model.pmo").unlink()
    before = (here / "Swing.html").read_bytes()
    assert run(["view", "Swing.csv", "--no-open"]) == 0
    assert "kept" in capsys.readouterr().out
    assert (here / "Swing.html").read_bytes() == before
    assert data_of(here / "Swing-curves.html")["scene"]["items"] == []
    assert run(["view", "Swing.csv", "--no-open", "-o", "Swing.html"]) == 0  # asked for
    assert data_of(here / "Swing.html")["scene"]["items"] == []


def test_of_another_table_with_that_name_nothing_is_told(here: Path) -> None:
    simulate()
    (here / "Swing.csv").write_text("time,height\n0,1\n1,2\n", encoding="utf-8")
    assert run(["view", "Swing.csv", "--no-open"]) == 0
    assert data_of(here / "Swing.html")["scene"]["items"] == []


def test_a_result_that_was_moved_alone_says_which_file_it_misses(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    simulate()
    away = here / "away"
    away.mkdir()
    for file in here.glob("Swing.csv*"):
        file.rename(away / file.name)
    (here / "swing_model.pmo").unlink()
    assert run(["view", "away/Swing.csv", "--no-open"]) == 0
    told = capsys.readouterr().out
    assert f"Swing, but there is no file {Path('away') / 'swing_model.pmo'}: curves only" in told


def test_units_of_a_csv_are_known_without_the_model(here: Path) -> None:
    simulate()
    (here / "swing_model.pmo").unlink()
    assert run(["view", "Swing.csv", "--no-open"]) == 0
    units = {v[0]: v[3] for v in data_of(here / "Swing.html")["curves"]["variables"]}
    assert units["hinge.w"] == "rad/s"


def test_a_mat_tells_its_class_and_the_parameters_of_its_run(here: Path) -> None:
    simulate("--set", "L=2.5", "--output", "run.mat")
    assert run(["view", "run.mat", "-o", "page.html", "--no-open"]) == 0
    items = data_of(here / "page.html")["scene"]["items"]
    (rod,) = [i for i in items if i["component"] == "rod"]
    assert rod["length"] == 2.5


def test_the_page_is_that_of_the_run_itself(here: Path) -> None:
    assert run(["simulate", "swing_model.pmo", "Swing", "-q", "--output", "run.mat"]) == 0
    assert run(["view", "run.mat", "-o", "again.html", "--no-open", "-q"]) == 0
    first, again = data_of(here / "Swing.html"), data_of(here / "again.html")
    assert again["scene"] == first["scene"]
    assert again["curves"]["figures"] == first["curves"]["figures"]


def test_without_a_model_there_are_curves_and_the_page_says_so(here: Path) -> None:
    (here / "other.csv").write_text("time,height,speed\n0,1,2\n1,2,3\n", encoding="utf-8")
    assert run(["view", "other.csv", "--no-open"]) == 0
    data = data_of(here / "other.html")
    assert data["scene"]["items"] == []
    assert [v[0] for v in data["curves"]["variables"]] == ["height", "speed"]
    assert "--model" in (here / "other.html").read_text(encoding="utf-8")


def test_some_variables_only_draw_what_they_can_and_name_the_rest(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    simulate("--variables", r"^hinge\.|frame")
    assert run(["view", "Swing.csv", "--no-open"]) == 0
    assert "is not drawn" in (here / "Swing.html").read_text(encoding="utf-8") or (
        "does not hold" in capsys.readouterr().out
    )


def test_a_result_of_another_model_is_refused(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    simulate()
    model = "PlanarMultiBody.Examples.Loops.TwoLoops"
    assert run(["view", "Swing.csv", "--no-open", "--model", model]) == 2
    assert "C290" in capsys.readouterr().err


def test_without_a_browser_the_line_that_says_so_ends(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    simulate()
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    assert run(["view", "Swing.csv"]) == 0
    assert capsys.readouterr().err == "no browser was found: open the page by hand\n"


def test_a_class_is_named_by_its_option(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulate()
    (here / "two.pmo").write_text("model A\nend A;\n" + MODEL, encoding="utf-8")
    arguments = ["view", "Swing.csv", "--model", "two.pmo", "--no-open"]
    assert run(arguments) == 2
    assert "hint: name one of them with `--class`" in capsys.readouterr().err
    assert run([*arguments, "--class", "Swing"]) == 0


def test_a_curve_that_is_not_there_names_the_nearest(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    simulate()
    assert run(["view", "Swing.csv", "--no-open", "--curve", "hinge.fi"]) == 2
    assert "hinge.phi" in capsys.readouterr().err


def test_a_file_of_the_user_is_not_replaced(here: Path) -> None:
    simulate()
    (here / "Swing.html").write_text("mine", encoding="utf-8")
    assert run(["view", "Swing.csv", "--no-open"]) == 2
    assert (here / "Swing.html").read_text(encoding="utf-8") == "mine"
