"""Functions that call themselves: put in as often as what is known says."""

from __future__ import annotations

import pytest

import planarc

FACTORIAL = """
function f input Integer n; output Integer y;
algorithm y := if n < 1 then 1 else n*f(n - 1); end f;
"""
STATEMENTS = """
function f input Integer n; output Integer y;
algorithm if n < 1 then y := 1; else y := n*f(n - 1); end if; end f;
"""
TWICE = """
function f input Integer n; output Integer y;
algorithm y := if n < 2 then n else f(n - 1) + f(n - 2); end f;
"""
TURNS = """
function f input Integer n; output Integer y; algorithm y := if n < 1 then 1 else g(n - 1); end f;
function g input Integer n; output Integer y; algorithm y := 2*f(n); end g;
"""


@pytest.mark.parametrize(
    ("functions", "five", "six"),
    [(FACTORIAL, 120, 720), (STATEMENTS, 120, 720), (TWICE, 5, 8), (TURNS, 32, 64)],
    ids=["if", "statements", "twice", "by turns"],
)
def test_a_parameter_may_say_how_often(functions: str, five: int, six: int) -> None:
    model = planarc.load(f"""
    model M {functions}
      function h input Integer n; input Real u; output Real y; algorithm y := u*f(n); end h;
      parameter Integer n = 5; Integer y = f(n); Real z = h(n, time);
    end M;
    """)
    assert model.simulate(1.0).at("y", 1.0) == five
    result = model.simulate(1.0, parameters={"n": 6})
    assert (result.at("y", 1.0), result.at("z", 0.5)) == (six, six / 2)


@pytest.mark.parametrize("functions", [FACTORIAL, TWICE, TURNS])
def test_a_recursion_by_what_varies_is_told_with_its_call(functions: str) -> None:
    with pytest.raises(planarc.PlanarcError, match="L320") as refused:
        planarc.load(f"""
        model M {functions} Integer n = if time > 1 then 2 else 3; Integer y = f(n); end M;
        """)
    (told,) = refused.value.diagnostics
    assert [r.span.text for r in told.related if r.span] == ["f(n)"]


def test_the_function_that_calls_itself_is_named_and_not_what_it_calls() -> None:
    with pytest.raises(planarc.PlanarcError, match=r"`M\.f` calls itself"):
        planarc.load("""
        model M
          function g input Real u; output Real y; algorithm y := u + 1; end g;
          function f input Real u; output Real y; protected Real v;
          algorithm v := g(u); y := if v > 1e3 then v else f(g(v)); end f;
          Real y = f(time);
        end M;
        """)


def test_deep_expressions_in_a_recursion_are_told_at_its_call() -> None:
    deep = "n*f(n - 1)"
    for k in range(20):
        deep = f"(if n < {-k} then {k} else sum({{1 + {deep}, 2}}))"
    model = f"""
    model M
      function f input Integer n; output Integer y; algorithm y := if n < 1 then 1 else {deep};
      end f;
      parameter Integer n = 2; Integer y = f(%s);
    end M;
    """
    with pytest.raises(planarc.PlanarcError, match="L300") as refused:
        planarc.load(model % "if time > 1 then 1 else 2")
    span = refused.value.diagnostics[0].span
    assert span is not None
    assert span.text.startswith("f(if time")
    assert planarc.load(model % "n").simulate(1.0).at("y", 1.0) == 2 * (1 + 20 * 3) + 20 * 3
