"""Large systems: GMRES instead of elimination, and elimination again where it is stiff."""

from __future__ import annotations

import numpy as np
import pytest

from planarc import compiler
from planarc.core.options import RunOptions, Solver
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.solve.solvers import cvode

LINE = """model Line "A line of n stores of heat, one end warm, exchanging with their neighbours"
  parameter Integer n = 240;
  parameter Real k = {k};
  Real T[n](each start=0, each fixed=true);
equation
  der(T[1]) = k*(1 - 2*T[1] + T[2]);
  for i in 2:n - 1 loop
    der(T[i]) = k*(T[i - 1] - 2*T[i] + T[i + 1]);
  end for;
  der(T[n]) = k*(T[n - 1] - T[n]);
end Line;
"""


def run(k: float, solver: Solver = Solver.AUTO) -> Result:
    compiled = compiler.compile_model(Request(text=LINE.format(k=k)))
    return compiler.run(compiled, RunOptions(stop=1.0, intervals=10, tolerance=1e-8, solver=solver))


def exact(k: float, t: float, n: int = 240) -> np.ndarray:
    """1 - sum over the modes sin((j - 1/2) pi x/(n + 1/2)): closed form of the line."""
    modes = (np.arange(1, n + 1) - 0.5) * np.pi / (n + 0.5)
    x = np.arange(1, n + 1)
    shapes = np.sin(np.outer(x, modes))
    parts = shapes.T @ np.ones(n) / np.sum(shapes**2, axis=0)
    rates = 4 * k * np.sin(modes / 2) ** 2
    return 1 - shapes @ (parts * np.exp(-rates * t))


@pytest.mark.parametrize("solver", [Solver.AUTO, Solver.CVODE_ADAMS])
def test_a_line_of_stores_without_elimination(solver: Solver) -> None:
    result = run(5.0, solver)
    assert result.statistics.jacobians == 0
    assert "GMRES" in result.statistics.reason
    found = [result[f"T[{i}]"][-1] for i in range(1, 241)]
    assert np.max(np.abs(found - exact(5.0, 1.0))) < 1e-6


def test_a_stiff_line_goes_on_with_elimination() -> None:
    result = run(1e5)
    assert result.statistics.jacobians > 0
    found = [result[f"T[{i}]"][-1] for i in range(1, 241)]
    assert np.max(np.abs(found - exact(1e5, 1.0))) < 1e-6


def test_both_ways_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    by_gmres = run(50.0)
    monkeypatch.setattr(cvode, "LARGEST_DENSE", 1000)
    by_elimination = run(50.0)
    assert by_elimination.statistics.jacobians > 0
    for name in ("T[1]", "T[20]", "T[240]"):
        assert np.allclose(by_gmres[name], by_elimination[name], rtol=0, atol=1e-6)
