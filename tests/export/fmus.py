"""What tests of FMUs share: archives of this platform, and runs of them by FMPy."""

from __future__ import annotations

import platform
from pathlib import Path

import fmpy
import numpy as np
import pytest

from planarc.compiled import Compiled
from planarc.export.fmu import make_fmu
from planarc.export.wishes import Wishes

EXAMPLES = Path(__file__).parents[2] / "examples"
HERE = platform.system() == "Linux" and platform.machine() in ("x86_64", "aarch64")
runs_here = pytest.mark.skipif(not HERE, reason="there is no library for this platform")
WAYS = ("ModelExchange", "CoSimulation")


def written(path: Path, compiled: Compiled, version: int) -> Path:
    """The FMU of a model for this platform, made where there is none yet."""
    if not path.exists():
        own = (f"{platform.machine()}-linux",) if HERE else ("x86_64-linux",)
        path.write_bytes(make_fmu(compiled, Wishes(version, platforms=own)).data)
    return path


def simulate(path: Path, way: str, stop: float, **more: object) -> np.ndarray:
    """A run at a strict tolerance with all outputs in 101 rows, none at events."""
    names = [v.name for v in fmpy.read_model_description(path).modelVariables
             if v.causality == "output"]  # fmt: skip
    options: dict = {"record_events": False, "output_interval": stop / 100, **more}
    return fmpy.simulate_fmu(
        path, fmi_type=way, stop_time=stop, relative_tolerance=1e-11, output=names, **options
    )
