"""Crossings within long steps of an exported model: they fall where closed forms say."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions, Solver
from planarc.instance.plan import Swing, swings
from planarc.ir.result import Result
from planarc.request.request import Request
from tests.export.fmus import runs_here, simulate, written

EXAMPLES = Path(__file__).parents[2] / "examples"
SOLVERS = (Solver.EXPORTED, Solver.EXPORTED_STIFF)
MODEL = """
model Counts "Truths that come and go"
  output Integer n(start=0, fixed=true);
  Real x(start=0, fixed=true);
  {declared}
equation
  der(x) = {slope};
  when change(b) then
    n = pre(n) + 1;
  end when;
  annotation(experiment(StopTime={stop}));
end Counts;
"""


@cache
def compiled(declared: str, slope: str = "0.5", stop: float = 3.0) -> Compiled:
    text = MODEL.format(declared=declared, slope=slope, stop=stop)
    return compile_model(Request(Path("Counts.pmo"), text=text))


def followed(solver: Solver, *told: object) -> Result:
    return run(compiled(*told), RunOptions(solver=solver, tolerance=1e-9))  # type: ignore[arg-type]


def switches(function: Callable[[np.ndarray], np.ndarray], stop: float) -> np.ndarray:
    """Where a function of time changes its sign, to 1e-6 s."""
    t = np.linspace(0.0, stop, round(stop * 1e6))
    positive = function(t) > 0
    return t[1:][positive[1:] != positive[:-1]]


def check(result: Result, expected: np.ndarray, within: float = 2e-6) -> None:
    times = np.array([e.time for e in result.events if e.time > 0])
    assert len(times) == len(expected)
    assert np.abs(times - expected).max() < within
    assert result["n"][-1] == len(expected)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("level", (0.3, 0.9999))
def test_what_hangs_on_time_alone(solver: Solver, level: float) -> None:
    result = followed(solver, f"Boolean b = sin(300*time) > {level};")
    check(result, switches(lambda t: np.sin(300 * t) - level, 3.0))


@pytest.mark.parametrize("solver", SOLVERS)
def test_what_hangs_on_time_by_way_of_a_variable(solver: Solver) -> None:
    result = followed(solver, "Real y = cos(300*time); Boolean b = y > 0.9999;")
    check(result, switches(lambda t: np.cos(300 * t) - 0.9999, 3.0))


@pytest.mark.parametrize("solver", SOLVERS)
def test_events_are_those_of_planarcs_own_run(solver: Solver) -> None:
    told = ("Boolean b = sin(3000*time) > 0.3;", "0.001*x")
    own, other = followed(Solver.AUTO, *told), followed(solver, *told)
    times, expected = ([e.time for e in result.events] for result in (other, own))
    assert len(expected) > 2800
    assert times == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("level", (0.3, 0.9999))
def test_a_sine_of_a_state(solver: Solver, level: float) -> None:
    result = followed(solver, f"Boolean b = sin(600*x) > {level};")
    check(result, switches(lambda t: np.sin(300 * t) - level, 3.0))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_pulse_that_comes_late(solver: Solver) -> None:
    """Steps have grown as long as they may be."""
    result = followed(solver, "Boolean b = exp(-((time - 2.003)/0.005)^2) > 0.5;")
    half = 0.005 * np.sqrt(np.log(2))
    check(result, np.array([2.003 - half, 2.003 + half]))


@pytest.mark.parametrize("solver", SOLVERS)
def test_short_pulses_of_a_swing_are_found_each(solver: Solver) -> None:
    """Steps grow behind each of them beyond the next one."""
    result = followed(solver, "Boolean b = sin(40*x) > 0.99999;", "0.5", 5.0)
    check(result, switches(lambda t: np.sin(20 * t) - 0.99999, 5.0), 1e-5)


@pytest.mark.parametrize("solver", SOLVERS)
def test_short_pulses_right_before_what_else_crosses(solver: Solver) -> None:
    """What crosses first in a step is not always what the first look lies behind."""
    told = "Boolean b = sin(300*time) > 0.3; Boolean d = sin(600*x) > 0.999;"
    result = followed(solver, told, "0.5*(1 + 0.1*sin(time))")

    def d(t: np.ndarray) -> np.ndarray:
        return np.sin(300 * (t + 0.1 * (1 - np.cos(t)))) - 0.999

    times = np.array([e.time for e in result.events])
    for function in (d, lambda t: np.sin(300 * t) - 0.3):
        for t in switches(function, 3.0):
            assert np.abs(times - t).min() < 2e-6


@runs_here
def test_an_fmu_sees_what_its_long_steps_pass(tmp_path: Path) -> None:
    path = written(tmp_path / "Counts.fmu", compiled("Boolean b = sin(300*time) > 0.3;"), 3)
    table = simulate(path, "CoSimulation", 3.0, output_interval=1.0)
    expected = switches(lambda t: np.sin(300 * t) - 0.3, 3.0)
    assert table["n"].tolist() == [np.sum(expected < t) for t in (0.0, 1.0, 2.0, 3.0)]


@pytest.mark.parametrize("name", ("four_bar", "ratchet_and_pawl", "gripper", "cam_lift_off"))
def test_mechanisms_take_no_looks(name: str) -> None:
    """What it costs to look within steps, only models with relations that swing pay."""
    program = compile_model(Request(EXAMPLES / f"{name}.pmo")).program
    assert swings(program) is Swing.NOTHING


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        ("time > 2", Swing.NOTHING),
        ("2*(time - 1)/3 + 1 > time", Swing.NOTHING),
        ("time^2 > 2", Swing.TIME),
        ("1/time > 2", Swing.TIME),
        ("sin(time) > 0.5", Swing.TIME),
        ("sin(x) > 0.5", Swing.STATES),
        ("x > 0.5", Swing.NOTHING),
    ],
)
def test_what_swings_is_told_by_its_formula(condition: str, expected: Swing) -> None:
    assert swings(compiled(f"Boolean b = {condition};").program) is expected
