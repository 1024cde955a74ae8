"""A loop stays closed for as long as it runs: constraints are solved, not integrated."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np


def test_the_four_bar_is_closed_after_a_thousand_seconds(run: Callable[..., Any]) -> None:
    model = Path(__file__).parent / "b2_fourbar_gravity" / "four_bar.pmo"
    result = run(model, 1000.0, 5000, 1e-6, "native")
    crank, coupler, rocker = (result[f"{bar}Body.phi"] for bar in ("crank", "coupler", "rocker"))
    gap = 0.4 * np.exp(1j * crank) + 0.9 * np.exp(1j * coupler) - 1 - 0.8 * np.exp(1j * rocker)
    assert np.max(np.abs(gap)) < 1e-6
