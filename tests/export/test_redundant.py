"""Exported models with redundant joints that were accepted: their motion is that of planarc."""

from __future__ import annotations

import platform
import re
from functools import cache
from pathlib import Path

import fmpy
import numpy as np
import pytest

from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.options import Redundant, RunOptions
from planarc.export.fmu import make_fmu
from planarc.export.wishes import Wishes
from planarc.request.request import Request
from tests.solve.start.test_redundant_joints import bars

HERE = platform.system() == "Linux" and platform.machine() in ("x86_64", "aarch64")
pytestmark = pytest.mark.skipif(not HERE, reason="there is no library for this platform")
WISHES = Wishes(
    platforms=(f"{platform.machine()}-linux",),
    outputs=re.compile(r"^low\d\.(phi|w)$|^high\d\.frame_a\.f"),
)


@cache
def compiled() -> Compiled:
    text = bars((0, 1, 2), centre=1.0)
    return compile_model(Request(Path("M.pmo"), text=text, redundant=Redundant.ACCEPT))


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fmus") / "bars.fmu"
    path.write_bytes(make_fmu(compiled(), WISHES).data)
    return path


@pytest.mark.parametrize("way", ("ModelExchange", "CoSimulation"))
def test_three_bars_swing_as_in_planarc(archive: Path, way: str) -> None:
    """Shares of forces hang on positions by large factors: two tolerances of planarc's own run
    differ in them as much."""
    result = run(compiled(), RunOptions(stop=1.0, intervals=100, tolerance=1e-11))
    columns = {c.name: c for c in compiled().program.columns}
    table = fmpy.simulate_fmu(archive, fmi_type=way, stop_time=1.0, relative_tolerance=1e-11,
                              output_interval=0.01)  # fmt: skip
    for name in table.dtype.names[1:]:
        c = columns[name]
        values = c.sign * result.data[:, result.stored[c.slot]]
        missed = np.abs(table[name] - values).max() / np.ptp(values)
        assert missed < (1e-6 if name.startswith("low") else 3e-5), name


def test_a_bar_of_another_length_does_not_fit(archive: Path) -> None:
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(archive, start_values={"bar1.r[2]": 1.2}, stop_time=0.5,
                          logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert "`top1` does not fit" in told[0]
