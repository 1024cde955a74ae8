"""The map: one door to a run, and a table that names what there is."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import compiler, remembered
from planarc.cli.app import run
from planarc.core.options import Backend, RunOptions
from planarc.live.session import Order, Session
from planarc.request.request import Request

#: `p` is the time of the start; the hinge is there to be driven.
MODEL = """
model Started
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0.1, fixed=true), w(fixed=true));
  PlanarMultiBody.Parts.Body bob(m=1, I=0.1, r_CM={1, 0});
  parameter Real p(fixed=false);
  parameter Real k=1;
  Real x(start=0, fixed=true);
initial equation
  p = time;
equation
  der(x) = k*p;
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bob.frame_a);
  annotation(experiment(StartTime={start}, StopTime=5.5));
end Started;
"""


@pytest.fixture(params=[5.0, 0.0], ids=["of the annotation", "of the call"])
def begun(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, float | None]:
    """A file whose runs begin at 5 s, and the start time that its caller has to give."""
    path = tmp_path / "started.pmo"
    path.write_text(MODEL.replace("{start}", str(request.param)))
    return path, None if request.param else 5.0


def last(values: Any) -> float:
    return float(np.atleast_1d(values)[-1])


def by_command(path: Path, start: float | None) -> float:
    table = path.with_suffix(".csv")
    begin = [] if start is None else ["--start", str(start)]
    options = ["--no-report", "-o", str(table), "--variables", "^p$"]
    assert run(["simulate", str(path), *begin, *options]) == 0
    return float(table.read_text().splitlines()[-1].split(",")[1])


def by_python(path: Path, start: float | None) -> float:
    return last(planarc.load(path).simulate(start_time=start)["p"])


def by_numpy(path: Path, start: float | None) -> float:
    return last(planarc.load(path, backend="numpy").simulate(start_time=start)["p"])


def by_the_compiler(path: Path, start: float | None) -> float:
    options = RunOptions(start=start, backend=Backend.NUMPY)
    return last(compiler.simulate(path, options=options)["p"])


def by_a_study(path: Path, start: float | None) -> float:
    points = {"k": [1.0, 2.0]}
    study = planarc.sweep(planarc.load(path), points, start_time=start, metric="p", workers=1)
    first, second = (float(row["p"]) for row in study)
    assert first == second
    return first


def by_drive(path: Path, start: float | None) -> float:
    model = planarc.load(path)
    return last(model.drive("hinge.phi", lambda t: 0.1 * t, start_time=start)["p"])


def by_sensitivities(path: Path, start: float | None) -> float:
    found = planarc.load(path).sensitivities(["k"], start_time=start)
    # x = k*p*(t - 5), so that dx/dk at 5.5 s is half of p
    return 2 * float(found["x", "k"][-1])


@pytest.mark.parametrize(
    "door",
    [
        by_command,
        by_python,
        by_numpy,
        by_the_compiler,
        by_a_study,
        by_drive,
        by_sensitivities,
    ],
)
def test_every_way_to_a_run_knows_its_start_time(
    door: Callable[[Path, float | None], float], begun: tuple[Path, float | None]
) -> None:
    assert door(*begun) == pytest.approx(5.0, rel=1e-9)


def test_the_live_page_begins_where_the_model_says(tmp_path: Path) -> None:
    path = tmp_path / "started.pmo"
    path.write_text(MODEL.replace("{start}", "5"))
    assert last(Session(Request(path), Backend.NATIVE).result(Order())["p"]) == 5.0


def test_the_map_names_files_that_are_there() -> None:
    package = Path(compiler.__file__).parent
    named = re.findall(r"[\w/]+\.py", compiler.__doc__ or "")
    assert len(named) > 10
    assert [name for name in named if not (package / name).is_file()] == []


def test_the_map_names_every_kind_of_entry_that_is_kept() -> None:
    package = Path(compiler.__file__).parent
    kept = re.compile(r"\b(?:cache|store|disk)\.store\(\s*\"(\w+)\"")
    kinds = {k for path in package.rglob("*.py") for k in kept.findall(path.read_text())}
    kinds |= set(remembered.KINDS)
    assert kinds <= set(re.findall(r"\w+", compiler.__doc__ or ""))
