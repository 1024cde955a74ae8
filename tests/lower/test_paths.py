"""Checks inside of functions count where the function is called, and nowhere else."""

from __future__ import annotations

from typing import Any

import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request

FUNCTIONS = """
  function stop input String why; algorithm assert(false, why); end stop;
  function root input Real x; output Real y;
  algorithm
    if x < 0 then
      stop("negative");
    end if;
    y := sqrt(abs(x));
  end root;
  function strict input Real x; output Real y;
  algorithm assert(x > 0, "must be positive"); y := x; end strict;
"""


def run(equations: str) -> Any:
    text = f"model M\n{FUNCTIONS}\n  Real y;\nequation\n{equations}\nend M;"
    compiled = compiler.compile_model(Request(text=text), Backend.NUMPY)
    return compiler.run(compiled, RunOptions(stop=2.0, intervals=20, backend=Backend.NUMPY))


@pytest.mark.parametrize(
    "equations",
    [
        "  y = root(1 + time);",
        "  y = if time < 1 then strict(1 - time + 1e-9) else 0;",
        "  y = if time > 1 then 0 elseif time < 0.5 then strict(0.6 - time) else 1;",
        "  y = noEvent(if time < 1 then strict(1.1 - time) else root(time));",
    ],
)
def test_a_check_on_a_way_that_is_not_taken_says_nothing(equations: str) -> None:
    assert run(equations).ended is None


@pytest.mark.parametrize(
    ("equations", "message", "time"),
    [
        ("  y = root(1 - time);", "negative", 1.0),
        ("  y = if time < 1 then strict(0.75 - time) else 0;", "must be positive", 0.75),
        ("  y = if time < 1 then 0 else strict(1.55 - time);", "must be positive", 1.55),
    ],
)
def test_a_check_on_the_way_taken_ends_the_run(equations: str, message: str, time: float) -> None:
    ended = run(equations).ended
    assert ended is not None
    assert ended.code == "R430"
    assert message in ended.message
    told = float(ended.message.split("t = ")[1].split(" ")[0])
    assert told == pytest.approx(time, abs=0.11)
