"""The equation written by hand for the benchmark is that of the four-bar, to every digit."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np

import planarc

HERE = Path(__file__).parent
MODEL = HERE.parent / "cases" / "b2_fourbar_gravity" / "four_bar.pmo"


def by_hand(tolerance: float) -> Any:
    sys.path.insert(0, str(HERE))
    try:
        return importlib.import_module("hand_written").simulate(1.0, tolerance).rows()[1]
    finally:
        sys.path.remove(str(HERE))


def test_both_formulations_move_alike() -> None:
    model = planarc.load(MODEL)
    result = model.simulate(10.0, intervals=500, tolerance=1e-10)
    rows = by_hand(1e-10)
    assert np.max(np.abs(result["revA.phi"] - rows[:, 0])) < 1e-8
    assert np.max(np.abs(result["revA.w"] - rows[:, 1])) < 1e-7
