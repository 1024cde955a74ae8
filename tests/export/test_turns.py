"""Exported models with loops whose end is known only while they run: as planarc runs them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

import planarc
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.export.page.module import make_module
from planarc.request.request import Request
from tests.export.fmus import WAYS, runs_here, simulate, written
from tests.export.test_c import Run, misfit, needs_compiler, run  # noqa: F401
from tests.export.test_wasm import needs_node, of_node
from tests.lower.test_turns import ANOMALY, MEETING

ORBIT = """
model Orbit "A planet by Kepler's equation, and a mass that follows it"
  ANOMALY
  parameter Real e = 0.5;
  output Real E = anomaly(time, e);
  output Real rate = der(E);
  output Real x(start=0, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = 10*(cos(E) - e - x) - v + (if E > 2 then 1 else 0);
  annotation(experiment(StopTime=5, Interval=0.01));
end Orbit;
""".replace("ANOMALY", ANOMALY)


@cache
def compiled() -> Compiled:
    return compile_model(Request(Path("Orbit.pmo"), text=ORBIT))


@cache
def reference() -> planarc.Result:
    return planarc.load(ORBIT).simulate(5, intervals=100, tolerance=1e-11)


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", (2, 3))
def test_a_run_of_an_fmu_is_the_one_of_planarc(tmp_path: Path, way: str, version: int) -> None:
    table = simulate(written(tmp_path / "orbit.fmu", compiled(), version), way, 5.0)
    for name in ("E", "rate", "x"):
        there = [reference().at(name, t) for t in table["time"]]
        assert table[name] == pytest.approx(there, rel=1e-7, abs=1e-7), name


@needs_compiler
def test_a_run_of_c_is_the_one_of_planarc(run: Run, tmp_path: Path) -> None:  # noqa: F811
    model = planarc.load(ORBIT)
    assert misfit(model, run(model.export_c(tmp_path / "c")).stdout) < 1e-4


@needs_node
def test_a_page_runs_it(tmp_path: Path) -> None:
    slots = [compiled().program.slots[name] for name in ("e", "E", "x")]
    times = [0.05 * i for i in range(101)]
    orders = ([], times), ([[slots[0], 0.0]], times)
    plain, round_ = of_node(tmp_path, make_module(compiled()).code, slots, *orders)
    there = [reference().at("x", t) for t in times]
    assert plain["columns"][2] == pytest.approx(there, abs=1e-6)
    assert round_["columns"][1] == pytest.approx(times, abs=1e-12)


def test_what_turns_call_in_python_is_not_exported() -> None:
    """Machine code elsewhere has no Python to call back."""
    model = planarc.load(f"model M\n{MEETING}\noutput Real x[2] = meeting(time);\nend M;")
    with pytest.raises(planarc.PlanarcError, match="the function `planarc_solution`") as refused:
        model.export_c("nowhere")
    assert refused.value.diagnostics[0].code == "C300"
