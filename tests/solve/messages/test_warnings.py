"""Assertions of the level warning: said once, with how often and how long they did not hold."""

from __future__ import annotations

import math
import re

import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request

MODEL = """
model M
  Real x = sin(time);
equation
  assert(x >= {limit}, "too low: " + String(x), AssertionLevel.warning);
end M;
"""


def warnings_of(limit: float, intervals: int) -> list[str]:
    options = RunOptions(stop=4 * math.pi, intervals=intervals, backend=Backend.NUMPY)
    compiled = compiler.compile_model(Request(text=MODEL.format(limit=limit)), Backend.NUMPY)
    result = compiler.run(compiled, options)
    assert result.ended is None
    return [w.message for w in result.warnings]


@pytest.mark.parametrize("intervals", [500, 5000])
def test_a_warning_tells_how_often_and_how_long(intervals: int) -> None:
    (message,) = warnings_of(0.0, intervals)
    found = re.search(r"at t = ([\d.]+) s.*too low.*\(2 times, ([\d.]+) s in all\)", message)
    assert found is not None, message
    assert float(found[1]) == pytest.approx(math.pi, abs=2 * 4 * math.pi / intervals)
    assert float(found[2]) == pytest.approx(2 * math.pi, abs=6 * 4 * math.pi / intervals)


def test_what_holds_gives_no_warning() -> None:
    assert warnings_of(-2.0, 100) == []
