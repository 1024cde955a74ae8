"""Loops whose ends are not known when the model is compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.lower.statements import MAX_STILL, MAX_WAYS, Runner

PARTIAL = """
  function partial_sum "The first n entries"
    input Integer n;
    input Real x[:];
    output Real y;
  algorithm
    y := 0;
    for i in 1:n loop
      y := y + x[i];
    end for;
  end partial_sum;
"""


def run(body: str, stop: float = 1.0) -> planarc.Result:
    model = planarc.load(f"model M\n{body}\nend M;", backend="numpy")
    return model.simulate(stop, intervals=10)


def test_a_function_adds_as_many_entries_as_an_integer_says_while_running() -> None:
    result = run(
        PARTIAL
        + """
  Integer n(start=0, fixed=true);
  Real y = partial_sum(n, {1, 10, 100});
equation
  when sample(0.25, 0.25) then
    n = pre(n) + 1;
  end when;""",
        0.9,
    )
    found = dict(zip(result.time, result["y"], strict=True))
    assert [found[t] for t in (0, 0.25, 0.5, 0.75, 0.9)] == [0, 1, 11, 111, 111]


def test_a_loop_that_goes_beyond_an_array_ends_the_run_there() -> None:
    body = PARTIAL + "Integer n = integer(4*time) + 1; Real y = partial_sum(n, {1, 10});"
    with pytest.raises(planarc.RunStopped, match="subscript 3 is outside of 1 to 2") as stopped:
        run(body)
    assert stopped.value.result.time[-1] == pytest.approx(0.5)


def test_loops_of_algorithms_may_hang_on_one_another_and_run_backwards() -> None:
    result = run(
        """
  Integer n = if time > 0.5 then 3 else 2;
  Real w[3], s, down;
algorithm
  w := {1, 10, 100};
  s := 0;
  for i in 1:n loop
    for j in 1:i loop
      s := s + w[j];
    end for;
  end for;
  down := 0;
  for i in 3:-1:n loop
    down := 10*down + w[i];
  end for;"""
    )
    early, late = result.time < 0.5, result.time > 0.5
    assert (result["s"][early] == 12).all() and (result["s"][late] == 123).all()
    assert (result["down"][early] == 1010).all() and (result["down"][late] == 100).all()


def test_the_turns_of_a_loop_are_bounded_by_what_its_end_can_be() -> None:
    result = run(
        """
  function f
    input Real x;
    output Real y;
  algorithm
    y := 0;
    for i in 1:integer(floor(2*sin(x) + min(x, 3))) loop
      y := y + i;
    end for;
  end f;
  Real y = f(5*time);"""
    )
    from math import floor, sin

    for t, y in zip(result.time, result["y"], strict=True):
        n = max(0, floor(2 * sin(5 * t) + min(5 * t, 3)))
        assert y == n * (n + 1) / 2


def test_ends_that_are_declared_or_set_equal_to_numbers_are_known() -> None:
    result = run(
        """
  parameter Integer p = 2;
  Integer m = p + 1, k;
  Real x, y;
equation
  k = 2;
algorithm
  x := 0;
  for i in 1:m loop
    x := x + i*time;
  end for;
  y := sum(i*time for i in 1:k);"""
    )
    assert result["x"][-1] == 6
    assert result["y"][-1] == 3


def test_a_loop_without_a_bound_stays_a_loop() -> None:
    body = """
  Integer n = integer(time);
  Real s;
algorithm
  s := 0;
  for i in 1:n loop
    s := s + i;
  end for;"""
    result = run(body, 2000)
    assert result["s"] == pytest.approx(result["n"] * (result["n"] + 1) / 2)


def test_a_course_that_is_not_known_is_looked_for_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Each of three outputs is a call of its own, with the same arguments."""
    text = """model M
  function halved
    input Real x;
    output Real a = x;
    output Real b = 0;
    output Real c = 1;
  algorithm
    while a > 1 loop
      a := a/2;
      b := b + 1;
      c := 2*c;
    end while;
  end halved;
  parameter Real p = 40;
  parameter Real a(fixed=false), b(fixed=false), c(fixed=false);
initial equation
  (a, b, c) = halved(p);
end M;"""
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path))  # a remembered model looks for nothing
    ways = counted_ways(monkeypatch)
    result = planarc.load(text).simulate(1)
    assert [result[name][0] for name in "abc"] == [40 / 64, 6, 64]
    assert len(ways) == MAX_WAYS


