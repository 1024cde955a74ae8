"""Results of functions have the sizes that their declarations say, or the call is refused."""

from __future__ import annotations

import pytest

import planarc

SHORT = "function f input Real v[:]; output Real w[3]; algorithm w := v; end f;"
SLICE = SHORT.replace("w := v", "w[1:3] := v")


@pytest.mark.parametrize("function", [SHORT, SLICE])
@pytest.mark.parametrize(
    "body",
    [
        "constant Real w[3] = f({1, 2});",
        "Real w[3] = f({1, 2})*time;",
        "Real w[3]; algorithm w := f({time, 2});",
        "discrete Real w[3]; algorithm when sample(0, 1) then w := f({time, 2}); end when;",
        "Real w = f({time, 2})*{1, 2, 3};",
        "Real w = sum(f({time, 2}));",
    ],
)
def test_a_result_of_another_size_is_refused(function: str, body: str) -> None:
    with pytest.raises(planarc.PlanarcError, match="L331"):
        planarc.load(f"model M {function} {body} end M;")


def test_a_size_that_is_no_integer_is_refused() -> None:
    model = """
    model M
      function random
        input Integer before[2]; output Real r; output Integer after[1e-999];
      protected
        Real scratch[2];
      external "C" ModelicaRandom_xorshift64star(before, after, r, scratch, size(scratch, 1));
      end random;
      discrete Integer state[2](start = {1, 0}); discrete Real r;
    algorithm
      when sample(0, 1) then (r, state) := random(pre(state)); end when;
    end M;
    """
    with pytest.raises(planarc.PlanarcError, match="F255"):
        planarc.load(model)


def test_a_size_may_be_told_by_another_function() -> None:
    result = planarc.load("""
    model M
      function n input Integer k; output Integer m; algorithm m := k + 1; end n;
      function f
        input Real x[:]; output Real y[n(size(x, 1))];
      algorithm for i in 1:size(y, 1) loop y[i] := i; end for; end f;
      parameter Real a[:] = f({1, 2});
      constant Real b[3] = f({1, 2});
      Real z = a[3] + b[2]*time;
    end M;
    """).simulate(1.0)
    assert result.at("z", 1.0) == 5.0


def test_a_function_that_is_handed_in_must_have_a_result() -> None:
    with pytest.raises(planarc.PlanarcError, match="L321"):
        planarc.load("""
        model M
          partial function F input Real x; output Real y; end F;
          function g input Real x; protected Real y; algorithm y := x; end g;
          function h input F f; output Real s; algorithm s := f(1) + f(2); end h;
          Real x = h(g);
        end M;
        """)


def test_a_range_from_beyond_its_end_is_empty_however_far() -> None:
    """As far as its number of steps is no number."""
    result = planarc.load("model M Real x = 1 + sum(1e308:1e-300:1e300); end M;").simulate(1.0)
    assert result.at("x", 1.0) == 1.0
