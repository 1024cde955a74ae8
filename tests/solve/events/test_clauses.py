"""What when-clauses set: who gives a discrete variable its value, and when it is kept."""

from __future__ import annotations

import math
from typing import Any

import pytest

import planarc
from planarc.core.diagnostic import PlanarcError
from planarc.evaluate.tape import Assigning
from planarc.instance.reactor import Reactor


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def run(body: str, backend: str, stop: float) -> planarc.Result:
    return planarc.load(f"model M\n{body}\nend M;", backend=backend).simulate(stop, intervals=10)


@pytest.mark.parametrize("equation", ["a = b;", "b = a;", "2*b = 2*a;"])
@pytest.mark.parametrize("kind", ["Integer", "discrete Real", "Real"])
def test_an_equation_takes_the_value_that_a_clause_sets(
    backend: str, kind: str, equation: str
) -> None:
    if kind == "Integer":
        equation = equation.replace("2*", "")
    result = run(
        f"""
  Integer a(start=0, fixed=true);
  {kind} b;
equation
  {equation}
  when sample(0.5, 0.5) then
    a = pre(a) + 1;
  end when;""",
        backend,
        1.8,
    )
    assert result["a"][-1] == result["b"][-1] == 3


def test_a_connection_takes_the_value_that_a_clause_sets(backend: str) -> None:
    result = run(
        """
  connector Out = output Integer;
  connector In = input Integer;
  model Counter
    Out y(start=0, fixed=true);
  equation
    when sample(0.5, 0.5) then
      y = pre(y) + 1;
    end when;
  end Counter;
  model Doubler
    In u;
    Out y;
  equation
    y = 2*u;
  end Doubler;
  Counter counter;
  Doubler doubler;
equation
  connect(counter.y, doubler.u);""",
        backend,
        1.8,
    )
    assert [result[n][-1] for n in ("counter.y", "doubler.u", "doubler.y")] == [3, 3, 6]


def test_two_values_for_one_variable_are_refused() -> None:
    with pytest.raises(PlanarcError) as caught:
        run(
            """
  Integer a(start=0, fixed=true), b(start=0, fixed=true);
equation
  a = 7;
  when sample(0.5, 0.5) then
    a = pre(a) + 1;
  end when;""",
            "numpy",
            1.0,
        )
    (found,) = caught.value.diagnostics
    assert found.code == "S314"
    assert "a when-clause sets `a`" in found.message
    assert [found.span.line, found.related[0].span.line] == [5, 6]


def test_an_algorithm_may_set_what_its_own_clause_sets(backend: str) -> None:
    """Outside of the instant the plain assignment holds."""
    result = run(
        """
  Integer a(start=0, fixed=true), n(start=0, fixed=true);
algorithm
  a := 1;
  when sample(0.5, 0.5) then
    a := 5;
  end when;
  n := pre(n) + (if a == 5 and pre(a) == 1 then 1 else 0);""",
        backend,
        1.8,
    )
    assert result["a"][-1] == 1


@pytest.mark.parametrize("equation", ["p - n = d", "d = p - n", "0 = p - n - d"])
def test_a_clause_variable_in_an_equation_of_continuous_ones(backend: str, equation: str) -> None:
    result = run(
        f"""
  Real d(start=0, fixed=true), p, n;
equation
  p = 3 + time;
  {equation};
  when sample(0.5, 0.5) then
    d = pre(d) + 1;
  end when;""",
        backend,
        1.8,
    )
    assert result["n"][-1] == pytest.approx(3 + 1.8 - 3, abs=1e-12)


def test_what_no_clause_sets_in_the_end_is_kept(backend: str) -> None:
    """The second clause takes back what made the first one act: one instant, one solution."""
    result = run(
        """
  Real x(start=-1, fixed=true);
  Boolean z(start=true, fixed=true), v(start=true, fixed=true);
equation
  der(x) = 1;
  when x > 0 and z then
    v = false;
  end when;
  when x > 0 then
    z = false;
  end when;""",
        backend,
        2.0,
    )
    assert result["z"][-1] == 0
    assert result["v"].tolist() == [1.0] * len(result.time)


@pytest.mark.parametrize("rest", ["", "Boolean late = time > 5;"])
def test_the_start_ends(backend: str, rest: str) -> None:
    result = run(
        f"""
  Real x(start=0, fixed=true);
  {rest}
equation
  der(x) = if initial() then 1 else -1;""",
        backend,
        1.0,
    )
    assert result["x"][-1] == pytest.approx(-1.0, abs=1e-12)


@pytest.mark.parametrize("action", ["e = x", "reinit(x, 5)"])
def test_what_is_set_at_the_end_stands_in_the_last_row(backend: str, action: str) -> None:
    result = run(
        f"""
  Real x(start=0, fixed=true), e(start=-1, fixed={"true" if "e =" in action else "false"});
equation
  der(x) = 1;
  when {{terminal(), time > 5}} then
    {action};
  end when;
  {"" if "e =" in action else "e = 5 - x;"}""",
        backend,
        2.0,
    )
    assert result.time[-2:].tolist() == [2.0, 2.0]
    before, after = (2.0, 2.0) if "e =" in action else (2.0, 5.0)
    assert result["x"][-2:] == pytest.approx([before, after], abs=1e-9)
    first, last = (-1.0, 2.0) if "e =" in action else (3.0, 0.0)
    assert result["e"][-2:] == pytest.approx([first, last], abs=1e-9)


