"""What a shell offers: files, classes, variables, layers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ARM = """package Arms
  model Arm
    parameter Real L = 2;
    Real x(start=1, fixed=true);
  equation
    der(x) = -x/L;
    annotation(experiment(StopTime=1));
  end Arm;
end Arms;
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "arm.pmo").write_text(ARM, "utf-8")
    (tmp_path / "run.csv").write_text('"time","rod.x","rod.y"\n0,1,2\n1,1,2\n', "utf-8")
    return tmp_path


def offered(folder: Path, words: str) -> list[str]:
    """The words that a shell is told behind the last blank."""
    env = {
        **os.environ,
        "_PLANARC_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split(" ")) - 1),
    }
    command = [sys.executable, "-m", "planarc"]
    done = subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True)
    assert done.stderr == ""
    return done.stdout.split()


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("planarc simulate ar", ["arm.pmo"]),
        ("planarc list PlanarMultiBody.Joints.Cur", ["PlanarMultiBody.Joints.CurveCurveJoint"]),
        ("planarc simulate arm.pmo Arms.", ["Arms.Arm"]),
        ("planarc simulate arm.pmo --set x", ["x.start="]),
        ("planarc simulate arm.pmo --set L", ["L="]),
        ("planarc plot run.csv rod.", ["rod.x", "rod.y"]),
        ("planarc plot run.csv ro", ["rod.x", "rod.y"]),
        ("planarc animate arm.pmo --layer v", ["velocities"]),
        ("planarc sweep arm.pmo --metric max(", ["max(x)", "max(der(x))"]),
        ("planarc sweep arm.pmo --metric r", ["rms(", "range("]),
        ("planarc plot nosuch.csv x", []),
        ("planarc simulate nosuch.pmo --set x", []),
        ("planarc doctor -", ["--json", "--help"]),
        ("planarc compile -h", ["-h"]),
        ("planarc --q", ["--quiet"]),
    ],
)
def test_the_shell_is_offered(folder: Path, words: str, wanted: list[str]) -> None:
    assert offered(folder, words) == wanted


@pytest.mark.parametrize("command", ["", "simulate ", "animate "])
def test_each_option_is_offered_once(folder: Path, command: str) -> None:
    names = offered(folder, f"planarc {command}-")
    assert "--help" in names
    assert all(name.startswith("--") for name in names)
