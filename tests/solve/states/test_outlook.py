"""Looks at the choice of states come in time, and where one does not the run goes back."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.flat import StateSelect
from planarc.solve.simulate import simulate
from planarc.solve.solvers.watch import Watch

START = 0.4


def slider(tools: Any, tolerance: float, slide: StateSelect, solver: Solver) -> Any:
    """A crank-slider whose slider is the state as long as it can be one."""
    place = 0.3 * np.cos(START) + np.sqrt(1 - (0.3 * np.sin(START)) ** 2)
    crank = StateSelect.AVOID if slide is StateSelect.PREFER else StateSelect.PREFER
    program = tools.crank_slider(
        tools.Coordinate("crank.phi", START, fixed=True, speed=3.0, speed_fixed=True, select=crank),
        tools.Coordinate("slide.s", float(place), select=slide),
    ).program()
    options = RunOptions(backend=Backend.NUMPY, tolerance=tolerance, solver=solver)
    return simulate(program, tools.Interpreter(program), options)


def test_velocities_are_compared_group_by_group() -> None:
    watch = Watch([], 5)
    watch.speeds[:] = [0, 1, 2, 3, 4]
    watch.weights[:] = [-1.0, -2.0, 1.0, -1.0, 3.0]
    #      states of the first block: 1 and 2*0.5; what follows: 4. Second block: 2, and 3*1.
    assert watch.ratio([1.0, 0.5, 4.0, 2.0, 1.0]) == 4.0
    assert watch.ratio([1.0, 4.0, 4.0, 2.0, 1.0]) == 1.5
    assert watch.ratio([0.0, 0.0, 4.0, 2.0, 1.0]) == math.inf
    assert watch.ratio([0.0] * 5) == 0.0


def test_looks_come_soon_after_a_restart_and_then_ever_later() -> None:
    watch = Watch([0])
    watch.begin([0.0], 1.0)
    looks = [k for k in range(1, 200) if watch.moved([0.5])]
    assert looks == [2, 6, 14, 30, 62, 126, 190]
    watch.restart()
    assert [watch.moved([0.5]), watch.moved([0.5])] == [False, True]
    assert watch.moved([1.5])
    assert not any(Watch([]).moved([]) for _ in range(100))


@pytest.mark.parametrize("solver", [Solver.CVODE_BDF, Solver.CVODE_ADAMS, Solver.LSODA])
def test_the_error_falls_with_the_tolerance_past_dead_centres(tools: Any, solver: Solver) -> None:
    exact = slider(tools, 1e-12, StateSelect.DEFAULT, Solver.CVODE_BDF)["crank.phi"]
    errors = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        run = slider(tools, tolerance, StateSelect.PREFER, solver)
        assert len(run.states) > 1
        errors.append(float(np.max(np.abs(run["crank.phi"] - exact))))
    assert errors[1] < 0.5 * errors[0]
    assert errors[2] < 0.5 * errors[1]
    assert errors[2] < 1e-5


def test_a_look_that_came_too_late_is_made_good(
    tools: Any, made_late: Callable[[], list[tuple[float, float]]]
) -> None:
    """The run goes back to where the choice was good; no row is lost or taken twice."""
    plain = slider(tools, 1e-9, StateSelect.PREFER, Solver.CVODE_BDF)
    times = made_late()
    run = slider(tools, 1e-9, StateSelect.PREFER, Solver.CVODE_BDF)
    assert run.ended is None
    (there,) = times
    assert there[1] < there[0]
    assert [s.states for s in run.states] == [s.states for s in plain.states]
    assert run.time.tolist() == plain.time.tolist()
    assert np.max(np.abs(run["crank.phi"] - plain["crank.phi"])) < 1e-5
