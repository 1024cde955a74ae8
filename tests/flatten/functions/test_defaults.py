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


HANDED = """
partial function One
  input Real u;
  output Real y;
end One;
partial function Two
  extends One;
  input Real v;
end Two;
function one
  input One f;
  input Real u;
  output Real y;
algorithm
  y := f(u);
end one;
function two
  input Two f;
  input Real u, v;
  output Real y;
algorithm
  y := f(u, v) + one(function f(u=u), v);
end two;
"""


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("one(g, 3)", 203),
        ("one(h, 3)", 703),
        ("one(function g(x=4), 3)", 304),
        ("one(function g(k=4), 3)", 403),
        ("one(function h(x=4), 3)", 304),
        ("two(g, 3, 4)", 403 + 403),
        ("two(h, 3, 4)", 403 + 403),
    ],
)
def test_what_is_bound_is_a_default_of_a_function_that_is_handed_in(
    call: str, expected: float
) -> None:
    text = f"{TEXT}{HANDED}model M\n  Real y={call} + 0*time;\nend M;\n"
    assert planarc.load(text, "M").simulate(1.0)["y"][-1] == expected


def test_the_hint_says_how_an_input_keeps_what_is_bound() -> None:
    text = f"{TEXT}function e = g2(x=5);\n{HANDED}function g2 input Real x, k; output Real y; "
    text += "algorithm y := x + 100*k; end g2;\nmodel M\n  Real y=one(e, 3) + 0*time;\nend M;\n"
    with pytest.raises(planarc.PlanarcError) as refused:
        planarc.load(text, "M")
    (found,) = refused.value.diagnostics
    assert (found.code, found.message) == ("F290", "`e` needs a value for `k`")
    assert found.hint == "write `function e(x=5)`, which leaves `x` as it is"
    mended = text.replace("one(e, 3)", "one(function e(x=5), 3)")
    assert planarc.load(mended, "M").simulate(1.0)["y"][-1] == 305
