"""The Jacobian of the right-hand side from formulas, held against differences and solvers."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.solve.opened import set_workspace
from planarc.solve.run import Run
from planarc.solve.settings import resolve
from planarc.solve.solvers import scipy as scipy_solvers

CASES = Path(__file__).parents[2] / "cases"
MODELS = [
    (folder / name, json.loads((folder / "case.json").read_text())["stop"])
    for folder in sorted(p.parent for p in CASES.glob("*/case.json"))
    for name in json.loads((folder / "case.json").read_text())["models"]
]


def run_until(request: Request, stop: float) -> Run:
    """A run with the NumPy back end, at its end."""
    compiled = compiler.compile_model(request, Backend.NUMPY)
    kernel = compiled.load()
    asked = resolve(compiled.program, RunOptions(stop=stop, intervals=10, backend=Backend.NUMPY))
    set_workspace(compiled.program, kernel, asked)
    run = Run(compiled.program, kernel, asked, "numpy")
    run.begin()
    run.go(None)
    return run


def differences(f: Callable[[Any], Any], y: Any) -> Any:
    """Central differences of fourth order: errors near 1e-11 of the largest entry."""
    columns = []
    for j in range(len(y)):
        h = 1e-3 * max(1.0, abs(y[j]))
        unit = h * np.eye(len(y))[j]
        columns.append(8 * (f(y + unit) - f(y - unit)) - f(y + 2 * unit) + f(y - 2 * unit))
        columns[-1] /= 12 * h
    return np.array(columns).T


def compare(run: Run) -> None:
    kernel, t, y = run.kernel, run.integrator.t, np.array(run.integrator.y)

    def f(at: Any) -> Any:
        ydot = [0.0] * len(at)
        assert kernel.rhs(t, at.tolist(), ydot) == 0
        return np.array(ydot)

    expected = differences(f, y)
    found = kernel.state_jacobian(t, y.tolist())  # type: ignore[attr-defined]
    assert np.max(np.abs(found - expected)) < 1e-6 * max(1.0, np.max(np.abs(expected)))


@pytest.mark.parametrize(("model", "stop"), MODELS, ids=lambda m: getattr(m, "stem", ""))
def test_formulas_agree_with_differences(model: Path, stop: float) -> None:
    """Through torn loops, linear blocks, elimination in a fixed order, and events."""
    compare(run_until(Request(model), 0.3 * stop))


def test_it_follows_the_choice_of_states() -> None:
    run = run_until(Request(CASES / "b1_crank_slider_gravity" / "crank_slider.pmo"), 0.5)
    before = run.kernel.state_jacobian(run.integrator.t, run.integrator.y)  # type: ignore[attr-defined]
    candidates = run.program.candidates
    other = [
        next(i for i, c in enumerate(candidates) if c.block == candidates[s].block and i != s)
        for s in run.states.selection
    ]
    run.kernel.accept(run.integrator.t)
    run.states.take(other)
    run.integrator.restart(run.integrator.t, run.states.values(), [1e-6] * len(other), ())
    compare(run)
    after = run.kernel.state_jacobian(run.integrator.t, run.integrator.y)  # type: ignore[attr-defined]
    assert not np.allclose(before, after, rtol=1e-3)


STIFF = """model Line
  parameter Real k = 1e5;
  Real T[12](each start=0, each fixed=true);
equation
  der(T[1]) = k*(1 - T[1]^3 + T[2] - T[1]);
  for i in 2:11 loop
    der(T[i]) = k*(T[i - 1] - 2*T[i] + T[i + 1]);
  end for;
  der(T[12]) = k*(T[11] - T[12]);
end Line;
"""


def run(text: str, solver: Solver, **options: Any) -> Result:
    compiled = compiler.compile_model(Request(text=text), Backend.NUMPY)
    asked = RunOptions(stop=1.0, backend=Backend.NUMPY, solver=solver, **options)
    return compiler.run(compiled, asked)


@pytest.mark.parametrize("solver", [Solver.SCIPY_BDF, Solver.LSODA, Solver.CVODE_BDF])
def test_solvers_take_it(solver: Solver, monkeypatch: pytest.MonkeyPatch) -> None:
    """A stiff line: the same answer with fewer right-hand sides than with differences."""
    derived = run(STIFF, solver)
    assert derived["T[12]"][-1] == pytest.approx(1.0, abs=1e-5)
    monkeypatch.setattr(scipy_solvers, "FEWEST_DERIVED", 1000)
    monkeypatch.setattr("planarc.solve.solvers.cvode.Cvode._jacobian_function", lambda self: None)
    by_differences = run(STIFF, solver)
    assert np.allclose(derived["T[6]"], by_differences["T[6]"], rtol=0, atol=1e-4)
    assert derived.statistics.jacobians > 0
    assert derived.statistics.rhs_calls < by_differences.statistics.rhs_calls - 12


def test_where_there_is_no_derivative_differences_are_taken() -> None:
    """sqrt(x) at x = 0."""
    text = STIFF.replace("T[11] - T[12])", "T[11] - T[12]) + sqrt(time*0 + abs(T[12]))*0.001")
    result = run(text, Solver.SCIPY_BDF)
    assert result.ended is None
    assert result["T[12]"][-1] == pytest.approx(1.0, abs=1e-4)
