"""A start by machine code is that of Python, to the last bit, or is left to it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.solve.start import plain

EXAMPLES = Path(__file__).parents[3] / "examples"
#: A variable that follows from a candidate is fixed.
DRIVEN = """
model Driven
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute hinge(phi(start=0.3), w(start=1, fixed=true));
  PlanarMultiBody.Parts.Body body(m=1, I=0.1, r_CM={0.5, 0});
  Real half(start=0.4, fixed=true) = 2*hinge.phi;
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, body.frame_a);
end Driven;
"""


class Asked:
    """What machine code gave at each start; nothing with `off`."""

    def __init__(self) -> None:
        self.found: list[plain.Plain | None] = []
        self.off = False
        self._begin = plain.begin

    def __call__(self, *given: Any) -> plain.Plain | None:
        self.found.append(None if self.off else self._begin(*given))
        return self.found[-1]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    found = Asked()
    monkeypatch.setattr(plain, "begin", found)
    return found


def both(asked: Asked, model: planarc.Model, **given: Any) -> tuple[planarc.Result, planarc.Result]:
    """A run from a start by machine code, and the same by Python."""
    results = []
    for off in (False, True):
        asked.off = off
        results.append(model.simulate(0.05, intervals=10, **given))
    return results[0], results[1]


@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("pendulum", {"hinge.w": 3.0}),
        ("double_pendulum", {}),
        ("four_bar", {}),
        ("four_bar", {"revA.phi": 1.2, "revA.w": -9.0}),  # speeds go far, along a straight line
        ("crank_slider", {"main.phi": 1.9}),
        ("gripper", {}),
        ("walking_leg", {}),  # six conditions
        ("dominoes", {}),
    ],
)
def test_a_plain_start_is_the_same_to_the_last_bit(
    asked: Asked, name: str, start: Mapping[str, float]
) -> None:
    model = planarc.load(EXAMPLES / f"{name}.pmo")
    known = {n: v for n, v in start.items() if n in model.variables}
    asked.found.clear()
    one, other = both(asked, model, start=known)
    assert asked.found[0] is not None
    assert (one.start, one.states, one.warnings) == (other.start, other.states, other.warnings)
    assert np.array_equal(one.rows.data, other.rows.data, equal_nan=True)
    assert one.statistics == other.statistics


def test_a_fixed_variable_that_is_no_candidate_is_a_condition(asked: Asked) -> None:
    one, other = both(asked, planarc.load(DRIVEN))
    assert asked.found[0] is not None
    assert one.start == other.start
    assert one["hinge.phi"][0] == other["hinge.phi"][0] == pytest.approx(0.2)


@pytest.mark.parametrize(
    "start",
    [
        {"revA.phi": 1.0, "revB.phi": 2.0},  # which side is meant must be searched
        {"revA.phi": 0.0, "revB.phi": 0.0, "revC.phi": 0.0},
        {"revA.phi": 40.0},
    ],
)
def test_where_there_is_anything_to_search_python_does_it(
    asked: Asked, start: Mapping[str, float]
) -> None:
    one, other = both(asked, planarc.load(EXAMPLES / "four_bar.pmo"), start=start)
    assert None in asked.found[:1]
    assert (one.start, one.warnings) == (other.start, other.warnings)


def test_a_start_by_machine_code_knows_nothing_of_the_one_before(asked: Asked) -> None:
    model = planarc.load(EXAMPLES / "four_bar.pmo")
    first = model.simulate(0.05, start={"revA.phi": 1.1})
    model.simulate(0.05, start={"revA.phi": 1.3})
    again = model.simulate(0.05, start={"revA.phi": 1.1})
    assert None not in asked.found
    assert np.array_equal(first.rows.data, again.rows.data)
