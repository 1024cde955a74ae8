"""What the user asked for is checked before anything is computed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError, UsageError
from planarc.core.options import RunOptions
from planarc.ir.dae import Kind
from planarc.ir.flat import Experiment
from planarc.ir.program import Column, ParameterSlot, Program
from planarc.solve.settings import resolve
from planarc.solve.simulate import simulate


@pytest.fixture
def program(tools: Any) -> Program:
    made = tools.pendulum(
        parameters={"rod.L": 1.0, "rod.m": 2.0}, extra=lambda t: [("y", t.symbol("rev.phi"))]
    ).program()
    assert isinstance(made, Program)
    extra = (
        ParameterSlot("n", 3, Kind.INTEGER, True, True, default=2.0),
        ParameterSlot("rod.J", 3, Kind.REAL, False, False),
    )
    opposite = Column("frame.phi", made.slots["rev.phi"], -1, Kind.REAL)
    return replace(
        made,
        parameter_slots=made.parameter_slots + extra,
        columns=(*made.columns, opposite),
        experiment=Experiment(start=1.0, stop=3.0, interval=0.5, tolerance=1e-5),
    )


def test_the_experiment_gives_the_defaults(program: Program) -> None:
    request = resolve(program, RunOptions())
    assert request.grid.tolist() == [1.0, 1.5, 2.0, 2.5, 3.0]
    assert request.tolerance == 1e-5
    request = resolve(replace(program, experiment=Experiment()), RunOptions())
    assert len(request.grid) == 501
    assert (request.start, request.stop, request.tolerance) == (0.0, 1.0, 1e-6)


def test_options_replace_them(program: Program) -> None:
    request = resolve(program, RunOptions(start=0.0, stop=1.0, intervals=3, tolerance=1e-9))
    assert np.array_equal(request.grid, np.linspace(0, 1, 4))
    assert resolve(program, RunOptions(interval=0.75)).grid.tolist() == [1.0, 1.75, 2.5, 3.0]
    # An interval that divides the time but for rounding gives no row too many.
    assert len(resolve(program, RunOptions(start=0.0, stop=0.3, interval=0.1)).grid) == 4


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (RunOptions(stop=0.5), "R401.*before"),
        (RunOptions(stop=float("nan")), "R401"),
        (RunOptions(tolerance=0.0), "R402"),
        (RunOptions(tolerance=-1e-6), "R402"),
        (RunOptions(tolerance=float("nan")), "R402"),
        (RunOptions(interval=0.0), "R403"),
        (RunOptions(intervals=0), "R403"),
        (RunOptions(interval=0.1, intervals=3), "R403.*both"),
        (RunOptions(interval=1e-12), "R408.*too many"),
        (RunOptions(values={"rod.l": 1.0}), "R404.*no parameter"),
        (RunOptions(values={"rev.phi": 1.0}), "R404.*variable"),
        (RunOptions(values={"rod.L": float("inf")}), "R409.*finite"),
        (RunOptions(values={"n": 3.0}), "R405.*structural"),
        (RunOptions(values={"rod.J": 3.0}), "R405.*computed"),
        (RunOptions(starts={"rev.ph": 1.0}), "R406.*no variable"),
        (RunOptions(starts={"y": 1.0}), "R400.*follows from other"),
    ],
)
def test_what_cannot_be_is_refused(program: Program, options: RunOptions, reason: str) -> None:
    with pytest.raises(UsageError, match=f"(?s){reason}"):
        resolve(program, options)


def test_misspelt_names_get_the_nearest_ones(program: Program) -> None:
    with pytest.raises(UsageError) as caught:
        resolve(program, RunOptions(values={"rod.l": 1.0}))
    assert "`rod.L`" in (caught.value.diagnostics[0].hint or "")
    with pytest.raises(UsageError) as caught:
        resolve(program, RunOptions(values={"rev.phi": 1.0}))
    assert "rev.phi.start" in (caught.value.diagnostics[0].hint or "")


def test_a_start_value_passes_through_an_alias_with_its_sign(tools: Any) -> None:
    made = tools.pendulum().program()
    opposite = Column("frame.phi", made.slots["rev.phi"], -1, Kind.REAL)
    program = replace(made, columns=(*made.columns, opposite))
    result = simulate(
        program, tools.Interpreter(program), RunOptions(stop=0.0, starts={"frame.phi": 0.25})
    )
    assert result["rev.phi"][0] == -0.25
    assert result["frame.phi"][0] == 0.25


def test_parameters_reach_the_equations_and_the_result(tools: Any) -> None:
    mechanism = tools.Mechanism(
        [tools.Coordinate("x")],
        mass=lambda t, q: [[t.symbol("m")]],
        force=lambda t, q, v: [t.const(6.0)],
        parameters={"m": 2.0},
    )
    program = mechanism.program()
    for values, mass in (({}, 2.0), ({"m": 3.0}, 3.0), ({}, 2.0)):
        result = simulate(program, tools.Interpreter(program), RunOptions(values=values))
        assert result["x"][-1] == pytest.approx(3.0 / mass, abs=1e-5)
        assert result["m"].tolist() == [mass] * 501


def test_a_parameter_that_makes_nonsense_is_named(tools: Any) -> None:
    mechanism = tools.Mechanism(
        [tools.Coordinate("x")],
        mass=lambda t, q: [[t.symbol("m")]],
        force=lambda t, q, v: [t.const(6.0)],
        parameters={"m": 0.0},
    )
    program = mechanism.program()
    with pytest.raises(PlanarcError, match="R41"):
        simulate(program, tools.Interpreter(program), RunOptions())
