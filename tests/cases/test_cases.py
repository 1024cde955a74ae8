"""Every reference case reaches its tolerances: all signals, both tolerances, both back ends,
every solver. `accuracy.py` prints the numbers."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from accuracy import MODELS, SOLVERS, TOLERANCES, errors


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.parent.name}-{m.stem}")
def test_signals_follow_the_reference(model: Path, tolerance: str, backend: str) -> None:
    assert missed(errors(model, tolerance, backend, "auto")) == {}


#: See `planarc.solve.solvers.scipy`: what a solver does not claim to pass.
NOT_CLAIMED = {("n_four_bar", "1e-9", "scipy-bdf")}


@pytest.mark.parametrize("solver", [s for s in SOLVERS if s != "auto"])
@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.parent.name}-{m.stem}")
def test_every_solver_follows_the_reference(model: Path, tolerance: str, solver: str) -> None:
    if (model.stem, tolerance, solver) in NOT_CLAIMED:
        pytest.skip(f"{solver} does not claim {model.stem} at {tolerance}: see NOT_CLAIMED")
    assert missed(errors(model, tolerance, "native", solver)) == {}


def missed(parts: dict[str, float]) -> dict[str, float]:
    """Errors that are greater than allowed, as parts of that."""
    return {signal: part for signal, part in parts.items() if not part <= 1.0}
