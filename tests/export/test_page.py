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
from planarc.export.page.module import make_module
from planarc.export.page.page import make_page
from planarc.instance.ends import CROWDED
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.stages import study
from planarc.view.page.report import render_page
from planarc.view.scene import make_scene
from tests.export.test_events import BALL, TABLE
from tests.export.test_wasm import of_node

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


PUSH = """
model Push "A mass in oil"
  parameter Real d=4 "Damping";
  input Real u(unit="N", start=2) "Push";
  Real v(start=0, fixed=true) "Velocity";
equation
  der(v) = u - d*(v - cos(time)) - sin(time);
  annotation(experiment(StopTime=2));
end Push;
"""


def data_of(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


def fields_of(page: str) -> dict[str, dict[str, Any]]:
    groups = data_of(page)["model"]["groups"]
    return {f["name"]: f for g in groups for f in g["fields"]}


def test_inputs_have_fields(tmp_path: Path) -> None:
    """Those of the model, and those that are named."""
    path = planarc.load(PUSH).export_page(tmp_path / "push.html")
    field = fields_of(path.read_text("utf-8"))["u"]
    assert (field["value"], field["unit"], field["description"]) == (2.0, "N", "Push")
    swing = planarc.load(str(ROOT / "examples" / "pendulum.pmo"))
    assert "hinge.tau" not in fields_of(swing.export_page(tmp_path / "a").read_text("utf-8"))
    driven = swing.export_page(tmp_path / "b", inputs=["hinge.tau"])
    assert fields_of(driven.read_text("utf-8"))["hinge.tau"]["value"] == 0.0


SWITCHED = """
model Switched
  type Way = enumeration(back, forth);
  input Boolean on(start=true) "Whether it is pushed";
  input Integer n(start=2, min=0, max=5);
  input Way way(start=Way.forth);
  discrete input Real d(start=1);
  input Real u(start=1, max=9);
  Real x(start=1.1, fixed=true);
  Integer k(start=0, fixed=true);
  Boolean was = pre(on), both = on and n > 1;
equation
  der(x) = if on then n*u*d*(if way == Way.back then -1 else 1) else 0;
  when {x > 2, x < 0, initial()} then
    k = pre(k) + n;
  end when;
  annotation(experiment(StopTime=1));
end Switched;
"""


def test_inputs_that_are_no_reals_have_fields(tmp_path: Path) -> None:
    """As parameters of their types have them, with the limits of the model."""
    page = planarc.load(SWITCHED).export_page(tmp_path / "a.html").read_text("utf-8")
    (group,) = (g for g in data_of(page)["model"]["groups"] if g["title"] == "Inputs")
    told = {f["name"]: (f["kind"], f["value"], f["literals"]) for f in group["fields"]}
    assert told == {
        "u": ("Real", 1.0, []),
        "on": ("Boolean", 1.0, []),
        "n": ("Integer", 2.0, []),
        "way": ("enumeration", 2.0, ["back", "forth"]),
        "d": ("Real", 1.0, []),
    }
    limits = {f["name"]: (f["minimum"], f["maximum"]) for f in group["fields"]}
    assert limits["n"] == (0.0, 5.0) and limits["u"] == (None, 9.0)


@needs_node
@pytest.mark.parametrize(
    "given", [{}, {"on": 0}, {"n": 5, "way": 1}, {"d": 0.5, "n": 0}, {"on": 0, "way": 1, "u": 3}]
)
def test_inputs_that_are_no_reals_are_held(tmp_path: Path, given: dict[str, float]) -> None:
    """As if these values stood in the model."""
    model, text = planarc.load(SWITCHED).compiled(), SWITCHED
    for name, value in given.items():
        word = {"on": "false", "way": "Way.back"}.get(name, value)
        text = re.sub(rf" {name}\(start=[^,)]+", f" {name}(start={word}", text)
    assert given == {} or text != SWITCHED
    places = data_of(make_page(model, run(model, RunOptions())).text)["places"]
    slots = {c.name: c.slot for c in model.program.columns}
    seen = ["x", "k", "was", "both"]
    times = np.linspace(0.0, 1.0, 11)
    values = [(places[name][0], value) for name, value in given.items()]
    (told,) = of_node(
        tmp_path, make_module(model).code, [slots[n] for n in seen], (values, times.tolist())
    )
    result = planarc.load(text).simulate(interval=0.1, tolerance=1e-10)
    rows = np.searchsorted(result.time, times + 1e-9, side="right") - 1  # behind events
    for name, column in zip(seen, told["columns"], strict=True):
        assert column == pytest.approx(result[name][rows].astype(float), abs=1e-7), name


@needs_node
@pytest.mark.parametrize("stiffness", [4.0, 1e7])
def test_stiff_steps_follow_the_slow_part(tmp_path: Path, stiffness: float) -> None:
    """v = cos(t) + u/d, but for what dies out at once (A. Prothero, A. Robinson)."""
    model = planarc.load(PUSH).compiled()
    slots = {p.name: p.slot for p in model.program.parameter_slots}
    speed = next(c for c in model.program.columns if c.name == "v")
    times, push = np.linspace(0.0, 2.0, 41), 3 * stiffness
    given = [(slots["d"], stiffness), (model.program.slots["u"], push)]
    (told,) = of_node(
        tmp_path, make_module(model, stiff=True).code, [speed.slot], (given, times.tolist())
    )
    (found,) = np.array(told["columns"])
    wanted = np.cos(times) + 3 - 4 * np.exp(-stiffness * times)
    assert np.abs(found - wanted).max() < 1e-5


@needs_node
def test_a_table_whose_message_is_made_while_running_runs(tmp_path: Path) -> None:
    """Such a page did not even load its module. The table's area is 1 + 1.5 + 2.5."""
    model = planarc.load(TABLE).compiled()
    x = next(c.slot for c in model.program.columns if c.name == "x")
    (told,) = of_node(tmp_path, make_module(model).code, [x], ([], [0.0, 1.0, 2.0, 3.0]))
    assert told["columns"] == [pytest.approx([0.0, 1.0, 2.5, 5.0], abs=1e-9)]


@needs_node
def test_events_without_end_are_told_as_such(tmp_path: Path) -> None:
    """Bounces of a ball pile up where it comes to rest."""
    text = BALL.replace("e=0.8", "e=0.3").replace("StopTime=2", "StopTime=0.5")
    model = planarc.load(text).compiled()
    (told,) = of_node(
        tmp_path, make_module(model).code, [0], ([], np.linspace(0.0, 3.0, 31).tolist())
    )
    assert told["failed"] == -CROWDED
    page = planarc.load(text).export_page(tmp_path / "ball").read_text("utf-8")
    assert "events follow each other without end" in data_of(page)["told"][str(-CROWDED)]


def test_the_command_leaves_a_report_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A page that runs the model has another name than the page of a run."""
    from planarc.cli.app import run as command

    monkeypatch.chdir(tmp_path)
    (tmp_path / "Push.html").write_text("a report", "utf-8")
    Path("push.pmo").write_text(PUSH, "utf-8")
    capsys.readouterr()
    assert command(["export", "page", "push.pmo", "--stiff", "-q"]) == 0
    assert capsys.readouterr().out == ""
    assert Path("Push.html").read_text("utf-8") == "a report"
    assert "u" in fields_of(Path("Push_live.html").read_text("utf-8"))


def test_python_writes_it_and_refuses_what_it_cannot_hold(tmp_path: Path) -> None:
    model = planarc.load(str(ROOT / "examples" / "pendulum.pmo"))
    path = model.export_page(tmp_path / "swing")
    assert path == tmp_path / "swing.html"
    assert path.read_text("utf-8").startswith("<!doctype html>")
    text = """
model No
  String s;
equation
  when time > 1 then
    s = String(time);
  end when;
end No;
"""
    with pytest.raises(PlanarcError) as raised:
        planarc.load(text).export_page(tmp_path / "no.html")
    assert raised.value.diagnostics[0].code == "C300"
    assert not (tmp_path / "no.html").exists()
