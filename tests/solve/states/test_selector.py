"""The choice of states, and its change while running."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions, Solver
from planarc.ir.flat import StateSelect
from planarc.solve.simulate import simulate

START = 0.4


def run(tools: Any, mechanism: Any, **options: Any) -> Any:
    program = mechanism.program()
    options.setdefault("tolerance", 1e-8)
    return simulate(
        program, tools.Interpreter(program), RunOptions(backend=Backend.NUMPY, **options)
    )


def slider(tools: Any, crank: StateSelect, slide: StateSelect, **more: Any) -> Any:
    place = 0.3 * np.cos(START) + np.sqrt(1 - (0.3 * np.sin(START)) ** 2)
    return tools.crank_slider(
        tools.Coordinate("crank.phi", START, fixed=True, speed=3.0, speed_fixed=True, select=crank),
        tools.Coordinate("slide.s", float(place), select=slide, **more),
    )


def energy(result: Any) -> np.ndarray:
    return 0.5 * result["der(crank.phi)"] ** 2 + 0.05 * result["der(slide.s)"] ** 2


def test_the_preferred_coordinate_is_the_state(tools: Any) -> None:
    result = run(tools, slider(tools, StateSelect.PREFER, StateSelect.DEFAULT))
    assert [c.states for c in result.states] == [("crank.phi", "der(crank.phi)")]
    assert result["crank.phi"][-1] > 12


@pytest.mark.parametrize("solver", [Solver.CVODE_BDF, Solver.LSODA])
def test_dead_centres_are_passed_by_choosing_again(tools: Any, solver: Solver) -> None:
    """The slider is preferred, and gives way near each dead centre if it must."""
    plain = run(tools, slider(tools, StateSelect.PREFER, StateSelect.DEFAULT), tolerance=1e-11)
    result = run(tools, slider(tools, StateSelect.AVOID, StateSelect.PREFER), solver=solver)
    assert result.ended is None
    assert result.states[0].states == ("slide.s", "der(slide.s)")
    assert result.states[1].states == ("crank.phi", "der(crank.phi)")
    assert len(result.states) < 6  # no thrashing
    assert np.max(np.abs(result["crank.phi"] - plain["crank.phi"])) < 2e-5
    assert np.ptp(energy(result)) < 2e-5


def test_the_loop_stays_closed(tools: Any) -> None:
    result = run(tools, slider(tools, StateSelect.AVOID, StateSelect.PREFER), tolerance=1e-5)
    x = result["slide.s"] - 0.3 * np.cos(result["crank.phi"])
    gap = x**2 + (0.3 * np.sin(result["crank.phi"])) ** 2 - 1
    assert np.max(np.abs(gap)) < 1e-9


def test_a_state_that_must_stay_ends_the_run_with_the_reason(tools: Any) -> None:
    result = run(tools, slider(tools, StateSelect.PREFER, StateSelect.ALWAYS))
    assert result.ended is not None
    assert result.ended.code == "R423"
    assert "`slide.s`" in result.ended.message
    assert "`crank.phi`" in result.ended.message
    assert "dead centre" in result.ended.message
    # The first dead centre of the turn is at phi = pi.
    assert result["crank.phi"][-1] == pytest.approx(np.pi, abs=0.1)


def test_two_states_that_must_stay_but_depend_on_each_other_are_refused(tools: Any) -> None:
    with pytest.raises(PlanarcError, match=r"R423.*`crank.phi` and `slide.s` cannot all be states"):
        run(tools, slider(tools, StateSelect.ALWAYS, StateSelect.ALWAYS))


HANGING = """
model Hanging "A pendulum that hangs straight down, but for the last digits of x"
  Real x(start=1e-17), y(start=-1, stateSelect=StateSelect.prefer);
  Real u(start=1, fixed=true) = der(x);
  Real v = der(y);
  Real f;
equation
  x^2 + y^2 = 1;
  der(u) = f*x;
  der(v) = f*y - 9.81;
end Hanging;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_what_only_rounding_moves_is_not_determined(backend: str) -> None:
    result = planarc.load(HANGING, backend=backend).simulate(3.0, tolerance=1e-8)
    assert result.ended is None
    energy = 0.5 * (result["u"] ** 2 + result["v"] ** 2) + 9.81 * result["y"]
    assert np.ptp(energy) < 1e-5
    assert np.max(result["x"]) > 0.3


def test_a_rocker_as_state_turns_into_the_crank(tools: Any) -> None:
    """The rocker swings between two extremes, where it cannot be the state."""
    avoid = StateSelect.AVOID

    def bars(a: StateSelect, d: StateSelect) -> Any:
        return tools.four_bar(
            [
                tools.Coordinate(
                    "revA.phi", 1.0, fixed=True, speed=-8.0, speed_fixed=True, select=a
                ),
                tools.Coordinate("revB.phi", 0.5, select=avoid),
                tools.Coordinate("revD.phi", 1.6, select=d),
            ]
        )

    crank = run(tools, bars(StateSelect.PREFER, avoid))
    rocker = run(tools, bars(avoid, StateSelect.PREFER))
    assert rocker.ended is None
    assert len(rocker.states) > 1
    assert np.max(np.abs(crank["revA.phi"] - rocker["revA.phi"])) < 2e-4


def test_the_flat_position_of_a_parallelogram_is_stepped_over(tools: Any) -> None:
    """All choices are singular twice a turn, at isolated points: no choice is better."""
    bars = tools.four_bar(
        [
            tools.Coordinate("revA.phi", 1.0, fixed=True, speed=-14.0, speed_fixed=True),
            tools.Coordinate("revB.phi", 0.0),
            tools.Coordinate("revD.phi", 1.0),
        ],
        lengths=(0.5, 1.0, 0.5, 1.0),
    )
    result = run(tools, bars, stop=1.0)
    assert result.ended is None
    assert abs(result["revA.phi"][-1]) > 2 * np.pi
    assert np.max(np.abs(result["revB.phi"])) < 1e-6  # it stays a parallelogram
    assert len(result.states) < 10
