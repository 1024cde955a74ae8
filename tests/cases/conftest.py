"""How a reference case is run: the only place here that knows planarc's entry."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


def simulate(
    model: Path,
    stop: float,
    intervals: int,
    tolerance: float,
    backend: str,
    solver: str = "auto",
) -> Any:
    """The result of a run; `result[name]` are the values of a variable over `result.time`."""
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


@pytest.fixture
def run() -> Callable[..., Any]:
    return simulate