def test_an_end_that_sets_nothing_has_no_row_of_its_own(backend: str) -> None:
    result = run(
        """
  Real x(start=0, fixed=true);
equation
  der(x) = 1;
  when terminal() then
    assert(x > 1, "too short");
  end when;""",
        backend,
        2.0,
    )
    assert len(result.time) == 11


def test_the_end_counts_outside_of_clauses_too(backend: str) -> None:
    result = run("Real x = if terminal() then 2 else 1;", backend, 1.0)
    assert result["x"].tolist() == [1.0] * 11 + [2.0]


def test_each_of_several_conditions_triggers_by_itself(backend: str) -> None:
    """Conditions that become true one pass after the other, or after one that is true already."""
    result = run(
        """
  Boolean a = time > 0.5, b = pre(a);
  Integer n(start=0, fixed=true), k(start=0, fixed=true);
equation
  when {a, b} then
    n = pre(n) + 1;
  end when;
  when {time < 5, sample(0, 0.4)} then
    k = pre(k) + 1;
  end when;""",
        backend,
        1.0,
    )
    assert result["n"][-1] == 2
    assert result["k"][-1] == 3


def test_initial_equations_of_discrete_variables_may_hang_on_unknowns(backend: str) -> None:
    """Where the discrete variable is fixed, it is the unknown that follows."""
    result = run(
        """
  discrete Real d, e(start=9, fixed=true);
  Integer k;
  Boolean high;
  Real x(start=2), y(start=1);
initial equation
  d = 3*x;
  k = integer(x + 0.5);
  high = x > 1;
  e = y;
equation
  der(x) = 1;
  der(y) = 0;
  when time > 0.5 then
    d = 0;
    k = pre(k) + 1;
    high = not pre(high);
    e = 1;
  end when;""",
        backend,
        1.0,
    )
    found = {n: (result[n][0], result[n][-1]) for n in ("d", "k", "high", "e", "y")}
    assert found == {"d": (6, 0), "k": (2, 3), "high": (1, 0), "e": (9, 1), "y": (9, 9)}


BUFFER = """
  constant Integer n = 500;
  Real buffer[n](start = zeros(n), each fixed = true);
  Integer k(start = 0, fixed = true), later(start = 0, fixed = true);
  discrete Real total(start = 0, fixed = true);
  Real x = exp(-time);
algorithm
  when {sample(0.01, 0.01), x < 0.9} then
    k := pre(k) + 1;
    buffer[k] := x;
    total := sum(buffer) + later;
  end when;
equation
  when sample(0.01, 0.01) then
    later = pre(later) + k;
  end when;"""


