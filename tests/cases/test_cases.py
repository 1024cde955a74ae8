"""Every reference case reaches its tolerances: all signals, both tolerances, both back ends."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

FOLDERS = sorted(path.parent for path in Path(__file__).parent.glob("*/case.json"))


def case_of(folder: Path) -> Any:
    return json.loads((folder / "case.json").read_text(encoding="utf-8"))


MODELS = [folder / model for folder in FOLDERS for model in case_of(folder)["models"]]


def table(path: Path) -> Any:
    return np.genfromtxt(path, delimiter=",", names=True)


def rows_at(time: Any, wanted: Any) -> Any:
    """For each wanted instant the row of the result that stands there."""
    after = np.clip(np.searchsorted(time, wanted), 1, len(time) - 1)
    nearest = np.where(wanted - time[after - 1] <= time[after] - wanted, after - 1, after)
    assert np.max(np.abs(time[nearest] - wanted)) < 1e-9, "the run has no row at an instant"
    return nearest


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("tolerance", ["1e-6", "1e-9"])
@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.parent.name}-{m.stem}")
def test_signals_follow_the_reference(
    model: Path, tolerance: str, backend: str, run: Callable[..., Any]
) -> None:
    compare(model, tolerance, backend, "auto", run)


#: See `planarc.solve.solvers.scipy`: what a solver does not claim to pass.
NOT_CLAIMED = {("n_four_bar", "1e-9", "scipy-bdf")}


@pytest.mark.parametrize("solver", ["cvode-adams", "lsoda", "scipy-bdf", "ida"])
@pytest.mark.parametrize("tolerance", ["1e-6", "1e-9"])
@pytest.mark.parametrize("model", MODELS, ids=lambda m: f"{m.parent.name}-{m.stem}")
def test_every_solver_follows_the_reference(
    model: Path, tolerance: str, solver: str, run: Callable[..., Any]
) -> None:
    if (model.stem, tolerance, solver) in NOT_CLAIMED:
        pytest.skip(f"{solver} does not claim {model.stem} at {tolerance}: see NOT_CLAIMED")
    compare(model, tolerance, "native", solver, run)


def compare(
    model: Path, tolerance: str, backend: str, solver: str, run: Callable[..., Any]
) -> None:
    folder = model.parent
    case = case_of(folder)
    reference = table(folder / "reference.csv")
    wanted = reference["time"]
    intervals = len(wanted) - 1
    result = run(model, case["stop"], intervals, float(tolerance), backend, solver)
    rows = rows_at(result.time, wanted)

    compared = np.ones(len(wanted), dtype=bool)
    if events := case.get("events"):
        exact = np.atleast_1d(table(folder / events["times"])["t"])
        instants = np.array([event.time for event in result.events])
        # Relations that decide nothing may change at other instants ("others").
        assert len(instants) == len(exact) or events.get("others")
        nearest = instants[np.argmin(np.abs(instants[:, None] - exact), axis=0)]
        assert np.max(np.abs(nearest - exact)) <= events[tolerance]
        compared = np.min(np.abs(wanted[:, None] - exact), axis=1) > events["blind"]

    missed = {}
    for signal, expected in case["signals"].items():
        values = result[expected["variable"]][rows]
        error = float(np.max(np.abs(values - reference[signal])[compared]))
        if not error <= expected[tolerance]:
            missed[signal] = f"{error:.2e} > {expected[tolerance]:.0e}"
    assert not missed
