"""What a model only warns of is told by its FMU, as often and in the words of a run."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from planarc.compiler import compile_model
from planarc.request.request import Request
from planarc.solve.settings import RunOptions
from planarc.solve.simulate import simulate
from tests.export.fmus import EXAMPLES, WAYS, runs_here, written

pytestmark = runs_here
#: Each condition is broken twice and more.
SWING = """
model Swing
  Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
  parameter Real low=-0.5;
  discrete Integer n(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -4*x;
  assert(x > low, "the mass is below " + String(low) + " m", AssertionLevel.warning);
  assert(x < 2, "the mass is high", AssertionLevel.warning);
  when x < 0.2 then
    n = pre(n) + 1;
    assert(n < 2, "it fell for the time " + String(n), AssertionLevel.warning);
    assert(v > -1, "it is fast", AssertionLevel.warning);
  end when;
  annotation(experiment(StopTime=10));
end Swing;
"""
#: Enough of them to be carried out; some are broken on the way, some always.
MANY = """
model Many
  Real x[12](each start=1, each fixed=true);
equation
  for i in 1:12 loop
    der(x[i]) = sin(i*x[mod(i, 12) + 1])*exp(-x[mod(i + 4, 12) + 1]^2*time);
  end for;
  for i in 1:40 loop
    assert(time < 10 + i, "never: " + String(i));
    assert(i*time < 15 and i <> 7, "late: " + String(i), AssertionLevel.warning);
  end for;
end Many;
"""


class Log(list[tuple[int, str, str]]):
    """What a logger was told: status, category, message."""

    def of(self, version: int) -> Callable[..., None]:
        return lambda *a: self.append((a[-3], a[-2].decode(), a[-1].decode()))


def run(path: Path, version: int, way: str = "CoSimulation", **more: object) -> Log:
    log = Log()
    options = {"output_interval": 0.01, "stop_time": 10.0, "relative_tolerance": 1e-8, **more}
    fmpy.simulate_fmu(path, fmi_type=way, logger=log.of(version), **options)
    return log


@pytest.mark.parametrize("version", (2, 3))
@pytest.mark.parametrize("way", WAYS)
def test_warnings_are_those_of_a_run(folder: Path, version: int, way: str) -> None:
    compiled = compile_model(Request(text=SWING))
    path = written(folder / f"swing{version}.fmu", compiled, version)
    assert validate_fmu(path) == []
    usual = simulate(compiled.program, compiled.load(), RunOptions(intervals=1000, tolerance=1e-8))
    wanted = [re.sub(r" \(\d+ times, .*\)", "", d.message) for d in usual.warnings]
    assert len(wanted) == 6
    log = run(path, version, way)
    assert {told[:2] for told in log} == {(1, "logStatusWarning")}
    assert sorted(text for *_, text in log) == sorted(wanted)


def test_each_run_warns_anew(folder: Path) -> None:
    path = written(folder / "swing3.fmu", compile_model(Request(text=SWING)), 3)
    log, told = Log(), fmpy.read_model_description(path)
    place = fmpy.extract(path)
    instance = fmpy.instantiate_fmu(place, told, "CoSimulation", logger=log.of(3))
    for _ in range(2):
        fmpy.simulate_fmu(place, fmu_instance=instance, model_description=told, stop_time=10.0,
                          output_interval=0.01, terminate=False)  # fmt: skip
        instance.reset()
    instance.freeInstance()
    half = len(log) // 2
    assert half == 6 and log[:half] == log[half:]


def test_a_library_warns_of_what_a_host_sets(folder: Path) -> None:
    path = written(folder / "hung.fmu", compile_model(Request(EXAMPLES / "pendulum.pmo")), 3)
    assert run(path, 3, stop_time=0.1) == []
    log = run(path, 3, stop_time=0.1, start_values={"world.g": 9810.0})
    assert [told[:2] for told in log] == [(1, "logStatusWarning")]
    assert "gravity of 9810 m/s2 crushes any part" in log[0][2]


def test_many_are_carried_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model, logs = compile_model(Request(text=MANY)), []
    for least in (1, 1 << 30):
        monkeypatch.setattr("planarc.instance.actions.SHORTEST_SELDOM", least)
        monkeypatch.setattr("planarc.export.module._LARGE", 0)
        path = written(tmp_path / f"{least}.fmu", model, 3)
        logs.append(run(path, 3, stop_time=1.0))
    assert logs[0] == logs[1]
    numbers = [int(text.split()[-1]) for *_, text in logs[0]]
    assert sorted(numbers) == [7, *range(15, 41)]
    assert logs[0][0][2].startswith("assertion failed at t = 0 s: late: 7")
