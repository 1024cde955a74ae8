"""IDA: the residual form holds what the solved form computes, and events are the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.result import Result
from planarc.request.request import Request
from planarc.solve.solvers.sundials import Unavailable

CASES = Path(__file__).parents[2] / "cases"
FOUR_BAR = CASES / "b2_fourbar_gravity" / "four_bar.pmo"
BALL = CASES / "i1_bouncing_ball" / "bouncing_ball.pmo"
CHAIN = CASES / "h2_chain_pendulum_N10" / "chain_pendulum.pmo"


def run(model: Path, backend: Backend = Backend.NATIVE, **options: object) -> Result:
    compiled = compiler.compile_model(Request(model), backend)
    return compiler.run(compiled, RunOptions(backend=backend, **options))  # type: ignore[arg-type]


@pytest.mark.parametrize("backend", list(Backend))
@pytest.mark.parametrize("model", [FOUR_BAR, CHAIN], ids=lambda m: m.stem)
def test_residuals_vanish_where_blocks_are_solved(model: Path, backend: Backend) -> None:
    """And do not where an unknown is moved; rates agree with the solved form's."""
    compiled = compiler.compile_model(Request(model), backend)
    kernel = compiled.load()
    assert kernel.parameters() == 0
    states = [compiled.program.candidates[i] for i in kernel._selection]  # type: ignore[attr-defined]
    y, ydot = [float(kernel.w[c.start]) for c in states], [0.0] * len(states)
    assert kernel.rhs(0.0, y, ydot) == 0
    unknowns = kernel.unknowns()  # type: ignore[attr-defined]
    u = [float(kernel.w[s]) for s in unknowns.slots]
    assert len(u) == sum(count for _, count in unknowns.residuals) > 0
    flag, rates, residuals = kernel.residual_form(0.0, y, u, unknowns)  # type: ignore[attr-defined]
    assert flag == 0
    assert np.allclose(rates, ydot, rtol=1e-9, atol=1e-9)
    assert np.max(np.abs(residuals)) < 1e-9
    for k in range(len(u)):
        moved = list(u)
        moved[k] += 0.01
        _, _, residuals = kernel.residual_form(0.0, y, moved, unknowns)  # type: ignore[attr-defined]
        assert np.max(np.abs(residuals)) > 1e-6
    # The mode ends with the call: blocks are solved again.
    again = [0.0] * len(states)
    assert kernel.rhs(0.0, y, again) == 0
    assert np.allclose(again, ydot, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("backend", list(Backend))
def test_events_are_those_of_cvode(backend: Backend) -> None:
    ida = run(BALL, backend, solver=Solver.IDA, tolerance=1e-8)
    cvode = run(BALL, backend, tolerance=1e-8)
    assert ida.statistics.solver == "ida"
    assert [e.time for e in ida.events] == pytest.approx([e.time for e in cvode.events], abs=1e-6)
    assert ida.statistics.jacobians > 0


def test_the_error_falls_with_the_tolerance() -> None:
    exact = run(FOUR_BAR, stop=2.0, tolerance=1e-12)["revA.phi"]
    errors = [
        np.max(np.abs(run(FOUR_BAR, stop=2.0, tolerance=t, solver=Solver.IDA)["revA.phi"] - exact))
        for t in (1e-5, 1e-7, 1e-9)
    ]
    assert errors[0] > 5 * errors[1] > 25 * errors[2]
    assert errors[2] < 5e-6  # that of CVODE is of this size, too


def test_a_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise Unavailable("its wheel brings no IDA")

    monkeypatch.setattr("planarc.solve.solvers.ida.open_ida", missing)
    with pytest.raises(PlanarcError, match=r"R450.*`ida`.*brings no IDA"):
        run(FOUR_BAR, solver=Solver.IDA)


def test_a_point_that_cannot_be_passed_ends_the_run() -> None:
    """Towards the end of a root's domain steps become ever shorter: rows so far are kept."""
    text = "model M\n  Real x(start=0, fixed=true);\n  Real v(start=3, fixed=true);\n"
    text += "equation\n  der(x) = v;\n  der(v) = -sqrt(1 - x);\nend M;\n"
    compiled = compiler.compile_model(Request(text=text))
    result = compiler.run(compiled, RunOptions(stop=5.0, solver=Solver.IDA))
    assert result.ended is not None
    assert result.ended.code in ("R420", "R421")
    assert 0.3 < result.time[-1] < 0.36


def test_the_jacobian_comes_from_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same motion, with one evaluation a Jacobian instead of one an unknown."""
    for backend in Backend:
        options: dict[str, Any] = {"solver": Solver.IDA, "stop": 1.0, "tolerance": 1e-8}
        derived = run(CHAIN, backend, **options)
        with monkeypatch.context() as patch:
            patch.setattr("planarc.solve.solvers.ida.FEWEST_UNKNOWNS", 1000)
            differenced = run(CHAIN, backend, **options)
        name = derived.program.candidates[0].display
        assert np.max(np.abs(derived[name] - differenced[name])) < 1e-5
        jacobians = differenced.statistics.jacobians
        assert derived.statistics.jacobians > 0
        assert derived.statistics.rhs_calls < differenced.statistics.rhs_calls - 10 * jacobians


def test_where_a_formula_has_no_derivative_differences_are_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """sqrt(|x|) at x = 0, passed on the way."""
    monkeypatch.setattr("planarc.solve.solvers.ida.FEWEST_UNKNOWNS", 1)
    text = "model M Real x(start=1, fixed=true); Real v(start=0, fixed=true);"
    text += " equation der(x) = -2*time; der(v) = -v + sqrt(noEvent(abs(x)));\nend M;\n"
    compiled = compiler.compile_model(Request(text=text))
    result = compiler.run(compiled, RunOptions(stop=1.5, solver=Solver.IDA, tolerance=1e-7))
    assert result.ended is None
    assert result["x"][-1] == pytest.approx(1 - 1.5**2, abs=1e-6)
