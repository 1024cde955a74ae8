"""A page that runs its model itself: what it shows is what planarc shows of the same run."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import RunOptions
from planarc.evaluate.record import ENTRIES, Tape
from planarc.export.page.drawing import Drawing, draw
from planarc.export.page.page import make_page
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.stages import study
from planarc.view.page.report import render_page
from planarc.view.scene import make_scene

ROOT = Path(__file__).parents[2]
RECORD = ROOT / "planarc" / "export" / "page" / "record.js"
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="there is no node here")

#: Replays steps from standard input; what has rows becomes a list.
DRIVER = """
const { readFileSync } = require("fs");
const planarc = {};
eval(readFileSync(process.argv[1], "utf-8"));
const { steps, time, columns } = JSON.parse(readFileSync(0, "utf-8"));
const rows = (numbers) => Float64Array.from(numbers, (x) => (x === null ? NaN : x));
const found = planarc.replay(steps, { time: rows(time), column: (slot) => rows(columns[slot]) });
console.log(JSON.stringify(found.map((v) => (typeof v === "number" ? v : Array.from(v)))));
"""


ECHO = """
model Echo
  Real x(start=1, fixed=true);
equation
  der(x) = -delay(x, 0.5);
end Echo;
"""


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(ROOT / "examples" / f"{name}.pmo"))


def replayed(
    steps: list[list[Any]], time: list[float], columns: dict[int, list[float]]
) -> list[Any]:
    text = json.dumps({"steps": steps, "time": time, "columns": columns})
    done = subprocess.run(
        [str(NODE), "-e", DRIVER, str(RECORD)],
        input=text,
        capture_output=True,
        text=True,
        check=True,
    )
    found: list[Any] = json.loads(done.stdout)
    return found


def filled(drawing: Drawing, result: Result) -> dict[str, Any]:
    """The drawing with the rows of a run in its holes."""
    columns = {
        slot: [float(v) for v in np.broadcast_to(result.of_slot(slot), result.time.shape)]
        for slot in drawing.slots
    }
    values = replayed(drawing.steps, [float(t) for t in result.time], columns)
    data: dict[str, Any] = json.loads(json.dumps(drawing.data))
    for path, step in drawing.holes:
        inside: Any = data
        for key in path[:-1]:
            inside = inside[key]
        inside[path[-1]] = values[step]
    return data


def assert_same_motion(data: dict[str, Any], result: Result) -> None:
    """Every item is where the scene of the run has it."""
    items = {(i.component, n): i for n, i in enumerate(make_scene(result).items)}
    drawn = {(i["component"], n): i for n, i in enumerate(data["scene"]["items"])}
    assert items.keys() == drawn.keys()
    tracks = data["scene"]["tracks"]
    for key, item in items.items():
        for name in ("x", "y", "angle", "length"):
            told, wanted = drawn[key][name], getattr(item, name)
            values = tracks[told[0]] if isinstance(told, list) else told
            assert np.allclose(values, wanted, rtol=1e-6, atol=1e-9), (key, name)


@needs_node
@pytest.mark.parametrize("name", ["four_bar", "crank_slider", "pendulum", "walking_leg"])
def test_the_page_draws_what_the_report_draws(name: str) -> None:
    result = run(compiled(name), RunOptions(stop=1.0))
    assert_same_motion(filled(draw(result), result), result)


@needs_node
def test_another_run_is_drawn_by_the_steps_of_the_first() -> None:
    model = compiled("crank_slider")
    first = run(model, RunOptions(stop=1.0))
    length = next(
        p for p in model.program.parameter_slots
        if p.name.endswith(".r[1]") and p.settable and first.constants[p.slot] > 0.1
    )  # fmt: skip
    longer = 1.1 * first.constants[length.slot]
    other = run(model, RunOptions(stop=1.5, values={length.name: longer}))
    data = filled(draw(first), other)
    items, scene = data["scene"]["items"], make_scene(other)
    tracks = data["scene"]["tracks"]
    for told, item in zip(items, scene.items, strict=True):
        assert told["component"] == item.component
        for name in ("x", "y", "angle"):
            values = tracks[told[name][0]] if isinstance(told[name], list) else told[name]
            slack = 1e-9 if item.shape != "guide" else 1.0  # its margin is that of the first run
            assert np.allclose(values, getattr(item, name), rtol=1e-6, atol=slack)
    assert np.allclose(data["scene"]["box"], scene.box or (), rtol=0.1)


@needs_node
def test_energies_of_another_run() -> None:
    """Integrals and rates, too, are made again."""
    model = compiled("double_pendulum")
    first = run(model, RunOptions(stop=1.0))
    data = filled(draw(first), run(model, RunOptions(stop=2.0)))
    wanted = draw(run(model, RunOptions(stop=2.0)))
    again = filled(wanted, run(model, RunOptions(stop=2.0)))
    energies = [v for v in data["curves"]["variables"] if v[3] == "J"]
    assert len(energies) >= 2
    for name, column, *_ in energies:
        other = next(v for v in again["curves"]["variables"] if v[0] == name)
        assert data["curves"]["columns"][column] == again["curves"]["columns"][other[1]]


#: Each function of entries on a row of numbers, NumPy's beside JavaScript's.
@needs_node
@pytest.mark.parametrize("name", sorted(ENTRIES))
def test_functions_are_those_of_numpy(name: str) -> None:
    function = getattr(np, name)
    a = np.array([-2.5, -1.0, -0.3, 0.0, 0.3, 0.7, 1.0, 3.2])
    b = np.array([1.5, -2.0, 0.3, 1.0, 0.3, -0.7, 2.0, 0.5])
    tape = Tape()
    given = [tape.rows(a, "column", 0), tape.rows(b, "column", 1)][: function.nin]
    with np.errstate(all="ignore"):
        value = function(*given)
    steps, (place,) = tape.recipe([value.step])
    told = replayed(steps, [0.0] * 8, {0: a.tolist(), 1: b.tolist()})[place]
    found = np.array([np.nan if x is None else x for x in told])
    finite = np.isfinite(np.asarray(value))
    assert np.allclose(found[finite], np.asarray(value)[finite], rtol=1e-14, atol=0.0)


def test_nothing_is_fetched_and_no_more_than_150_kb_is_added() -> None:
    model = compiled("four_bar")
    result = run(model, RunOptions())
    page = make_page(model, result)
    report = render_page(result, make_scene(result), insight=study(result))
    addresses = set(re.findall(r"https?://[^\s\"'<>)]+", page.text))
    assert all(a.startswith(("http://www.w3.org/", "https://github.com/")) for a in addresses)
    assert page.fields > 20
    assert len(page.text) < len(report) + 150_000


def test_the_same_model_gives_the_same_page() -> None:
    model = compiled("pendulum")
    result = run(model, RunOptions())
    assert make_page(model, result) == make_page(model, result)


def test_python_writes_it_and_refuses_delays(tmp_path: Path) -> None:
    model = planarc.load(str(ROOT / "examples" / "pendulum.pmo"))
    path = model.export_page(tmp_path / "swing")
    assert path == tmp_path / "swing.html"
    assert path.read_text("utf-8").startswith("<!doctype html>")
    with pytest.raises(PlanarcError) as raised:
        planarc.load(ECHO).export_page(tmp_path / "no.html")
    assert raised.value.diagnostics[0].code == "C300"
    assert not (tmp_path / "no.html").exists()
