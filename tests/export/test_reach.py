"""Co-simulation follows a loop however long the steps are that the host asks for."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

import planarc
from tests.export.fmus import runs_here
from tests.solve.solvers.test_reach import PUMP


@runs_here
@pytest.mark.parametrize("interval", [0.1, 3])
def test_a_driven_loop_keeps_its_assembly(tmp_path: Path, interval: float) -> None:
    path = tmp_path / "Pump.fmu"
    planarc.load(PUMP).export_fmu(path)
    shown = ["main.phi", "cylinder.s"]
    result = fmpy.simulate_fmu(path, fmi_type="CoSimulation", stop_time=12,
                               output_interval=interval, output=shown)  # fmt: skip
    phi, s = result["main.phi"], result["cylinder.s"]
    assert s == pytest.approx(0.1 * np.cos(phi) + np.sqrt(0.16 - (0.1 * np.sin(phi)) ** 2))
