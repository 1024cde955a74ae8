"""The paper's claim on rods without angles holds, and the script that shows it runs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parent / "paper_claims.py"


def sizes(cells: list[str]) -> list[int]:
    return [int(part) for cell in cells for part in cell.split("/")]


def test_rods_without_angles_make_the_torn_blocks_smaller(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), "--library", str(tmp_path)]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    rods, hinges = (line.split()[1:] for line in lines[1:3])
    assert len(rods) == len(hinges) == 3  # one nonlinear block, two linear ones
    assert all(a < b for a, b in zip(sizes(rods), sizes(hinges), strict=True))
    moves = next(line for line in lines if "move alike" in line)
    assert float(moves.split()[-2]) < 1e-3
    # Where there is no standard library to compare with, the script says so.
    assert lines[-1].endswith(f"{tmp_path} holds no Modelica/Mechanics/MultiBody")


def test_the_standard_library_is_looked_for_where_the_user_says(tmp_path: Path) -> None:
    (tmp_path / "Modelica" / "Mechanics" / "MultiBody").mkdir(parents=True)
    code = "import paper_claims as p; print(p.standard_library(None))"
    env = {**os.environ, "MODELICAPATH": os.pathsep.join(("nowhere", str(tmp_path)))}
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, cwd=SCRIPT.parent, env=env
    )
    assert done.stdout.strip() == str(tmp_path)
