"""The march in machine code is the march from Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.solve.solvers.cvode import Cvode

pytest.importorskip("llvmlite")

TESTS = Path(__file__).parents[2]


@pytest.mark.parametrize(
    "model",
    [
        "cases/b2_fourbar_gravity/four_bar.pmo",  # passes dead centres of its states
        "cases/i1_bouncing_ball/bouncing_ball.pmo",  # with events
        "cases/h2_chain_pendulum_N10/chain_pendulum.pmo",
    ],
)
def test_rows_and_events_are_those_of_steps_from_python(
    model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = planarc.load(TESTS / model)
    native = loaded.simulate(2.0, tolerance=1e-8)

    def stepping(self: Cvode, *arguments: Any) -> None:
        made(self, *arguments)
        self.looks = False

    made = Cvode.__init__
    monkeypatch.setattr(Cvode, "__init__", stepping)
    stepped = loaded.simulate(2.0, tolerance=1e-8)
    assert np.array_equal(native.time, stepped.time)
    for name in native.names:
        assert native[name] == pytest.approx(stepped[name], rel=1e-5, abs=1e-5)
