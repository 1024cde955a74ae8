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


VECTORS = "function f input Real x[:]; output Real y; protected %s algorithm %s end f;"


@pytest.mark.parametrize(
    ("local", "statement", "message"),
    [
        ("", "y := sum(x + {1, 2});", r"L314.*`\+` cannot join .*the sizes 3 and 2"),
        ("", "y := sum(x*{1, 2});", r"L314.*`\*` cannot join .*the sizes 3 and 2"),
        ("", "y := sum(x.^{1, 2});", r"L314.*the sizes 3 and 2"),
        ("", "y := x*x[1:2];", r"L314.*the sizes 3 and 2"),
        ("", "y := sum([1, 2; 3, 4]*x);", r"L314.*the sizes 2 by 2 and 3"),
        ("", "y := sum(outerProduct(x, {1, 2})*x);", r"L314.*the sizes 3 by 2 and 3"),
        ("", "y := sum([x]^2);", r"L314.*`\^` needs a square .*the size 3 by 1"),
        ("", "y := sum(atan2(x, {1, 2}));", r"L314.*`atan2` cannot .*the sizes 3 and 2"),
        ("", "y := scalar(x);", r"L314.*`scalar` cannot take .*the size 3"),
        ("", "y := sum(vector(outerProduct(x, x)));", r"L314.*the size 3 by 3"),
        ("", "y := sum(cross(cat(1, x, {1}), {1, 2, 3}));", r"L314.*the sizes 4 and 3"),
        ("", "y := sum({x, {1, 2}});", r"L314.*the sizes 3 and 2"),
        ("", "y := sum([x, {1, 2}]);", r"L314.*`\[\.\.\.\]` .*the sizes 3 by 1 and 2 by 1"),
        ("", "y := sum({{j for j in 1:i} for i in 1:size(x, 1)});", r"L314.*the sizes 1 and 2"),
        (
            "Boolean s[:];",
            "s := {v > 0 for v in x}; y := if max(s and {true}) then 1 else 0;",
            "L314",
        ),
        ("Real z[2];", "z := x; y := sum(z);", r"L331.*`z` has the size 2, its value the size 3"),
        ("Real z[2] = x;", "y := sum(z);", r"L331.*`z` has the size 2, its value the size 3"),
        ("Real z[size(x, 1) - 1];", "z := x; y := sum(z);", r"L331.*the size 2"),
        ("Real z[2, 2];", "z := {x, x}; y := sum(z);", r"L331.*2 by 2, its value the size 2 by 3"),
        ("Real z[2, 2];", "z[1] := x; y := sum(z);", r"L331.*`z\[1\]` has the size 2"),
        ("R r;", "r.a := x; y := sum(r.a);", r"L331.*`r.a` has the size 2"),
        ("R r;", "r := R(x); y := sum(r.a);", r"L331.*`a` has the size 2"),
    ],
)
@pytest.mark.parametrize("call", ["f({time, 2, 3})", "p; parameter Real p = f({1, 2, 3})"])
def test_sizes_that_do_not_fit_in_a_call_are_told_with_it(
    local: str, statement: str, message: str, call: str
) -> None:
    with pytest.raises(planarc.PlanarcError, match="(?s)" + message) as refused:
        planarc.load(f"""
        model M
          record R Real a[2]; end R; {VECTORS % (local, statement)}
          Real y = {call};
        end M;
        """)
    (told,) = refused.value.diagnostics
    assert [r.message for r in told.related] == ["called here"]


def test_of_calls_inside_each_other_the_first_and_the_last_are_told() -> None:
    with pytest.raises(planarc.PlanarcError, match="L314") as refused:
        planarc.load(f"""
        model M
          {VECTORS % ("", "y := x*{1, 2};")}
          function g input Real x[:]; output Real y; algorithm y := f(x); end g;
          function h input Real x[:]; output Real y; algorithm y := g(x); end h;
          Real y = h({{time, 2, 3}});
        end M;
        """)
    places = [r.span.text for r in refused.value.diagnostics[0].related if r.span]
    assert places == ["f(x)", "h({time, 2, 3})"]


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("y := integer(x*{1, 2});", r"F274.*`\*` cannot join .*the sizes 3 and 2"),
        ("y := integer(sum(x - {1, 2}));", r"F274.*the sizes 3 and 2"),
        ("y := integer(scalar(x));", r"F291.*`scalar` cannot take .*the size 3"),
        ("y := integer(sum(atan2(x, {1, 2})));", r"F291.*the sizes 3 and 2"),
        ("y := integer(sum({x, {1, 2}}));", r"F272.*the sizes 3 and 2"),
        ("m[1] := x; y := integer(sum(m));", r"F270.*`m\[1\]` has the size 2"),
        ("z := x; y := 1;", r"F270.*`z` has the size 2, its value the size 3"),
    ],
)
def test_sizes_that_do_not_fit_in_a_call_that_gives_a_size(statement: str, message: str) -> None:
    function = VECTORS % ("Real z[2]; Real m[2, 2];", statement)
    with pytest.raises(planarc.PlanarcError, match="(?s)" + message) as refused:
        planarc.load(f"""
        model M
          {function.replace("output Real", "output Integer")}
          parameter Integer n = f({{1, 2, 3}});
          Real q[n] = fill(time, n);
        end M;
        """)
    assert [r.message for r in refused.value.diagnostics[0].related] == ["called here"]


def test_arrays_without_entries_fit() -> None:
    result = planarc.load("""
    model M
      function f
        input Integer n; input Real u; output Real y;
      protected
        Real a[0, n] = zeros(0, n); Real z[:];
      algorithm
        y := u + sum(a*identity(n)) + sum(a + zeros(0, n));
        z := {y for i in 1:n - 3}; z := cat(1, z, {y});
        y := sum(z);
      end f;
      parameter Integer n = integer(f(3, 2));
      Real q[n] = fill(f(3, time), n);
    end M;
    """).simulate(1.0)
    assert result.at("q[2]", 1.0) == 1.0


def test_a_slice_that_fits_for_some_ends_only_ends_the_run_at_others() -> None:
    model = planarc.load("""
    model M
      function f input Real x[:]; input Integer m; output Real y; algorithm y := x[1:m]*x; end f;
      Integer m = if time > 0.5 then 2 else 3; Real y = f({1, 2, time}, m);
    end M;
    """)
    assert model.simulate(0.25).at("y", 0.25) == 5.0625
    with pytest.raises(planarc.PlanarcError, match=r"t = 0\.5"):
        model.simulate(1.0)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("Real y[2] = f({time, 2, 3});", r"L344.*the sizes 2 and 3"),
        ("Real y[2]; algorithm y := f({time, 2, 3});", r"L331.*the size 2, .*the size 3"),
        ("Real y = f({time, 2, 3})*f({1, 2});", r"L314.*the sizes 3 and 2"),
    ],
)
def test_a_result_of_any_size_fits_where_it_stands(body: str, message: str) -> None:
    function = "function f input Real v[:]; output Real w[:]; algorithm w := v; end f;"
    with pytest.raises(planarc.PlanarcError, match="(?s)" + message):
        planarc.load(f"model M {function} {body} end M;")
