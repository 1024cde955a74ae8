"""Mobility by rank at the start, and redundant joints by their names."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planarc.cli.app import run
from planarc.probe.check import check_model
from planarc.request.request import Request


def bars(count: int) -> str:
    """A body on parallel bars: each bar more than two holds what is held already."""
    parts = "".join(
        f"P.Joints.Revolute a{i}(phi(start=0.3)); P.Joints.Revolute b{i};"
        f"P.Parts.FixedTranslation bar{i}(r={{0,1}});"
        f"P.Parts.FixedTranslation base{i}(r={{{i},0}});"
        f"P.Parts.FixedTranslation top{i}(r={{{i},0}});"
        for i in range(count)
    )
    ties = "".join(
        f"connect(g.frame_b, base{i}.frame_a); connect(base{i}.frame_b, a{i}.frame_a);"
        f"connect(a{i}.frame_b, bar{i}.frame_a); connect(bar{i}.frame_b, b{i}.frame_a);"
        f"connect(b{i}.frame_b, top{i}.frame_b); connect(top{i}.frame_a, body.frame_a);"
        for i in range(count)
    )
    return (
        "model M import P = PlanarMultiBody; inner P.World world; P.Parts.Fixed g; "
        f"P.Parts.Body body(m=1); {parts} equation {ties} end M;"
    )


def test_a_third_parallel_bar_moves_by_rank_and_is_named() -> None:
    found = check_model(Request(text=bars(3)))
    assert found.mobility is not None
    assert (found.mobility.count, found.mobility.rank) == (0, 1)
    assert found.mobility.redundant is not None
    message = found.mobility.redundant.message
    assert all(f"`{name}`" in message for name in ("a0", "a1", "a2"))


def test_two_parallel_bars_move_as_they_count() -> None:
    two = check_model(Request(text=bars(2))).mobility
    assert two is not None
    assert (two.count, two.rank, two.redundant) == (1, 1, None)
    found = check_model(Request(text=bars(2)), start=True)
    assert found.mobility is not None
    assert (found.mobility.count, found.mobility.rank) == (1, 1)
    assert found.mobility.redundant is None


def test_a_fourth_bar_does_not_fit_and_the_count_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "M.pmo"
    file.write_text(bars(4), encoding="utf-8")
    assert run(["check", str(file)]) == 1
    assert "mobility -1 by count (3*5 - 8*2)" in capsys.readouterr().err


def test_check_tells_the_mechanism_in_text_and_json(capsys: pytest.CaptureFixture[str]) -> None:
    name = "PlanarMultiBody.Examples.Loops.AndrewsSqueezer"
    assert run(["check", name]) == 0
    told = capsys.readouterr().out
    assert "7 moving bodies, 10 joints, 3 independent loops; mobility 1 by count" in told
    assert "1 by rank at the start (all conditions are independent)" in told
    assert run(["check", name, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mechanism"] == {
        "bodies": 7,
        "joints": 10,
        "loops": 3,
        "mobility": 1,
        "mobility_by_rank": 1,
    }


def test_what_cannot_be_assembled_is_an_error_only_where_the_start_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "M.pmo"
    # Crank and coupler are too short to reach the rocker.
    file.write_text(
        """
        model M
          inner PlanarMultiBody.World world;
          PlanarMultiBody.Parts.Fixed far(r={9, 0});
          PlanarMultiBody.Joints.Revolute a(phi(start=1, fixed=true)), b, c, d;
          PlanarMultiBody.Parts.BodyShape one(r={1, 0}, m=1), two(r={1, 0}, m=1),
            three(r={1, 0}, m=1);
        equation
          connect(world.frame_b, a.frame_a);
          connect(a.frame_b, one.frame_a);
          connect(one.frame_b, b.frame_a);
          connect(b.frame_b, two.frame_a);
          connect(two.frame_b, c.frame_a);
          connect(far.frame_b, d.frame_a);
          connect(d.frame_b, three.frame_a);
          connect(three.frame_b, c.frame_b);
        end M;
        """,
        encoding="utf-8",
    )
    assert run(["check", str(file)]) == 0
    assert "by rank" not in capsys.readouterr().out
    assert run(["check", str(file), "--start"]) == 1
    assert "R412" in capsys.readouterr().err


SLIDING = """
model Sliding "A slab that two gears keep from turning, and that slides"
  import Modelica.Mechanics.Rotational.Components.*;
  model Slab
    Modelica.Mechanics.Rotational.Interfaces.Flange_a turn;
    Real x(start=0), v=der(x), phi=turn.phi, w=der(phi);
  equation
    der(v) = 1;
    0.2*der(w) = turn.tau;
  end Slab;
  Slab slab;
  Inertia motor(J=0.1);
  IdealGear g1(ratio=2), g2(ratio=3);
equation
  connect(motor.flange_b, g1.flange_a);
  connect(g1.flange_b, slab.turn);
  connect(motor.flange_b, g2.flange_a);
  connect(g2.flange_b, slab.turn);
end Sliding;
"""


def test_what_cannot_turn_but_slide_is_not_said_to_stand_still() -> None:
    (told,) = (w for w in check_model(Request(text=SLIDING)).warnings if w.code == "S322")
    assert told.message.startswith("`motor` cannot move")
