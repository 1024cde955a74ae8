"""A subscript that is chosen while running ends the run where it is outside, and only there."""

from __future__ import annotations

from typing import Any

import pytest

import planarc
from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request

ARRAY = "  parameter Real a[3] = {1, 2, 3}; Integer i; Real y;"
COUNT = "  i = integer(5*time) + 1;"
FUNCTION = """
  function set input Integer n; output Real y; protected Real t[3] = {0, 0, 0};
  algorithm t[n] := 5; y := t[1] + t[2] + t[3]; end set;
  function at input Real t[:]; input Integer n; output Real y;
  algorithm y := if n < 1 then -1 elseif n > size(t, 1) then -2 else t[n]; end at;
"""


def run(declarations: str, body: str, backend: Backend = Backend.NUMPY) -> Any:
    text = f"model M\n{declarations}\n{body}\nend M;"
    compiled = compiler.compile_model(Request(text=text), backend)
    return compiler.run(compiled, RunOptions(stop=1.0, intervals=20, backend=backend))


#: Each leaves 1 to 3 at 0.6 s.
OUTSIDE = {
    "read": (ARRAY, f"equation\n{COUNT}\n  y = a[i];"),
    "matrix": (
        "  parameter Real m[3, 2] = {{1, 2}, {3, 4}, {5, 6}}; Integer i; Real y;",
        f"equation\n{COUNT}\n  y = sum(m[i, :]);",
    ),
    "assigned": (
        "  Integer i; Real t[3];",
        f"equation\n{COUNT}\nalgorithm\n  t := {{0, 0, 0}};\n  t[i] := 5;",
    ),
    "when algorithm": (
        "  Integer i(start=1, fixed=true); discrete Real b[3](each start=0, each fixed=true);",
        "algorithm\n  when sample(0.1, 0.25) then\n    i := pre(i) + 1;\n    b[i] := time;\n"
        "  end when;",
    ),
    "when equation": (
        "  parameter Real a[3] = {1, 2, 3}; discrete Real y(start=0, fixed=true);"
        " Integer i(start=0, fixed=true);",
        "equation\n  when sample(0, 0.2) then\n    y = a[i];\n    i = pre(i) + 1;\n  end when;",
    ),
    "function": (ARRAY + FUNCTION, f"equation\n{COUNT}\n  y = set(i);"),
}


@pytest.mark.parametrize("backend", list(Backend))
@pytest.mark.parametrize("name", OUTSIDE)
def test_a_subscript_outside_ends_the_run_with_its_line(name: str, backend: Backend) -> None:
    result = run(*OUTSIDE[name], backend)
    assert result.time[-1] == pytest.approx(0.6)
    assert "the subscript 4 is outside of 1 to 3" in result.ended.message
    line = result.ended.span.text
    assert line.endswith(("[i]", "[n]", "[i, :]"))


@pytest.mark.parametrize(
    ("declarations", "body"),
    [
        (ARRAY, f"equation\n{COUNT}\n  y = if i <= 3 then a[i] else 0;"),
        (ARRAY, f"equation\n{COUNT}\n  if i > 3 then y = 0; else y = a[i]; end if;"),
        (ARRAY + FUNCTION, f"equation\n{COUNT}\n  y = at(a, i);"),
        (ARRAY, f"equation\n{COUNT}\nalgorithm\n  if i < 4 then y := a[i]; else y := 0; end if;"),
        # The subscript is only outside while the when is at rest.
        (
            "  parameter Real a[3] = {1, 2, 3}; Integer i; discrete Real y(start=0, fixed=true);",
            f"equation\n{COUNT}\n  when time > 0.5 then\n    y = a[i];\n  end when;",
        ),
        # Only at the start, where it is inside.
        (
            ARRAY + " Real x;",
            f"equation\n{COUNT}\n  y = x; der(x) = 0;\ninitial equation\n  x = a[i];",
        ),
    ],
)
def test_a_subscript_on_a_way_that_is_not_taken_says_nothing(declarations: str, body: str) -> None:
    assert run(declarations, body).ended is None


@pytest.mark.parametrize(
    "branches",
    [
        'if time < 2 then y = 1; else y = 2; assert(false, "never"); end if;',
        'if time < 2 then y = 1; elseif time < 3 then y = 2; assert(false, "never");'
        " else y = 3; end if;",
    ],
)
def test_an_assertion_of_a_branch_holds_only_there(branches: str) -> None:
    assert run("  Real y;", f"equation\n  {branches}").ended is None


