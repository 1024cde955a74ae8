"""Rows that do not show a motion are told, and none that show it or need not."""

from __future__ import annotations

import re
from math import pi
from pathlib import Path

import pytest
from msgspec.structs import replace

import planarc
from planarc.insight.sparse import judge_sparse

#: A mass of 1 kg on a spring, which swings once in `period` about the middle of it.
SWING = """model M
  import PlanarMultiBody.*;
  inner World world(gravityType=Types.GravityTypes.NoGravity);
  Joints.Prismatic slide(drivenFlange=true, s(start=0.1, fixed=true), v(start=0, fixed=true));
  Parts.Body mass(m=1, I=0.1);
  Modelica.Mechanics.Translational.Components.Spring spring(c=C);
equation
  connect(world.frame_b, slide.frame_a);
  connect(slide.frame_b, mass.frame_a);
  connect(slide.support, spring.flange_a);
  connect(spring.flange_b, slide.axis);
end M;
"""


def told(period: float, apart: float, rows: int = 100) -> list[str]:
    model = planarc.load(SWING.replace("=C", f"={(2 * pi / period) ** 2!r}"))
    run = model.simulate(apart * rows, intervals=rows)
    return [f"{w.message} {w.hint}" for w in run.warnings if w.code == "R456"]


@pytest.mark.parametrize("rows_in_a_period", [0.3, 0.9, 1.7, 2.6])
def test_the_period_is_that_of_the_closed_form(rows_in_a_period: float) -> None:
    (message,) = told(0.5, 0.5 / rows_in_a_period)
    found = re.search(r"`slide.s` goes to and fro about every (\S+) s:", message)
    assert found is not None and float(found[1]) == pytest.approx(0.5, rel=0.05)
    assert f"rows lie {0.5 / rows_in_a_period:.4g} s apart" in message
    wanted = re.search(r"`--interval (\S+)`", message)
    assert wanted is not None and float(wanted[1]) == pytest.approx(0.025, rel=0.05)


@pytest.mark.parametrize("rows_in_a_period", [5.0, 20.0])
def test_rows_that_show_a_motion_are_none(rows_in_a_period: float) -> None:
    assert told(0.5, 0.5 / rows_in_a_period) == []


def test_a_few_rows_are_to_show_where_a_run_ends() -> None:
    assert told(0.5, 5.0, rows=10) == []


def test_a_steady_turn_is_seen_in_any_rows() -> None:
    text = """model M
      import PlanarMultiBody.*;
      inner World world(gravityType=Types.GravityTypes.NoGravity);
      Joints.Revolute hinge(phi(fixed=true), w(start=50, fixed=true));
      Parts.BodyShape bar(r={0.5, 0}, m=1, I=0.1);
    equation
      connect(world.frame_b, hinge.frame_a);
      connect(hinge.frame_b, bar.frame_a);
    end M;"""
    assert [w.code for w in planarc.load(text).simulate(100.0).warnings] == []


def test_what_has_no_acceleration_in_any_row_has_no_period() -> None:
    """As what drifts by rounding alone: the rows of a swing, of which none has an acceleration."""
    model = planarc.load(SWING.replace("=C", f"={(2 * pi / 0.5) ** 2!r}"))
    result = model.simulate(30.0, intervals=100).rows
    assert [d.code for d in judge_sparse(result)] == ["R456"]
    data = result.data.copy()
    data[:, result.stored[result.columns["slide.a"].slot]] = 0.0
    assert not list(judge_sparse(replace(result, data=data)))


def test_what_drifts_by_rounding_alone_swings_in_no_time() -> None:
    """The last domino has a speed of 1e-18 m/s in the rows, and hardly an acceleration."""
    model = planarc.load(Path(__file__).parents[2] / "examples" / "dominoes.pmo")
    run = model.simulate(0.3, intervals=100, tolerance=1e-12)
    assert not [w for w in run.warnings if w.code == "R456"]
