"""Random mechanisms with joints that repeat others: motion and forces of least squares against
a pseudo-inverse in absolute coordinates."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from agreement import disagreement
from mechanism import model_text
from redundant import LeastSquares, redundant

COUNT = int(os.environ.get("PLANARC_REDUNDANT", "24"))
#: With NumPy's back end the states chosen at the start of 97 go bad where the scales of the
#: constraints change, which neither the way nor the velocities tell.
KEPT = (97,)


@pytest.fixture(autouse=True)
def forgetful(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody will ask for these models again."""
    monkeypatch.setattr("planarc.remembered.remember", lambda *_: None)


@pytest.mark.parametrize("seed", sorted({*range(COUNT), *KEPT}))
def test_motion_and_forces_of_least_squares_agree(seed: int) -> None:
    backend = "native" if seed % 8 == 7 else "numpy"
    if backend == "native":
        pytest.importorskip("llvmlite")
    m, dependent = redundant(seed)
    reference = LeastSquares(m, dependent)
    q = reference.start()
    # Untold coordinates of joints that repeat others are found by Newton's method.
    found = disagreement(m, backend, reference, "accept", start=1e-6)
    assert not found, f"{found}\n{model_text(m, reference.frame_speeds(q, reference.drift(q)))}"
