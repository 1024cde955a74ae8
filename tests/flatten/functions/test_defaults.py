"""What a short class of a function binds is the default of an input, which a call may override."""

from __future__ import annotations

import pytest

import planarc

TEXT = """
function f
  input Real x;
  input Real k=2;
  output Real y;
algorithm
  y := x + 100*k;
end f;
function g = f(x=5);
function h = f(k=7);
function outside
  function own = f(x=5);
  input Real u;
  output Real y;
algorithm
  y := own(u);
end outside;
"""


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("g()", 205),
        ("g(3)", 203),
        ("g(3, 4)", 403),
        ("g(k=3)", 305),
        ("g(x=3)", 203),
        ("g(3, k=4)", 403),
        ("h(3)", 703),
        ("h(3, 4)", 403),
        ("outside(3)", 203),
    ],
)
def test_arguments_override_what_is_bound(call: str, expected: float) -> None:
    result = planarc.load(f"{TEXT}model M\n  Real y={call} + 0*time;\nend M;\n", "M").simulate(1.0)
    assert result["y"][-1] == expected


@pytest.mark.parametrize("call", ["g(3, 4, 5)", "g(3, x=4)"])
def test_an_input_is_given_once(call: str) -> None:
    with pytest.raises(planarc.PlanarcError, match="F290"):
        planarc.load(f"{TEXT}model M\n  Real y={call};\nend M;\n", "M")
