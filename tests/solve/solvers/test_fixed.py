"""Steps of one length: orders of convergence, events at a step's end, refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.diagnostic import UsageError
from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.result import Result
from planarc.request.request import Request

OSCILLATOR = """model Oscillator
  Real x(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -x;
end Oscillator;
"""
BALL = """model Ball
  Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(v, -0.7*pre(v));
  end when;
end Ball;
"""
SWITCH = """model Switch
  Real x(start=0, fixed=true);
equation
  der(x) = if time >= 0.25 then 1 else 0;
end Switch;
"""


def run(text: str, backend: Backend = Backend.NATIVE, **options: Any) -> Result:
    compiled = compiler.compile_model(Request(text=text), backend)
    return compiler.run(compiled, RunOptions(backend=backend, **options))


@pytest.mark.parametrize("backend", list(Backend))
@pytest.mark.parametrize(("solver", "order"), [(Solver.EULER, 1), (Solver.RK4, 4)])
def test_the_error_falls_with_the_order(solver: Solver, order: int, backend: Backend) -> None:
    errors = []
    for step in (0.02, 0.01, 0.005):
        result = run(OSCILLATOR, backend, stop=2.0, intervals=10, solver=solver, fixed_step=step)
        errors.append(np.max(np.abs(result["x"] - np.cos(result.time))))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(order, abs=0.1)


def test_rows_between_steps_are_as_good_as_the_steps() -> None:
    """11 steps and 100 rows: the cubic between two steps is of the order of the method."""
    result = run(OSCILLATOR, stop=1.1, intervals=99, fixed_step=0.1)
    assert result.statistics.steps == 11
    assert len(result.time) == 100
    assert np.max(np.abs(result["x"] - np.cos(result.time))) < 5e-6


def test_back_ends_take_the_same_steps() -> None:
    native, numpy = (run(BALL, b, stop=1.0, fixed_step=1e-3) for b in Backend)
    assert np.allclose(native["h"], numpy["h"], rtol=0, atol=1e-13)
    assert native.statistics.steps == numpy.statistics.steps == 1000


def test_an_event_is_treated_at_the_end_of_its_step() -> None:
    impact = np.sqrt(2 / 9.81)
    for step in (1e-2, 1e-3):
        (event,) = run(BALL, stop=0.8, fixed_step=step).events
        assert impact <= event.time < impact + step
        assert event.time / step == pytest.approx(round(event.time / step), abs=1e-6)


def test_instants_known_beforehand_are_met_exactly() -> None:
    result = run(SWITCH, stop=1.0, fixed_step=0.1)
    assert result.events[0].time == 0.25
    assert result["x"][-1] == pytest.approx(0.75, abs=1e-14)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"solver": Solver.RK4}, "needs the length"),
        ({"solver": Solver.CVODE_BDF, "fixed_step": 1e-3}, "chooses its steps itself"),
        ({"fixed_step": 0.0}, "above 0 s"),
    ],
)
def test_a_method_without_its_step_is_refused(options: dict[str, Any], says: str) -> None:
    with pytest.raises(UsageError, match=rf"R407.*{says}"):
        run(OSCILLATOR, **options)


def test_a_step_that_is_too_long_ends_in_numbers_that_are_not_finite() -> None:
    text = OSCILLATOR.replace("der(v) = -x", "der(v) = -x*x*x")
    result = run(text, stop=1e4, solver=Solver.EULER, fixed_step=1.0)
    assert result.ended is not None
    assert result.ended.code == "R421"
    assert len(result.time) > 0