def test_a_check_in_a_function_called_at_an_event_is_made_at_the_event_only() -> None:
    function = (
        "function low input Real x; output Real y; algorithm"
        ' assert(x < 0.7, "too late"); y := x; end low;'
    )
    declarations = f"  {function} discrete Real y(start=0, fixed=true);"
    early = run(declarations, "equation\n  when time > 0.5 then\n    y = low(time);\n  end when;")
    late = run(declarations, "equation\n  when time > 0.8 then\n    y = low(time);\n  end when;")
    assert early.ended is None
    assert late.time[-1] == pytest.approx(0.8)
    assert "too late" in late.ended.message


def test_truths_and_literals_choose_entries_of_arrays_with_such_sizes() -> None:
    model = planarc.load(
        """
model M
  type Gear = enumeration(low, high, reverse);
  function f
    input Boolean b;
    output Real y;
  protected
    Real t[Boolean] = {1, 2};
    Real g[Gear] = {1, 2, 3};
  algorithm
    t[b] := 5;
    y := 100*t[false] + 10*t[true] + g[Gear.reverse];
  end f;
  parameter Boolean p = true;
  Boolean b = time > 0.5;
  Gear gear = if b then Gear.reverse else Gear.low;
  Real x[Boolean] = {10, 20};
  Real g[Gear] = {7, 8, 9};
  Real chosen = x[b], fixed_ = x[p], other = g[gear], called = f(b);
  Real set[Boolean];
algorithm
  set := {0, 0};
  set[b] := 1;
end M;""",
        backend="numpy",
    )
    result = model.simulate(1)
    found = {n: (result[n][0], result[n][-1]) for n in ("chosen", "fixed_", "other", "called")}
    assert found == {
        "chosen": (10, 20),
        "fixed_": (20, 20),
        "other": (7, 9),
        "called": (523, 153),
    }
    assert result["set"][[0, -1]].tolist() == [[1, 0], [0, 1]]


#: Legs of 1, 10 and 100 m, and a grid of two by three; k counts 1, 2, 3 at every second.
LEGS = """
model M
  record Pair
    Real a;
    Real b;
  end Pair;
  model Leg
    parameter Real len = 1;
    Real v = len*time;
    Real q[2] = {len, 2*len*time};
    Pair pair(a = v, b = -v);
  end Leg;
  Leg leg[3](len = {1, 10, 100});
  Leg grid[2, 3](len = {{1, 2, 3}, {4, 5, 6}});
  Integer k(start = 1, fixed = true);
  parameter Integer n(fixed = false);
  Pair pair = leg[k].pair;
  Real v = leg[k].v;
  Real other = leg[4 - k].q[2];
  Real both[2] = leg[k].q;
  Real cell = grid[if k > 1 then 2 else 1, k].pair.b;
  Real rate = der(leg[k].v);
  Real chosen = leg[n].len;
  Real twice;
initial equation
  n = 2;
equation
  when sample(1, 1) then
    k = pre(k) + 1;
  end when;
algorithm
  twice := 2*leg[k].v;
end M;
"""


@pytest.mark.parametrize("backend", list(Backend))
def test_members_of_component_arrays_are_chosen_while_running(backend: Backend) -> None:
    options = RunOptions(stop=2.5, intervals=5, backend=backend)
    result: Any = compiler.run(compiler.compile_model(Request(text=LEGS), backend), options)
    length, grid = {1: 1.0, 2: 10.0, 3: 100.0}, {1: 1.0, 2: 5.0, 3: 6.0}
    for t, k in ((0.5, 1), (1.5, 2), (2.5, 3)):
        at = list(result.time).index(t)
        expected = {
            "k": k,
            "pair.a": length[k] * t,
            "pair.b": -length[k] * t,
            "v": length[k] * t,
            "other": 2 * length[4 - k] * t,
            "both[1]": length[k],
            "both[2]": 2 * length[k] * t,
            "cell": -grid[k] * t,
            "rate": length[k],
            "chosen": 10.0,
            "twice": 2 * length[k] * t,
        }
        assert {name: float(result[name][at]) for name in expected} == pytest.approx(expected)


@pytest.mark.parametrize("backend", list(Backend))
def test_a_member_that_is_not_there_ends_the_run(backend: Backend) -> None:
    text = LEGS.replace("Real other = leg[4 - k].q[2];", "Real other = leg[k + 1].v;")
    options = RunOptions(stop=2.5, intervals=5, backend=backend)
    result: Any = compiler.run(compiler.compile_model(Request(text=text), backend), options)
    assert result.ended is not None
    assert "4" in result.ended.message and "1 to 3" in result.ended.message
    assert result.time[-1] == pytest.approx(2.0)
