"""Planar mechanisms from a Modelica-like language: compile, simulate, analyse.

    import planarc

    model = planarc.load("four_bar.pmo")
    result = model.simulate(stop_time=10)
    result["revA.phi"]                  # a NumPy array over result.time

The names below are found when they are first used, so that the import costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from planarc.core.diagnostic import Diagnostic, PlanarcError, RunError, UsageError
    from planarc.design import grid, latin_hypercube, random
    from planarc.model import Model, Recompiled, load
    from planarc.results import Result, RunStopped
    from planarc.study import Study, StudyInterrupted, sweep
    from planarc.variables import UnknownName

__all__ = [
    "Diagnostic",
    "Model",
    "PlanarcError",
    "Recompiled",
    "Result",
    "RunError",
    "RunStopped",
    "Study",
    "StudyInterrupted",
    "UnknownName",
    "UsageError",
    "grid",
    "latin_hypercube",
    "load",
    "random",
    "sweep",
]

_HOMES = {
    "Diagnostic": "core.diagnostic",
    "Model": "model",
    "PlanarcError": "core.diagnostic",
    "Recompiled": "model",
    "Result": "results",
    "RunError": "core.diagnostic",
    "RunStopped": "results",
    "Study": "study",
    "StudyInterrupted": "study",
    "UnknownName": "variables",
    "UsageError": "core.diagnostic",
    "grid": "design",
    "latin_hypercube": "design",
    "load": "model",
    "random": "design",
    "sweep": "study",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module `planarc` has no attribute `{name}`")
    value = getattr(import_module(f"planarc.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
