"""A run that cannot go on says when, why and where, and keeps what it has."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import Severity
from planarc.core.options import Backend, RunOptions, Solver
from planarc.solve.simulate import simulate

SOLVERS = [Solver.CVODE_BDF, Solver.CVODE_ADAMS, Solver.LSODA, Solver.SCIPY_BDF]


def run(tools: Any, mechanism: Any, **options: Any) -> Any:
    program = mechanism.program()
    return simulate(
        program, tools.Interpreter(program), RunOptions(backend=Backend.NUMPY, **options)
    )


def free(tools: Any, force: Any, **changes: Any) -> Any:
    return tools.Mechanism(
        [tools.Coordinate("x", 1.0, written=True, speed=-1.0, speed_written=True)],
        mass=lambda t, q: [[t.one]],
        force=force,
        **changes,
    )


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_root_of_a_negative_number_stops_at_its_time(tools: Any, solver: Solver) -> None:
    """sqrt(0.5 - t) ends at t = 0.5."""
    mechanism = free(tools, lambda t, q, v: [t.call("sqrt", t.sub(t.const(0.5), t.time))])
    result = run(tools, mechanism, solver=solver)
    assert result.ended.severity is Severity.ERROR
    assert result.ended.code in ("R420", "R421")
    assert result.time[-1] == pytest.approx(0.5, abs=0.03)
    assert np.all(np.isfinite(result.data))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_blow_up_names_the_fastest_states(tools: Any, solver: Solver) -> None:
    """x'' = 6 x^2 with x = 1/(1-t)^2 has no value at t = 1."""
    mechanism = tools.Mechanism(
        [
            tools.Coordinate("slow"),
            tools.Coordinate("x", 1.0, speed=2.0),
        ],
        mass=lambda t, q: [[t.one, t.zero], [t.zero, t.one]],
        force=lambda t, q, v: [t.one, t.mul(t.const(6.0), q[1], q[1])],
        stop=2.0,
    )
    result = run(tools, mechanism, solver=solver)
    assert result.ended.code in ("R420", "R421")
    assert 0.9 < result.time[-1] < 1.01
    if result.ended.code == "R420":
        assert "x)`" in (result.ended.hint or "")
        assert "slow" not in (result.ended.hint or "").partition(" and ")[0]


def test_a_loop_that_comes_apart_names_its_equations(tools: Any) -> None:
    """The ground link grows until the rods do not reach."""

    def constraints(t: Any, q: list[Any]) -> list[Any]:
        ground = t.add(t.one, t.mul(t.const(0.5), t.time))
        x = t.sub(ground, t.mul(t.const(0.5), t.call("cos", q[0])))
        y = t.mul(t.const(0.5), t.call("sin", q[0]))
        return [t.add(t.mul(x, x), t.mul(y, y), t.const(-0.81)), t.sub(q[1], t.time)]

    mechanism = tools.Mechanism(
        [tools.Coordinate("crank.phi", 0.9), tools.Coordinate("drive.s")],
        mass=lambda t, q: [[t.one, t.zero], [t.zero, t.one]],
        force=lambda t, q, v: [t.zero, t.zero],
        constraints=constraints,
        components=("rod", "drive"),
        stop=2.0,
    )
    result = run(tools, mechanism)
    assert result.ended.code == "R422"
    assert "`rod`" in result.ended.message
    assert result.ended.span is not None
    assert result.ended.span.line == 10
    # The rods reach as far as 0.5 + 0.9.
    assert result.time[-1] == pytest.approx(0.8, abs=0.02)
    assert all(math.isfinite(v) for v in result["crank.phi"])


def test_a_singular_mass_is_told_at_the_start(tools: Any) -> None:
    from planarc.core.diagnostic import PlanarcError

    mechanism = tools.Mechanism(
        [tools.Coordinate("a.x"), tools.Coordinate("b.x")],
        mass=lambda t, q: [[t.one, t.one], [t.one, t.one]],
        force=lambda t, q, v: [t.one, t.zero],
    )
    with pytest.raises(PlanarcError, match="R410") as caught:
        run(tools, mechanism)
    assert "without mass" in (caught.value.diagnostics[0].hint or "")


def test_a_state_that_no_equation_names_is_shown_where_it_is_declared(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    fall = "model Fall Real r(start=1), v(start=0); equation der(r) = v; der(v) = -1/r^2; end Fall;"
    monkeypatch.setattr("planarc.solve.messages.trouble.determining", lambda *_: None)
    with pytest.raises(planarc.RunStopped, match=r"R420.*was worst\n.*<text>:1:\d"):
        planarc.load(fall).simulate(stop_time=3.0)
