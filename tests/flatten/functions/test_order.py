"""Variables of functions get their first values in the order of what they are written with."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir import flat

Flatten = Callable[..., flat.FlatModel]

FUNCTION = """
function f
  input Real x;
  output Real y = a;
protected
  Real a = 2*b;
  Real b = {b};
algorithm
  y := y + a;
end f;
model T Real z = f(time); end T;
"""


def test_each_after_those_it_is_written_with(flatten_text: Flatten) -> None:
    (function,) = flatten_text(FUNCTION.replace("{b}", "x + 1")).functions
    assert [v.name for v in function.locals] == ["b", "a"]
    assert function.outputs[0].binding is None  # comes before the locals: it is assigned instead
    first = function.body[0]
    assert isinstance(first, flat.Assignment) and isinstance(first.target, flat.Reference)
    assert first.target.name == "y"


def test_a_circle_is_refused(flatten_text: Flatten) -> None:
    with pytest.raises(PlanarcError) as caught:
        flatten_text(FUNCTION.replace("{b}", "a + 1"))
    (problem,) = caught.value.diagnostics
    assert problem.code == "F207" and "`a` and `b`" in problem.message
