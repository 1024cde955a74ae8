"""The paper's claim on rods without angles holds, and the script that shows it runs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parent / "paper_claims.py"


def sizes(cells: list[str]) -> list[int]:
    return [int(part) for cell in cells for part in cell.split("/")]


def test_rods_without_angles_make_the_torn_blocks_smaller() -> None:
    command = [sys.executable, str(SCRIPT)]
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    rods, hinges = (line.split()[1:] for line in lines[1:3])
    assert len(rods) == len(hinges) == 3  # one nonlinear block, two linear ones
    assert all(a < b for a, b in zip(sizes(rods), sizes(hinges), strict=True))
    assert float(lines[-1].split()[-2]) < 1e-3  # the motion is the same
