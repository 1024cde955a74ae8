"""How far runs are from the reference cases, as parts of what is allowed.

    python tests/cases/accuracy.py [--only CASE] [--solver NAME] [--backend NAME] [--tolerance T]

prints the greatest error of any signal, and of the event times, divided by its tolerance:
a row for each model and tolerance, a column for each solver. `-` is a run that ended early.
`tests/cases/test_cases.py` holds the same numbers below 1.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
FOLDERS = sorted(path.parent for path in HERE.glob("*/case.json"))
SOLVERS = ("auto", "cvode-adams", "lsoda", "scipy-bdf", "exported")
TOLERANCES = ("1e-6", "1e-9")


def case_of(folder: Path) -> Any:
    return json.loads((folder / "case.json").read_text(encoding="utf-8"))


MODELS = [folder / model for folder in FOLDERS for model in case_of(folder)["models"]]


def run(
    model: Path, stop: float, intervals: int, tolerance: float, backend: str, solver: str = "auto"
) -> Any:
    """The result of a run; `result[name]` are the values of a variable over `result.time`.

    The only place here that knows planarc's entry.
    """
    from planarc.compiler import simulate
    from planarc.core.options import Backend, RunOptions, Solver

    options = RunOptions(
        stop=stop,
        intervals=intervals,
        tolerance=tolerance,
        backend=Backend(backend),
        solver=Solver(solver),
    )
    return simulate(model, options=options)


def errors(
    model: Path,
    tolerance: str,
    backend: str,
    solver: str,
    run: Callable[..., Any] = run,
) -> dict[str, float]:
    """Of each signal, and of the `event times`, the error as a part of its tolerance."""
    folder = model.parent
    case = case_of(folder)
    reference = _table(folder / "reference.csv")
    wanted = reference["time"]
    intervals = len(wanted) - 1
    result = run(model, case["stop"], intervals, float(tolerance), backend, solver)
    rows = _rows_at(result.time, wanted)

    found = {}
    compared = np.ones(len(wanted), dtype=bool)
    if events := case.get("events"):
        exact = np.atleast_1d(_table(folder / events["times"])["t"])
        instants = np.array([event.time for event in result.events])
        # Relations that decide nothing may change at other instants ("others").
        assert len(instants) == len(exact) or events.get("others")
        nearest = instants[np.argmin(np.abs(instants[:, None] - exact), axis=0)]
        found["event times"] = float(np.max(np.abs(nearest - exact))) / events[tolerance]
        compared = np.min(np.abs(wanted[:, None] - exact), axis=1) > events["blind"]
    for signal, expected in case["signals"].items():
        values = result[expected["variable"]][rows]
        error = float(np.max(np.abs(values - reference[signal])[compared]))
        found[signal] = error / expected[tolerance]
    return found


def _table(path: Path) -> Any:
    return np.genfromtxt(path, delimiter=",", names=True)


def _rows_at(time: Any, wanted: Any) -> Any:
    """For each wanted instant the row of the result that stands there."""
    after = np.clip(np.searchsorted(time, wanted), 1, len(time) - 1)
    nearest = np.where(wanted - time[after - 1] <= time[after] - wanted, after - 1, after)
    assert np.max(np.abs(time[nearest] - wanted)) < 1e-9, "the run has no row at an instant"
    return nearest


def rows(asked: argparse.Namespace) -> Iterator[str]:
    solvers = [s for s in SOLVERS if asked.solver in s]
    yield f"{'':34}{'tolerance':>10}" + "".join(f"{s:>13}" for s in solvers)
    for model in MODELS:
        name = f"{model.parent.name}/{model.stem}"
        for tolerance in TOLERANCES:
            if asked.only not in name or asked.tolerance not in tolerance:
                continue
            worst = [_worst(model, tolerance, asked.backend, s) for s in solvers]
            yield f"{name:34}{tolerance:>10}" + "".join(
                f"{'-' if math.isinf(w) else f'{w:.3g}':>13}" for w in worst
            )


def _worst(model: Path, tolerance: str, backend: str, solver: str) -> float:
    try:
        return max(errors(model, tolerance, backend, solver).values())
    except AssertionError:
        return math.inf


def main() -> None:
    parser = argparse.ArgumentParser(description="Errors of the reference cases.")
    parser.add_argument("--only", default="", metavar="CASE", help="cases whose name holds CASE")
    parser.add_argument("--solver", default="", metavar="NAME")
    parser.add_argument("--backend", default="native", choices=("native", "numpy"))
    parser.add_argument("--tolerance", default="", choices=("", *TOLERANCES))
    for line in rows(parser.parse_args()):
        print(line, flush=True)


if __name__ == "__main__":
    main()