def test_passes_of_one_instant_do_long_branches_once(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As code they are done again where they read something new: `later`, in a second pass."""
    calls: list[float] = []
    plain = Assigning.__call__

    def counted(self: Assigning, w: Any, t: float) -> int:
        if len(self.parts) > 1:
            calls.append(t)
        return plain(self, w, t)

    monkeypatch.setattr(Assigning, "__call__", counted)
    monkeypatch.setattr(Reactor, "react", lambda *_: None)  # Python decides
    result = run(BUFFER, backend, 1.0)
    clock = [i / 100 for i in range(1, 101)]
    instants = sorted([*clock, -math.log(0.9)])
    later = sum(instants.index(t) + 1 for t in clock)
    expected = [math.exp(-t) for t in instants]
    assert [result[f"buffer[{i + 1}]"][-1] for i in range(101)] == pytest.approx(expected, rel=1e-5)
    assert (result["k"][-1], result["later"][-1]) == (101, later)
    assert result["total"][-1] == pytest.approx(sum(expected) + later, rel=1e-6)
    if backend == "native":
        assert len(set(calls)) > 80
        assert len(calls) <= 2 * len(set(calls))


def test_many_variables_keep_the_values_that_no_clause_sets(backend: str) -> None:
    """Each of ten is set by a clause of its own, at another instant."""
    result = run(
        """
  Integer a[10](each start=0, each fixed=true);
equation
  for i in 1:10 loop
    when sample(0.1*i, 1) then
      a[i] = pre(a[i]) + i;
    end when;
  end for;""",
        backend,
        1.55,
    )
    assert [result[f"a[{i}]"][-1] for i in range(1, 11)] == [2, 4, 6, 8, 10, 6, 7, 8, 9, 10]


UNIT_DELAY = """
  block UnitDelay
    input Real u;
    output Real y(start=0, fixed=true);
  equation
    when sample(0.1, 0.1) then
      y = pre(u);
    end when;
  end UnitDelay;
"""
#: What each model keeps of what, just behind the instants 0.1, 0.2, ...
LEFTS = {
    "one behind another": ("UnitDelay a, b; equation a.u = 1; b.u = a.y;", "b.y", [0, 1, 1, 1]),
    "a sum": ("UnitDelay a; equation a.u = a.y + 1;", "a.y", [1, 2, 3, 4]),
    "powers": ("UnitDelay a(y(start=1)); equation a.u = 2*a.y;", "a.y", [2, 4, 8, 16]),
    "a sampled signal": (
        "discrete Real s(start=0, fixed=true); UnitDelay a; equation a.u = s;"
        " when sample(0.1, 0.1) then s = time; end when;",
        "a.y",
        [0, 0.1, 0.2, 0.3],
    ),
    "a step": (
        "Real u = if time >= 0.2 then 1 else 0; UnitDelay a; equation a.u = u;",
        "a.y",
        [0, 0, 1, 1],
    ),
    "what moves": ("UnitDelay a; equation a.u = 3*time;", "a.y", [0.3, 0.6, 0.9, 1.2]),
    "entries": (
        "UnitDelay a[2]; equation a.u = {-a[2].y, a[1].y + 1};",
        "a[2].y",
        [1, 1, 0, 0],
    ),
}


@pytest.mark.parametrize("case", LEFTS.values(), ids=LEFTS)
@pytest.mark.parametrize("solver", ["auto", "exported"])
def test_a_clause_sees_the_value_before_its_event(
    case: tuple[str, str, list[float]], solver: str, backend: str
) -> None:
    body, name, values = case
    if solver == "exported" and backend == "numpy":
        pytest.skip("what is exported is machine code")
    text = f"model M\n{UNIT_DELAY}\n{body}\nend M;"
    result = planarc.load(text, backend=backend).simulate(0.45, intervals=9, solver=solver)
    found = [result[name][result.time < t][-1] for t in (0.19, 0.29, 0.39, 0.46)]
    assert found == pytest.approx(values, abs=1e-9)


@pytest.mark.parametrize("factor", [-1.0, -0.9, -2.0, 3.0])
@pytest.mark.parametrize("when", ["sample(0.1, 0.1)", "{initial(), sample(0.1, 0.1)}"])
def test_a_linear_loop_through_a_clause_is_solved(backend: str, when: str, factor: float) -> None:
    """y = 2*u and u = 3 + f/2*y: also where passes come back to where they were."""
    result = run(
        f"""
  discrete Real y(start=0, fixed=false);
  Real u = 3 + ({factor})/2*y;
equation
  when {when} then
    y = 2*u;
  end when;""",
        backend,
        0.25,
    )
    assert result["y"][-1] == pytest.approx(6 / (1 - factor))
    if "initial" in when:
        assert result["y"][0] == pytest.approx(6 / (1 - factor))


def test_what_is_differentiated_is_its_own_left_limit() -> None:
    """A clause that turns a speed round needs no other variable for it."""
    from planarc.request.request import Request, open_target
    from planarc.stages import flatten, to_dae

    text = """model Ball
  Real h(start=1, fixed=true), v(start=0, fixed=true), a, u = 2*v;
equation
  der(h) = v;
  der(v) = a;
  a = -9.81;
  when h < 0 then
    reinit(v, -0.5*pre({0}));
  end when;
end Ball;"""
    for name, count in (("v", 0), ("a", 1), ("u", 1)):
        dae = to_dae(flatten(open_target(Request(text=text.replace("{0}", name)))))
        assert sum(d.name.startswith("$left") for d in dae.discretes) == count


#: Conditions that are true from the start on, and may hang on `initial()` in some way; with the
#: number of times at which a clause acts until 1.5 s.
TRUE_AT_THE_START = {
    "whole": ("integer(phi) == 2", 0),
    "changed": ("change(turn)", 1),
    "divided": ("div(turn, 2) >= 1", 0),
    "remainder": ("mod(phi, 1) > 0.25", 1),
    "ceiling": ("ceil(phi) > 1", 0),
    "variable": ("starting", 0),
    "joined": ("initial() and phi > 0", 0),
    "several": ("{starting, turn == 2}", 0),
    "initial": ("initial()", 1),
    "among": ("{turn == 3, initial()}", 2),
}


@pytest.mark.parametrize("section", ["equation", "algorithm"])
@pytest.mark.parametrize("case", TRUE_AT_THE_START.values(), ids=TRUE_AT_THE_START)
@pytest.mark.parametrize("solver", ["auto", "exported"])
def test_only_a_condition_initial_acts_at_the_start(
    backend: str, solver: str, case: tuple[str, int], section: str
) -> None:
    if (backend, solver) == ("numpy", "exported"):
        pytest.skip("what is exported is machine code")
    condition, times = case
    sign = "=" if section == "equation" else ":="
    text = f"""model M
  Real phi(start=2.5, fixed=true);
  Integer turn=integer(phi), n(start=0, fixed=true);
  Boolean starting=initial();
equation
  der(phi) = 1;
{section}
  when {condition} then
    n {sign} pre(n) + 1;
  end when;
end M;"""
    result = planarc.load(text, backend=backend).simulate(1.4, intervals=14, solver=solver)
    assert result["n"][-1] == times
    assert result["n"][0] == ("initial()" in condition and "and" not in condition)
