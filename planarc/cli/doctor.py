"""`planarc doctor`: what is installed, what will run, and a small self-test."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from planarc.cli import console
from planarc.cli.arguments import AsJson
from planarc.cli.exits import Exit
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions, Solver

NEEDED = (
    "lark",
    "msgspec",
    "numpy",
    "scipy",
    "typer",
    "rich",
    "platformdirs",
    "jinja2",
    "werkzeug",
)
#: The use of each package, and what happens without it.
CHOSEN = {
    "llvmlite": "native code; without it the numpy back end runs",
    "scikit-sundae": "the solver CVODE; without it scipy's LSODA runs",
    "matplotlib": "plots: install planarc[plot]",
    "pillow": "moving pictures: install planarc[pictures]",
    "imageio-ffmpeg": "films: install planarc[pictures]",
    "ipython": "notebooks: install planarc[notebook]",
    "pandas": "data frames: install planarc[tables]",
    "xarray": "labelled arrays: install planarc[tables]",
    "pygls": "the language server: install planarc[lsp]",
    "svgelements": "outlines from SVG: install planarc[cad]",
    "ezdxf": "outlines from DXF: install planarc[cad]",
    "distributed": "studies on a cluster: install dask[distributed]",
}

#: A swing of small amplitude, and its closed form: phi = phi0*cos(sqrt(g/L)*t).
_SELF_TEST = Path(__file__).with_name("self_test.pmo")


def doctor(as_json: AsJson = False) -> int:
    """Say what is installed and what will run, and test it.

    A pendulum is run with every back end and compared with its closed form.
    """
    from planarc.core import cache

    root = cache.folder()
    tests = tuple(_self_tests())
    healthy = all(_version(p) for p in NEEDED) and all(t["ok"] for t in tests)
    report: dict[str, Any] = {
        "ok": healthy,
        "planarc": _version("planarc"),
        "python": f"{platform.python_version()} on {platform.system()} {platform.machine()}",
        "packages": {p: _version(p) for p in (*NEEDED, *CHOSEN)},
        "cache": None if root is None else str(root),
        "self_test": tests,
    }
    if as_json:
        console.say(json.dumps(report))
    else:
        console.say_rows(tuple(_rows(report)))
    return Exit.DONE if healthy else Exit.RUN


def _version(package: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _self_tests() -> Iterator[dict[str, Any]]:
    native = _version("llvmlite") is not None
    for backend in (Backend.NATIVE, Backend.NUMPY) if native else (Backend.NUMPY,):
        try:
            error, solver = _swing(backend)
        except PlanarcError as problem:
            yield {"backend": backend.value, "ok": False, "solver": None,
                   "says": problem.diagnostics[0].message}  # fmt: skip
        else:
            yield {
                "backend": backend.value,
                "ok": error < 1e-4,
                "solver": solver,
                "says": f"a swing is off by {error:.1e} of its angle",
            }


def _swing(backend: Backend) -> tuple[float, str]:
    """The distance of the swing from its closed form, as a share, and the solver that ran."""
    from math import cos, pi, sqrt

    from planarc import compiler
    from planarc.request.request import Request

    compiled = compiler.compile_model(Request(_SELF_TEST), backend)
    result = compiler.run(compiled, RunOptions(backend=backend, solver=Solver.AUTO))
    g = abs(float(result["world.g"][0])) if "world.g" in result else 9.81
    start = float(result["hinge.phi"][0]) + pi / 2
    end = float(result["hinge.phi"][-1]) + pi / 2
    return abs(end - start * cos(sqrt(g))) / abs(start), result.statistics.solver


def _rows(report: dict[str, Any]) -> Iterator[tuple[str, str]]:
    yield "planarc", report["planarc"]
    yield "python", f"{report['python']}, {sys.executable}"
    for package in NEEDED:
        yield package, report["packages"][package] or "MISSING: install planarc again"
    for package, purpose in CHOSEN.items():
        installed = report["packages"][package]
        yield package, installed or f"not installed ({purpose})"
    yield "cache", report["cache"] or "none"
    first, *_ = report["self_test"]
    yield "will run", f"{first['solver']}, {first['backend']} back end"
    for test in report["self_test"]:
        verdict = "passed" if test["ok"] else "FAILED"
        yield "self-test", f"{test['backend']}: {verdict}, {test['says']}"
    yield "verdict", "all is well" if report["ok"] else "something is wrong, see above"
