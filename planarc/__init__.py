"""Planar mechanisms from a Modelica-like language: compile, simulate, analyse.

    import planarc

    model = planarc.load("four_bar.pmo")
    result = model.simulate(stop_time=10)
    result["revA.phi"]                  # a NumPy array over result.time

The names below are found when they are first used, so that the import costs nothing.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as `typing` has it, which takes 5 ms to import

if TYPE_CHECKING:
    from typing import Any

    from planarc.api.load import load
    from planarc.api.model import Model
    from planarc.api.read import read
    from planarc.api.result import Result, RunStopped
    from planarc.api.variant import Recompiled
    from planarc.core.diagnostic import Diagnostic, PlanarcError, RunError, UsageError
    from planarc.core.unknown import UnknownName
    from planarc.study.points import grid, latin_hypercube, random
    from planarc.study.sweep import Study, StudyInterrupted, sweep

    __version__: str

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
    "read",
    "sweep",
]

_HOMES = {
    name: module
    for module, names in {
        "core.diagnostic": "Diagnostic PlanarcError RunError UsageError",
        "core.unknown": "UnknownName",
        "core.version": "__version__",
        "api.load": "load",
        "api.model": "Model",
        "api.read": "read",
        "api.result": "Result RunStopped",
        "api.variant": "Recompiled",
        "study.points": "grid latin_hypercube random",
        "study.sweep": "Study StudyInterrupted sweep",
    }.items()
    for name in names.split()
}


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        # Tools ask any module for names with `_`; `from planarc import stages` asks here first.
        asked = not name.startswith("_") and not _is_room(name)
        hint = import_module("planarc.api.elsewhere").where(name, __all__) if asked else ""
        raise AttributeError(f"module `planarc` has no attribute `{name}`{hint}")
    value = getattr(import_module(f"planarc.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def _is_room(name: str) -> bool:
    from pathlib import Path

    return any(Path(__path__[0], name + ending).exists() for ending in ("", ".py"))


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
