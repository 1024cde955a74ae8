"""The commands of analyses and studies: what they say, as text and as JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc.cli.app import run
from planarc.view.table import read_table

ROOT = Path(__file__).parents[2]
PENDULUM = str(ROOT / "examples" / "pendulum.pmo")
FOUR_BAR = str(ROOT / "examples" / "four_bar.pmo")


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert run(arguments) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    return json.loads(said(capsys, *arguments, "--json"))


def test_linearize(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "linearize", FOUR_BAR, "--at", "equilibrium", "--output-of", "revD.phi")
    (mode,) = found["modes"]
    assert found["stable"]
    assert mode["natural_frequency"] == pytest.approx(math.sqrt(-found["A"][1][0]))
    assert (found["states"], found["outputs"]) == (["revA.phi", "revA.w"], ["revD.phi"])
    assert len(found["C"]) == 1
    text = said(capsys, "linearize", FOUR_BAR, "--at", "equilibrium")
    assert f"{mode['natural_frequency']:.6g}" in text


def test_equilibrium(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "equilibrium", FOUR_BAR, "--set", "revA.phi.start=-1")
    assert abs(found["values"]["revA.z"]) < 1e-7
    text = said(capsys, "equilibrium", FOUR_BAR)
    assert "stable" in text
    assert f"{found['start']['revA.phi']:.7g}" in text


def test_assemble(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "assemble", FOUR_BAR, "--tries", "40")
    assert len(found["assemblies"]) == 2
    assert "2 ways" in said(capsys, "assemble", FOUR_BAR, "--tries", "40")


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_simulate_lists_the_assemblies_and_runs_nothing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    backend: str,
) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    monkeypatch.chdir(tmp_path)
    options = ("--assembly", "--backend", backend, "--set", "revA.phi.start=0.5")
    found = told(capsys, "simulate", FOUR_BAR, *options)
    assert len(found["assemblies"]) == 2
    assert {way["start"]["revA.phi"] for way in found["assemblies"]} == {0.5}
    assert "2 ways" in said(capsys, "simulate", FOUR_BAR, *options)
    assert list(tmp_path.iterdir()) == []


def test_assemblies_are_written_into_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", FOUR_BAR, "--assembly", "--output", "x.csv"]) == 2
    assert "C112" in capsys.readouterr().err


def test_drive(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    motion, forces = tmp_path / "motion.csv", tmp_path / "forces.csv"
    time = np.linspace(-0.1, 1.1, 500)
    rows = "\n".join(f"{t!r},{1 + 2 * t!r}" for t in time.tolist())
    motion.write_text(f"time,phi\n{rows}\n", "utf-8")
    options = ("--stop", "1", "--intervals", "10")
    by_text = told(capsys, "drive", FOUR_BAR, "--motion", "revA.phi=1 + 2*time", *options)
    by_file = told(capsys, "drive", FOUR_BAR, "--motion", f"revA.phi=@{motion}", *options)
    torques = [found["efforts"]["revA.phi"]["values"] for found in (by_text, by_file)]
    assert np.allclose(*torques, atol=1e-6)
    text = said(
        capsys, "drive", FOUR_BAR, "--motion", "revA.phi=1 + 2*time", "--output", str(forces),
        *options,
    )  # fmt: skip
    assert "revA.tau" in text
    assert np.allclose(read_table(forces)["revA.tau"], torques[0])


def test_sensitivity(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    table = tmp_path / "s.csv"
    options = ("--parameter", "crankBody.m", "--variable", "revA.phi", "--stop", "1")
    found = told(capsys, "sensitivity", FOUR_BAR, *options, "--intervals", "4")
    (only,) = found["sensitivities"]
    assert (only["variable"], only["parameter"]) == ("revA.phi", "crankBody.m")
    text = said(capsys, "sensitivity", FOUR_BAR, *options, "--output", str(table))
    assert f"{only['values'][-1]:.4g}" in text
    assert table.read_text("utf-8").startswith("time,d(revA.phi)/d(crankBody.m)")


def test_sweep(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    options = ("--metric", "max(revA.w)", "--metric", "revA.phi", "--stop", "1")
    found = told(capsys, "sweep", FOUR_BAR, "--vary", "crankBody.m=0.5:1:3", *options)
    assert found["columns"] == ["crankBody.m", "max(revA.w)", "revA.phi"]
    assert [row[0] for row in found["rows"]] == [0.5, 0.75, 1.0]
    listed = told(capsys, "sweep", FOUR_BAR, "--vary", "crankBody.m=0.5,0.75,1", *options)
    assert listed["rows"] == found["rows"]
    journal, table = tmp_path / "j", tmp_path / "t.csv"
    sample = ("sweep", FOUR_BAR, "--vary", "crankBody.m=1:2", "--latin", "25", *options)
    again = [
        said(capsys, *sample, "--journal", str(journal), "--output", str(table)) for _ in (1, 2)
    ]
    assert again[0] == again[1]
    assert "25 points in all" in again[0]
    assert len(table.read_text("utf-8").splitlines()) == 26


def test_a_sweep_with_failed_points_says_which(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["sweep", FOUR_BAR, "--vary", "coupler.r[1]=0.9,0.01", "--stop", "1"]) == 3
    captured = capsys.readouterr()
    assert "point 2 (coupler.r[1] = 0.01) failed" in captured.err
    assert captured.out.count("\n") == 3


WRONG = [
    (("sweep", FOUR_BAR), "nothing is varied"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m"), "no NAME=VALUE"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=a,b"), "no numbers"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1:2"), "how many"),
    (("sweep", FOUR_BAR, "--vary", "crankBdy.m=1,2"), "crankBody.m"),
    (("sweep", FOUR_BAR, "--vary", "revA.drivenFlange=true,false"), "structural"),
    (("sweep", FOUR_BAR, "--vary", "a=1:2", "--random", "3", "--latin", "3"), "both"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1,2", "--output", "no/a.csv"), "no folder `no`"),
    (("sensitivity", FOUR_BAR, "--parameter", "world.g", "--output", "no/a.csv"), "no folder"),
    (("drive", FOUR_BAR, "--motion", "revA.phi=1", "--output", "a.txt"), "use `.csv` or `.mat`"),
    (("drive", FOUR_BAR, "--motion", "revA.phi=sin(tme)"), "`revA.phi` cannot follow `sin(tme)`"),
    (("drive", FOUR_BAR), "no motion is given"),
    (("drive", FOUR_BAR, "--motion", "revA.phi=@nowhere.csv"), "cannot read"),
    (("drive", FOUR_BAR, "--motion", "revA.w=1"), "no coordinate of a joint"),
    (("sensitivity", FOUR_BAR), "no parameter is named"),
    (("linearize", FOUR_BAR, "--at", "rest"), "choose among `start`, `equilibrium`"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_a_wrong_command_line_says_so(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], words: str
) -> None:
    assert run(arguments) == 2
    assert words in capsys.readouterr().err
    assert run([*arguments, "--json"]) == 2
    assert not json.loads(capsys.readouterr().out)["ok"]
