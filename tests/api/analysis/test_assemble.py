"""All assemblies of a mechanism."""

from __future__ import annotations

import math

import pytest

from planarc import Model, PlanarcError, UsageError


def test_a_four_bar_has_two(four_bar: Model) -> None:
    first, second = four_bar.assemble()
    assert first["revA.phi"] == second["revA.phi"] == 1.0
    assert first["revB.phi"] == pytest.approx(four_bar.simulate(0)["revB.phi"][0])
    # C lies on both sides of the line from B to D, which has this direction.
    b = (0.4 * math.cos(1), 0.4 * math.sin(1))
    line = math.atan2(-b[1], 1 - b[0])
    turned = [1 + a["revB.phi"] - line for a in (first, second)]
    assert math.remainder(turned[0] + turned[1], 2 * math.pi) == pytest.approx(0, abs=1e-9)
    for assembly in (first, second):
        result = four_bar.simulate(0, start=assembly.start)
        assert result["revB.phi"][0] == pytest.approx(assembly["revB.phi"], abs=1e-9)


def test_a_slider_is_on_the_left_or_on_the_right(slider: Model) -> None:
    found = slider.assemble(start={"main.phi": -0.5})
    y, base = 0.2 * math.sin(-0.5), 0.2 * math.cos(-0.5)
    exact = [base + math.sqrt(0.49 - y * y), base - math.sqrt(0.49 - y * y)]
    assert [a["slide.s"] for a in found] == pytest.approx(exact)


def test_what_does_not_close_is_said(four_bar: Model) -> None:
    with pytest.raises(PlanarcError, match="no way to put"):
        four_bar.assemble(parameters={"coupler.r": [0.01, 0]}, tries=20)
    with pytest.raises(UsageError, match="above 0"):
        four_bar.assemble(tries=0)


def test_an_open_chain_is_assembled_as_it_starts(pendulum: Model) -> None:
    (only,) = pendulum.assemble()
    assert only.start == {"hinge.phi": 0.5}
    assert only.distance == 0
