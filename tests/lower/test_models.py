"""Functions, algorithms and events of small models, run to closed forms with both back ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(text: str, backend: Backend, stop: float = 2.0) -> Any:
    options = RunOptions(stop=stop, intervals=20, tolerance=1e-9, backend=backend)
    return compiler.run(compiler.compile_model(Request(text=text), backend), options)


def test_function_with_a_loop_over_an_array_of_any_size(backend: Backend) -> None:
    result = run(
        """model M
          function weighted input Real x[:]; output Real y;
          algorithm
            y := 0;
            for i in 1:size(x, 1) loop y := y + i*x[i]^2; end for;
          end weighted;
          Real z = weighted({1, 2*time, time});
        end M;""",
        backend,
    )
    t = result.time
    assert result["z"] == pytest.approx(1 + 2 * (2 * t) ** 2 + 3 * t**2)


def test_partial_derivative_functions_twice(backend: Backend) -> None:
    result = run(
        """model M
          function f input Real s; input Real a; output Real y; algorithm y := a*sin(s)*s; end f;
          function f_s = der(f, s);
          function f_ss = der(f_s, s);
          Real first = f_s(time, 2), second = f_ss(time, 2);
        end M;""",
        backend,
    )
    t = result.time
    assert result["first"] == pytest.approx(2 * (np.sin(t) + t * np.cos(t)), abs=1e-12)
    assert result["second"] == pytest.approx(2 * (2 * np.cos(t) - t * np.sin(t)), abs=1e-12)


def test_function_with_a_branch_that_depends_on_the_run(backend: Backend) -> None:
    result = run(
        """model M
          function clip input Real u; output Real y;
          algorithm
            if u > 0.5 then y := 0.5; elseif u < 0.25 then y := 0.25; else y := u; end if;
          end clip;
          Real y = clip(time);
        end M;""",
        backend,
        stop=1.0,
    )
    assert result["y"] == pytest.approx(np.clip(result.time, 0.25, 0.5))


def test_search_through_a_table(backend: Backend) -> None:
    result = run(
        """model M
          function look
            input Real x[:], y[:], u;
            output Real v;
          protected
            Integer i = 1;
          algorithm
            while i < size(x, 1) - 1 and u > x[i + 1] loop
              i := i + 1;
            end while;
            v := y[i] + (y[i + 1] - y[i])*(u - x[i])/(x[i + 1] - x[i]);
          end look;
          parameter Real x[4] = {0, 0.5, 1, 2}, y[4] = {0, 1, -1, 0};
          Real v = look(x, y, time);
        end M;""",
        backend,
    )
    assert result["v"] == pytest.approx(np.interp(result.time, [0, 0.5, 1, 2], [0, 1, -1, 0]))


def test_parameters_that_decide_the_course_of_a_function_become_structural() -> None:
    text = """model M
      function steps "how often u can be halved until it is below 1"
        input Real u;
        output Integer n = 0;
      protected
        Real v = u;
      algorithm
        while v >= 1 loop
          v := v/2;
          n := n + 1;
        end while;
      end steps;
      parameter Real u = 40, factor = 2;
      Real x = steps(u)*factor*time;
    end M;"""
    compiled = compiler.compile_model(Request(text=text), Backend.NUMPY)
    slots = {p.name: p for p in compiled.program.parameter_slots}
    assert slots["u"].structural
    assert not slots["u"].settable
    assert slots["factor"].settable
    result = compiler.run(compiled, RunOptions(stop=1.0, backend=Backend.NUMPY))
    assert result["x"][-1] == pytest.approx(6 * 2)


def test_return_and_break_under_unknown_conditions(backend: Backend) -> None:
    result = run(
        """model M
          function first
            input Real u;
            output Real y;
          algorithm
            for i in 1:5 loop
              y := i;
              if i > 3*u then break; end if;
              if u > 1.5 then y := -1; return; end if;
            end for;
            y := 10*y;
          end first;
          Real y = first(time);
        end M;""",
        backend,
    )
    t = result.time

    def first(u: float) -> float:
        for i in range(1, 6):
            y = i
            if i > 3 * u:
                break
            if u > 1.5:
                return -1
        return 10 * y

    assert result["y"] == pytest.approx([first(u) for u in t])


def test_record_of_a_function(backend: Backend) -> None:
    result = run(
        """model M
          record Pair Real a; Real b[2]; end Pair;
          function make input Real q; output Pair p;
          algorithm p.a := q; p.b := {q, 2*q}; p.b[1] := 3*p.a; end make;
          Pair r = make(time);
        end M;""",
        backend,
    )
    assert result["r.b[1]"] == pytest.approx(3 * result.time)
    assert result["r.b[2]"] == pytest.approx(2 * result.time)


def test_algorithm_section(backend: Backend) -> None:
    result = run(
        """model M
          Real x, y;
        algorithm
          x := time;
          if x > 1 then y := x*x; else y := -x; end if;
          y := y + 1;
        end M;""",
        backend,
    )
    t = result.time
    inside = np.abs(t - 1) > 1e-6
    expected = np.where(t > 1, t * t, -t) + 1
    assert result["y"][inside] == pytest.approx(expected[inside])


def test_sampled_counter_drives_an_integral(backend: Backend) -> None:
    result = run(
        """model M
          Integer k(start=0);
          Real y(start=0, fixed=true);
        equation
          when sample(0.25, 0.5) then k = pre(k) + 1; end when;
          der(y) = k;
        end M;""",
        backend,
    )
    assert [e.time for e in result.events] == pytest.approx([0.25, 0.75, 1.25, 1.75])
    assert result["k"][-1] == 4
    assert result["y"][-1] == pytest.approx(1.75 + 1.25 + 0.75 + 0.25)


def test_elsewhen_and_reinit(backend: Backend) -> None:
    result = run(
        """model M
          Real h(start=1, fixed=true), v(start=0, fixed=true);
        equation
          der(h) = v;
          der(v) = -9.81;
          when h < 0 then
            reinit(v, -0.5*pre(v));
          elsewhen time > 0.9 then
            reinit(v, 3);
          end when;
        end M;""",
        backend,
        stop=1.0,
    )
    fall = math.sqrt(2 / 9.81)
    assert [e.time for e in result.events] == pytest.approx([fall, 0.9], abs=1e-7)
    assert result["v"][-1] == pytest.approx(3 - 9.81 * 0.1)


def test_vector_of_conditions_acts_at_each(backend: Backend) -> None:
    result = run(
        """model M
          Integer n(start=0);
        equation
          when {time > 0.5, time > 1.5} then n = pre(n) + 1; end when;
        end M;""",
        backend,
    )
    assert [e.time for e in result.events] == pytest.approx([0.5, 1.5])
    assert result["n"][-1] == 2


def test_when_in_an_algorithm(backend: Backend) -> None:
    result = run(
        """model M
          Real last(start=0), twice(start=0);
        algorithm
          when sample(0, 0.5) then
            last := time;
            twice := 2*last;
          end when;
        end M;""",
        backend,
        stop=1.2,
    )
    assert result["last"][-1] == 1.0
    assert result["twice"][-1] == 2.0


def test_initial_values_of_discrete_variables(backend: Backend) -> None:
    result = run(
        """model M
          parameter Real p = 3;
          discrete Real d;
        initial equation
          d = 2*p;
        equation
          when time > 1 then d = pre(d) + 1; end when;
        end M;""",
        backend,
    )
    assert result["d"][0] == 6
    assert result["d"][-1] == 7


def test_discrete_start_values_that_depend_on_the_start_time(backend: Backend) -> None:
    text = """model M
        discrete Real d;
      initial equation
        pre(d) = 10*time;
      equation
        when time > 100 then d = 0; end when;
      end M;"""
    compiled = compiler.compile_model(Request(text=text), backend)
    for start in (0.0, 0.5):
        result = compiler.run(compiled, RunOptions(start=start, stop=1.0, backend=backend))
        assert result["d"][0] == 10 * start


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "model M function f input Real u; output Real y; protected Real a[:]; algorithm "
            "a := {u}; while sum(a) > 1 loop a := cat(1, a, {-1}); end while; y := sum(a); end f; "
            "Real x = f(time); end M;",
            "of which nothing says when it ends",
        ),
        (
            "model M function f input Integer n; output Real y; algorithm y := f(n + 1); end f; "
            "Real x = f(1)*time; end M;",
            "calls itself",
        ),
        ("model M Real x = time; Real y; equation reinit(y, 1); der(y) = 1; end M;", "reinit"),
        ("model M Real a[3]; equation for i in 1:3 loop a[i] = a[4]*i; end for; end M;", "4"),
    ],
    ids=["while", "recursion", "reinit outside", "subscript"],
)
def test_refusals_name_what_is_wrong(text: str, message: str) -> None:
    with pytest.raises(PlanarcError, match=message):
        compiler.compile_model(Request(text=text))


def test_parameters_that_the_start_decides(backend: Backend) -> None:
    result = run(
        """model M
          parameter Real p(fixed=false, start=1);
          parameter Real q = 2*p;
          parameter Real v[2](each fixed=false);
          Real x(start=1, fixed=true);
        initial equation
          der(x) = 3;
          v = {q, 7};
        equation
          der(x) = q*x;
        end M;""",
        backend,
        stop=0.5,
    )
    assert result["p"] == pytest.approx(np.full_like(result.time, 1.5))
    assert result["x"] == pytest.approx(np.exp(3 * result.time), rel=1e-6)
    assert result["v[2]"][-1] == 7


def test_a_parameter_from_an_initial_algorithm(backend: Backend) -> None:
    result = run(
        """model M
          parameter Real p(fixed=false);
          Real x = p*time;
        initial algorithm
          p := 3;
          p := p + 1;
        end M;""",
        backend,
    )
    assert result["x"] == pytest.approx(4 * result.time)


def test_a_functional_argument_leaves_defaults_alone(backend: Backend) -> None:
    result = run(
        """model M
          partial function F input Real x; output Real y; end F;
          function square input Real x; input Real k = 2; output Real y;
          algorithm y := k*x^2; end square;
          function mean input F f; input Real a; input Real b; output Real y;
          algorithm y := (f(a) + f(b))/2; end mean;
          Real y = mean(square, 0, time);
          Real z = mean(function square(k=3), 0, time);
        end M;""",
        backend,
    )
    assert result["y"] == pytest.approx(result.time**2)
    assert result["z"] == pytest.approx(1.5 * result.time**2)


def test_an_array_in_a_function_is_bounded() -> None:
    with pytest.raises(PlanarcError, match="`w` cannot have 1e\\+09 entries"):
        run(
            """model M
              function f input Integer n; output Real y;
              protected Real w[n];
              algorithm w[1] := 1; y := w[1]; end f;
              Real y = f(1000000000)*time;
            end M;""",
            Backend.NUMPY,
        )


@pytest.mark.parametrize("start", [0.0, 1.0, 3.0])
def test_a_sawtooth_jumps_at_events(backend: Backend, start: float) -> None:
    """Between events `mod` is smooth, so its integral is that of the closed form."""
    result = run(
        f"""model M
          Real x(start = 0, fixed = true);
          Real saw = mod(time + {start}, 1);
          Integer n = integer(2*(time + {start}));
          Real down = ceil(-time - {start});
        equation
          der(x) = saw;
        end M;""",
        backend,
        stop=2.4,
    )
    whole = np.floor(result.time)
    assert result["x"] == pytest.approx(whole / 2 + (result.time - whole) ** 2 / 2, abs=1e-7)
    assert float(result["saw"][-1]) == pytest.approx(0.4, abs=1e-12)
    assert result["n"][-1] == 4 + 2 * start
    assert result["down"][-1] == -2 - start
    assert sorted({round(e.time, 7) for e in result.events}) == [0.5, 1.0, 1.5, 2.0]


def test_rounding_of_a_state_that_turns_back(backend: Backend) -> None:
    """x = 2.5*sin(t) goes up and down over whole numbers; noEvent rounds the same in place."""
    result = run(
        """model M
          Real x(start = 0, fixed = true);
          Integer n = integer(x);
          Integer up(start = 0, fixed = true);
          Real q = div(x, 1), r = rem(x, 1);
          Real plain = noEvent(floor(x));
        equation
          der(x) = 2.5*cos(time);
          when change(n) then
            up = pre(up) + 1;
          end when;
        end M;""",
        backend,
        stop=6.0,
    )
    inside = np.abs(result["x"] - np.round(result["x"])) > 1e-6
    assert (result["n"] == result["plain"])[inside].all()
    assert result["q"][inside] == pytest.approx(np.trunc(result["x"])[inside])
    assert (result["q"] + result["r"])[inside] == pytest.approx(result["x"][inside])
    assert result["up"][-1] == 9


def test_a_record_as_one_of_several_results(backend: Backend) -> None:
    result = run(
        """model M
          record R Real a; Real b[2]; end R;
          function f input Real x; output R r; output Real y;
          algorithm r := R(x, {2*x, 3*x}); y := 4*x; end f;
          R r, s; Real y, z;
        equation
          (s, z) = f(2*time);
        algorithm
          (r, y) := f(time);
        end M;""",
        backend,
    )
    factors = {"r.a": 1, "r.b[2]": 3, "y": 4, "s.a": 2, "s.b[1]": 4, "z": 8}
    for name, factor in factors.items():
        assert result[name] == pytest.approx(factor * result.time, abs=1e-12)


def test_fields_of_an_array_of_records_are_assigned(backend: Backend) -> None:
    """Once while running and once when compiling (the size of `n`)."""
    result = run(
        """model M
          record R Real a; Real b[2]; end R;
          function f
            input R w[2];
            output Real y;
          protected
            R u[2] = w;
          algorithm
            u[1].a := 2*w[1].a;
            for i in 1:2 loop u[i].b[2] := 10*i; end for;
            y := u[1].a + u[2].a + u[1].b[2] + u[2].b[2];
          end f;
          constant Integer n = integer(f({R(1, {0, 0}), R(2, {0, 0})}));
          R w[2](a = {time, 1}, each b = {0, 0});
          Real y = f(w), z[n] = ones(34);
        end M;""",
        backend,
    )
    assert result["y"] == pytest.approx(2 * result.time + 31)


def test_a_function_that_was_handed_in_is_handed_on_with_an_input_bound(backend: Backend) -> None:
    result = run(
        """model M
          partial function Curve input Real x; output Real y; end Curve;
          partial function Surface input Real u; input Real v; output Real z; end Surface;
          function middle input Curve f; output Real y; algorithm y := f(0.5); end middle;
          function height
            input Surface f; input Real k; output Real y;
          algorithm
            y := 100*middle(function f(u = k)) + middle(function f(v = k));
          end height;
          function plane
            extends Surface; input Real c = 1;
          algorithm z := c*(10*u + v); end plane;
          Real a = height(plane, time);
          Real b = height(function plane(c = 2), time);
        end M;""",
        backend,
    )
    t = result.time
    expected = 100 * (10 * t + 0.5) + 5 + t
    assert result["a"] == pytest.approx(expected)
    assert result["b"] == pytest.approx(2 * expected)


def test_the_text_of_an_assertion_is_made_only_where_it_is_shown(backend: Backend) -> None:
    text = """model M
      function told input Real x; output String s;
      algorithm
        assert(x > 2, "no text below two");
        s := String(x);
      end told;
      Real x = time;
    equation
      assert(true, told(0));
      assert(x < LIMIT, told(x), AssertionLevel.warning);
      when time > 0.5 then
        assert(x > 0.1, told(x));
      end when;
    end M;"""
    assert run(text.replace("LIMIT", "2.5"), backend, stop=3).ended is None
    ended = run(text.replace("LIMIT", "1"), backend, stop=3).ended
    assert ended is not None and "no text below two" in ended.message


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("model M Integer n = 9007199254740993; end M;", "L318"),
        ("model M Integer n = -9007199254740991; end M;", None),
        ("model M parameter Integer n = 3000000; Integer m = n*n*n; end M;", "R439"),
        ("model M parameter Integer n = 3000000; parameter Integer m = n*n*n; end M;", "R439"),
        (
            "model M Integer n(start = 1, fixed = true); equation"
            " when sample(0.1, 0.1) then n = 1000*pre(n) + 1; end when; end M;",
            "R439",
        ),
    ],
)
def test_integers_are_exact_or_refused(backend: Backend, text: str, code: str | None) -> None:
    try:
        ended = run(text, backend).ended
        found = None if ended is None else ended.code
    except PlanarcError as problem:
        found = problem.diagnostics[0].code
    assert found == code


def test_a_parameter_takes_no_integer_that_is_not_exact(backend: Backend) -> None:
    model = compiler.compile_model(Request(text="model M parameter Integer n = 1; end M;"), backend)
    with pytest.raises(PlanarcError, match="below 2\\^53"):
        compiler.run(model, RunOptions(backend=backend, values={"n": 1e17}))
