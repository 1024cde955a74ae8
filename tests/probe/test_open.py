"""A program put together at its start, for those who ask what its mechanism can do."""

from __future__ import annotations

import pytest

import planarc
from planarc.core.diagnostic import PlanarcError
from planarc.probe.open import open_program

FOUR_BAR = "examples/four_bar.pmo"


def test_the_kernel_is_left_at_a_consistent_start() -> None:
    program = planarc.load(FOUR_BAR).program
    opened = open_program(program)
    start = opened.start()
    off = [1.0] * sum(len(b.residuals) for b in program.blocks if b.height)
    assert opened.kernel.residuals(opened.t, start.values, off) == 0
    assert max(map(abs, off)) < 1e-9


def test_the_start_is_that_of_a_run() -> None:
    model = planarc.load(FOUR_BAR)
    result = model.simulate(0.1)
    opened = open_program(model.program)
    opened.start()
    for c in model.program.candidates:
        assert opened.kernel.w[c.slot] == pytest.approx(result[c.display][0], abs=1e-12)


def test_parameters_without_value_are_told_before_anything_is_solved() -> None:
    text = "model M parameter Real a = 0; parameter Real b = 1/a; Real x = b*time; end M;"
    with pytest.raises(PlanarcError, match="R414"):
        open_program(planarc.load(text).program)
