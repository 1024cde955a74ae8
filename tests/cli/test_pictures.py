"""`planarc animate` and `planarc plot`: files, and what is said about them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planarc.cli.app import run

PENDULUM = Path(__file__).parents[2] / "examples" / "pendulum.pmo"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pendulum.pmo").write_text(PENDULUM.read_text("utf-8"), "utf-8")
    return tmp_path


def test_a_model_is_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["animate", "pendulum.pmo", "-o", "a.svg", "--to", "3", "--speed", "0.5"]) == 0
    said = capsys.readouterr().out
    assert "a.svg" in said
    assert "6 s in 301 frames, 2 times slower" in said
    assert "animateTransform" in Path("a.svg").read_text("utf-8")


def test_a_result_is_drawn_with_the_model_beside_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", "pendulum.pmo", "--no-report", "--stop", "2"]) == 0
    assert run(["animate", "Pendulum.csv", "-o", "a.svg"]) == 0
    assert run(["animate", "pendulum.pmo", "--stop", "2", "-o", "b.svg"]) == 0
    assert Path("a.svg").read_text("utf-8") == Path("b.svg").read_text("utf-8")
    Path("Pendulum.csv").rename("run.csv")
    assert run(["animate", "run.csv", "--model", "pendulum.pmo", "-o", "c.svg"]) == 0
    assert Path("a.svg").read_text("utf-8") == Path("c.svg").read_text("utf-8")


def test_a_mode_of_the_linear_model_is_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--mode", "1", "--around", "equilibrium", "--json"]
    assert run(["animate", "pendulum.pmo", "-o", "a.svg", *arguments]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["ok"]
    assert told["output"] == "a.svg"
    assert told["frames"] > 50


def test_settings_hold_for_the_picture() -> None:
    for name, more in (("a.svg", []), ("b.svg", ["--set", "hinge.phi.start=1"])):
        assert run(["animate", "pendulum.pmo", "--at", "0", "-o", name, *more]) == 0
    assert Path("a.svg").read_text("utf-8") != Path("b.svg").read_text("utf-8")


def test_quiet_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["animate", "pendulum.pmo", "-q", "--at", "0", "-o", "a.svg"]) == 0
    assert capsys.readouterr().out == ""


def test_curves_of_a_model_and_of_a_result(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    assert run(["plot", "pendulum.pmo", "hinge.phi", "hinge.w", "-o", "a.svg"]) == 0
    text = Path("a.svg").read_text("utf-8")
    assert "hinge.phi [rad]" in text
    assert "hinge.w [rad/s]" in text
    assert run(["simulate", "pendulum.pmo", "--no-report", "--units", "--output", "a.csv"]) == 0
    assert run(["plot", "a.csv", "hinge.w", "--x", "hinge.phi", "-o", "b.svg"]) == 0
    assert "hinge.phi [rad]" in Path("b.svg").read_text("utf-8")
    # Without units in the file those of its model, where that is found.
    assert run(["simulate", "pendulum.pmo", "--no-report"]) == 0
    assert run(["plot", "Pendulum.csv", "hinge.w", "--x", "hinge.phi", "-o", "c.svg"]) == 0
    assert Path("c.svg").read_text("utf-8") == Path("b.svg").read_text("utf-8")
    Path("Pendulum.csv").rename("other.csv")
    assert run(["plot", "other.csv", "hinge.w", "-o", "d.svg"]) == 0
    assert "hinge.w [rad/s]" not in Path("d.svg").read_text("utf-8")


TWO = """model Fast
  Real y = 2*time;
end Fast;

model Slow
  Real y = time, fast = 3;
end Slow;

package Others
  model Still
    Real y = 1;
  end Still;
end Others;
"""


def test_the_class_of_a_file_stands_before_what_is_drawn(
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("matplotlib")
    Path("two.pmo").write_text(TWO, "utf-8")
    for words in (["Slow", "y", "fast"], ["Fast", "y"], ["Others.Still", "y"], ["Still", "y"]):
        assert run(["plot", "two.pmo", *words, "-o", f"{words[0]}.svg"]) == 0
    assert Path("Slow.svg").read_text("utf-8") != Path("Fast.svg").read_text("utf-8")
    capsys.readouterr()
    assert run(["plot", "two.pmo", "y", "-o", "a.svg"]) == 2
    assert "hint: name one of them behind the file: `two.pmo Fast`" in capsys.readouterr().err
    assert run(["plot", "two.pmo", "Fast", "-o", "a.svg"]) == 2
    assert "error[C100]: `Fast` is a model" in capsys.readouterr().err


@pytest.mark.parametrize(
    "option", [["--set", "L=2"], ["--stop", "0.5"], ["--redundant", "accept"]], ids=str
)
@pytest.mark.parametrize("command", [["plot", "a.csv", "y"], ["animate", "a.csv"]], ids=str)
def test_a_result_is_not_run_again(
    command: list[str], option: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    Path("a.csv").write_text("time,y\n0,1\n1,2\n", "utf-8")
    assert run([*command, *option, "-o", "a.svg"]) == 2
    assert f"error[C272]: `{option[0]}` needs a model" in capsys.readouterr().err
    assert not Path("a.svg").exists()


def test_a_gallery_of_nothing_is_a_wrong_request(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["gallery", "nosuch", "--output", str(tmp_path / "g.html")]) == 2
    assert "error[C103]" in capsys.readouterr().err


def test_a_gallery_makes_the_folder_of_its_reports(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "decay.pmo").write_text(
        "model Decay Real x(start=1, fixed=true); equation der(x) = -x;\n"
        "  annotation(experiment(StopTime=1)); end Decay;",
        "utf-8",
    )
    command = ["gallery", str(tmp_path / "decay.pmo"), "--output", str(tmp_path / "g.html")]
    assert run([*command, "--reports", str(tmp_path / "all/of/them")]) == 0
    assert (tmp_path / "all/of/them/Decay.html").exists()
    (tmp_path / "file").touch()
    assert run([*command, "--reports", str(tmp_path / "file/in")]) == 2
    assert "error[C123]: cannot make the folder" in capsys.readouterr().err