def counted_ways(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The ways of each call so far, one a way."""
    ways: list[int] = []
    plain = Runner.split

    def counted(self: Runner, *args: Any) -> Runner:
        ways.append(self.ways[0])
        return plain(self, *args)

    monkeypatch.setattr(Runner, "split", counted)
    return ways


ROOT = """
  function root "Of x^3 = c, by halving"
    input Real c;
    output Real x;
  protected
    Real low = 0, high = 8;
    Boolean found = false;
  algorithm
    while CONDITION loop
      x := (low + high)/2;
      if high - low < 1e-9 then
        ENOUGH
      elseif x^3 < c then
        low := x;
      else
        high := x;
      end if;
    end while;
  end root;
"""


@pytest.mark.parametrize(
    ("condition", "enough"), [("not found", "found := true;"), ("true", "break;")]
)
def test_a_search_in_which_nothing_known_changes_is_given_up_soon_and_stays_a_loop(
    condition: str, enough: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path))
    ways = counted_ways(monkeypatch)
    body = ROOT.replace("CONDITION", condition).replace("ENOUGH", enough)
    assert run(f"{body}\nparameter Real c = 27; Real x = root(c);")["x"][0] == pytest.approx(3)
    assert len(ways) < 3 * MAX_STILL < MAX_WAYS
    moving = run(f"{body}\nReal x = root(time);")
    assert moving["x"] == pytest.approx(np.cbrt(moving.time), abs=2e-9)


def test_a_loop_that_counts_from_what_is_not_known_goes_on_as_far_as_it_must() -> None:
    result = run(
        f"""
  function next "The first of {MAX_STILL + 20} numbers from n on that is not below x"
    input Real n;
    input Real x;
    output Real y = n;
  algorithm
    while y - n < {MAX_STILL + 20} loop
      if y >= x then
        break;
      end if;
      y := y + 1;
    end while;
  end next;
  Real y = next(10*time, 30), z = next(10*time, 100);"""
    )
    assert result["y"] == pytest.approx([30] * 11)
    assert result["z"] == pytest.approx([min(100, 10 * t + MAX_STILL + 20) for t in result.time])


WHILE = """
  parameter Integer n = 3;
  parameter Real gain = 2;
  Integer k, first, count(start=0);
  Real d;
algorithm
  d := 0;
  k := n + 1;
  while k > 0 loop
    d := d + gain*time;
    if d > 4*k then
      d := d - 1;
    end if;
    k := k - 1;
  end while;
algorithm
  when time > 0.5 then
    first := n;
    count := 0;
    while first > 1 loop
      count := count + first;
      first := first - 1;
    end while;
  end when;"""


def by_hand(n: int, time: float) -> float:
    d = 0.0
    for k in range(n + 1, 0, -1):
        d += 2 * time
        d -= d > 4 * k
    return d


def test_parameters_that_say_how_often_an_algorithm_turns_become_structural() -> None:
    model = planarc.load(f"model M\n{WHILE}\nend M;", backend="numpy")
    for n in (3, 5):
        result = model.variant({"n": str(n)}).simulate(1, intervals=10)
        for t in (0.3, 0.7, 0.9):
            assert result.at("d", t) == pytest.approx(by_hand(n, t))
        assert result["count"][-1] == n * (n + 1) / 2 - 1
    slots = {p.name: p for p in model.program.parameter_slots}
    assert slots["n"].structural
    assert slots["gain"].settable


def test_an_initial_algorithm_turns_as_often_as_a_parameter_says() -> None:
    result = run(
        """
  parameter Integer n = 3;
  parameter Real p(fixed=false);
initial algorithm
  p := 1;
  while p < n loop
    p := 2*p;
  end while;"""
    )
    assert result["p"][0] == 4


def test_a_course_is_not_taken_from_the_guess_of_a_parameter_that_is_solved_for() -> None:
    body = """
  parameter Real r(fixed=false, start=2);
  Integer k;
algorithm
  k := integer(r + 0.5);
  while k > 0 loop
    k := k - 1;
  end while;
initial equation
  r*r = 9;"""
    with pytest.raises(planarc.PlanarcError, match="of which nothing says when it ends"):
        run(body)
