"""The script that compares examples with published results runs, and tells what it finds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parent / "standard_results.py"
PENDULUM = "PlanarMultiBody.Examples.Elementary.Pendulum"


@pytest.fixture
def published(tmp_path: Path) -> Path:
    """What this planarc finds, as others publish it."""
    here = tmp_path.joinpath(*PENDULUM.split("."))
    here.mkdir(parents=True)
    (here / "comparisonSignals.txt").write_text("time\nhinge.phi\nhinge.w\n", "utf-8")
    told = "[ResultCreationLog]\nStartTime=0\nStopTime=1 // from model\nInterval=0.01\n"
    (here / "creation.txt").write_text(told + "Tolerance=1e-06 // default\n", "utf-8")
    command = ["simulate", PENDULUM, "--stop", "1", "--interval", "0.01", "--no-report", "--quiet"]
    output = ["--output", str(here / "Pendulum.csv")]
    subprocess.run([sys.executable, "-m", "planarc", *command, *output], check=True)
    return tmp_path


def told(folder: Path) -> list[str]:
    command = [sys.executable, str(SCRIPT), str(folder), "--only", "PlanarMultiBody."]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def test_a_result_that_agrees_is_told(published: Path) -> None:
    assert told(published) == [f"agrees   {PENDULUM}", "agrees: 1"]


def test_a_result_that_parts_is_told_with_its_place(published: Path) -> None:
    file = published.joinpath(*PENDULUM.split("."), "Pendulum.csv")
    head, *rows = file.read_text("utf-8").splitlines()
    at = head.replace('"', "").split(",").index("hinge.w")
    for k in range(60, len(rows)):
        cells = rows[k].split(",")
        rows[k] = ",".join([*cells[:at], str(float(cells[at]) + 1), *cells[at + 1 :]])
    file.write_text("\n".join([head, *rows]) + "\n", "utf-8")
    line, count = told(published)
    assert line.startswith(f"parts    {PENDULUM} hinge.w at t = 0.6")
    assert count == "parts: 1"


def test_a_class_that_is_refused_is_told_with_the_reason(published: Path) -> None:
    folder = published.joinpath(*PENDULUM.split("."))
    folder = folder.rename(folder.with_name("Absent"))
    (folder / "Pendulum.csv").rename(folder / "Absent.csv")
    line, count = told(published)
    assert line.startswith("refused  PlanarMultiBody.Examples.Elementary.Absent error[C103]")
    assert count == "refused: 1"
