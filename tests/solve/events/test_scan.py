"""Relations of time alone: every switch of a fast one is met, in any solver's steps."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import planarc
from planarc.core.diagnostic import PlanarcError
from planarc.solve.events.scan import switches


@pytest.mark.parametrize("hertz", [0.3, 50.0, 512.0, 4096.0, 30_000.0])
def test_all_switches_of_a_sine_are_found(hertz: float) -> None:
    found = switches(lambda t: np.sin(2 * math.pi * hertz * t) < 0, 0.25, 1.25)
    assert found is not None
    first, last = math.floor(2 * hertz * 0.25) + 1, math.ceil(2 * hertz * 1.25) - 1
    exact = np.arange(first, last + 1) / (2 * hertz)
    inner = found[(found > 0.25 + 1e-12) & (found < 1.25 - 1e-12)]
    assert inner == pytest.approx(exact, abs=1e-14)


@pytest.mark.parametrize(
    "function", [lambda t: np.sin(1e9 * t), lambda t: np.sin(1 / t)], ids=["fast", "endless"]
)
def test_more_than_a_run_can_follow(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> None:
    assert switches(lambda t: function(t) < 0, 1e-30, 1.0) is None


@pytest.mark.parametrize("solver", ["cvode-bdf", "lsoda", "scipy-bdf"])
@pytest.mark.parametrize("condition", ["sin(2*pi*500*time) > 0.5", "s.y > 0.5"])
def test_a_fast_relation_switches_as_often_as_it_does(solver: str, condition: str) -> None:
    """A third of each period, 500 times."""
    model = planarc.load(
        f"""model M
  import Modelica.Constants.pi;
  Modelica.Blocks.Sources.Sine s(f=500);
  Real y(start=0, fixed=true);
  Integer n(start=0, fixed=true);
equation
  der(y) = if {condition} then 1 else 0;
  when {condition} then
    n = pre(n) + 1;
  end when;
end M;""",
        backend="numpy",
    )
    result = model.simulate(0.1, solver=solver)
    assert result["n"][-1] == 50
    assert result["y"][-1] == pytest.approx(0.1 / 3, abs=1e-9)


def test_a_variable_that_a_branch_of_time_decides() -> None:
    """`y` never comes to 1: its branch ends before."""
    model = planarc.load(
        """model M
  Real y = if time > 0.5 then 0 else time;
  Boolean b = y > 1, c = y > 0.25;
  Real x(start=0, fixed=true);
equation
  der(x) = if c then 1 else 0;
end M;""",
        backend="numpy",
    )
    result = model.simulate(2.0)
    assert not result["b"].any()
    assert result["x"][-1] == pytest.approx(0.25, abs=1e-9)
    assert [event.time for event in result.events] == pytest.approx([0.25, 0.5])


def test_too_many_switches_are_refused_with_their_line() -> None:
    model = planarc.load("model M\n  Boolean b = sin(1e9*time) > 0;\nend M;")
    with pytest.raises(PlanarcError, match="more than a million times") as caught:
        model.simulate(1.0)
    (found,) = caught.value.diagnostics
    assert (found.code, found.span and found.span.text) == ("R434", "sin(1e9*time) > 0")
