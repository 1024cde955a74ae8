"""States that stay below the errors of steps are told, where their size is meant."""

from __future__ import annotations

import math
from typing import Any

import pytest

import planarc

SWING = """model Swing
  Real x(start={start}, fixed=true{more});
  Real v(start=0, fixed=true);
equation
  der(x) = v;
  der(v) = -4*x;
end Swing;"""


def swing(start: float, more: str = "", **options: Any) -> planarc.Result:
    return planarc.load(SWING.format(start=start, more=more)).simulate(5, **options)


def told(run: planarc.Result) -> list[str]:
    return [w.code for w in run.warnings]


@pytest.mark.parametrize("start", [1e-9, -1e-9, 1e-6])
def test_a_swing_below_the_tolerance_is_told_and_the_hint_helps(start: float) -> None:
    assert told(swing(start)) == ["R458"]
    for run in (swing(start, f", nominal={abs(start)}"), swing(start, tolerance=1e-4 * abs(start))):
        assert told(run) == []
        assert run["x"][-1] == pytest.approx(start * math.cos(10), rel=1e-2)


@pytest.mark.parametrize("start", [0, 1, 1e-3])
def test_what_is_large_or_was_not_to_move_is_not_told(start: float) -> None:
    assert told(swing(start)) == []


def test_a_start_that_grows_is_not_told() -> None:
    model = planarc.load("model G Real x(start=1e-8, fixed=true); equation der(x) = 4*x; end G;")
    assert told(model.simulate(5)) == []


def test_fixed_steps_are_held_to_no_tolerance() -> None:
    assert told(swing(1e-9, solver="rk4", fixed_step=1e-3)) == []
