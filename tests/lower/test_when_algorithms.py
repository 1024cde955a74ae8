"""When-statements of algorithms: what is not assigned on the way taken keeps its value."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(text: str, backend: Backend, stop: float = 1.0) -> Any:
    options = RunOptions(stop=stop, tolerance=1e-9, backend=backend)
    return compiler.run(compiler.compile_model(Request(text=text), backend), options)


def at_samples(result: Any, name: str) -> list[float]:
    """Values between the samples at 0.1, 0.2, ... 0.9."""
    places = np.searchsorted(result.time, 0.1 * np.arange(1, 10) + 0.05)
    return [float(x) for x in result[name][places]]


def test_a_variable_assigned_under_an_if_keeps_its_value_otherwise(backend: Backend) -> None:
    result = run(
        """
model M
  Integer k(start = 0, fixed = true), x(start = 7, fixed = true);
  discrete Real y(start = -1, fixed = true);
algorithm
  when sample(0.1, 0.1) then
    k := pre(k) + 1;
    if k > 5 then
      x := k;
    elseif k == 2 then
      y := time;
    end if;
  end when;
end M;
""",
        backend,
    )
    assert at_samples(result, "x") == [7, 7, 7, 7, 7, 6, 7, 8, 9]
    assert at_samples(result, "y") == pytest.approx([-1, *[0.2] * 8])


def test_a_variable_that_counts_itself_counts_once_an_event(backend: Backend) -> None:
    result = run(
        """
model M
  Integer k(start = 0, fixed = true), twice(start = 0, fixed = true);
algorithm
  when sample(0.1, 0.1) then
    k := k + 1;
    twice := k;
    twice := twice + k;
  end when;
end M;
""",
        backend,
    )
    assert at_samples(result, "k") == list(range(1, 10))
    assert at_samples(result, "twice") == list(range(2, 20, 2))


def test_pre_is_the_value_before_the_event_whatever_was_assigned(backend: Backend) -> None:
    result = run(
        """
model M
  Integer k(start = 0, fixed = true), before(start = 0, fixed = true);
  Boolean b(start = false, fixed = true), rose(start = false, fixed = true);
algorithm
  when sample(0.1, 0.1) then
    k := pre(k) + 1;
    before := pre(k);
    b := k >= 3;
    rose := edge(b);
  end when;
end M;
""",
        backend,
    )
    assert at_samples(result, "before") == list(range(9))
    assert at_samples(result, "rose") == [0, 0, 1, 0, 0, 0, 0, 0, 0]


def test_an_entry_is_chosen_while_running(backend: Backend) -> None:
    result = run(
        """
model M
  Integer k(start = 0, fixed = true);
  discrete Real row[4](each start = 0, each fixed = true);
  discrete Real table[2, 2](each start = 0, each fixed = true);
algorithm
  when sample(0.1, 0.1) then
    k := pre(k) + 1;
    row[mod(k, 4) + 1] := k;
    table[mod(k, 2) + 1, :] := {k, -k};
  end when;
end M;
""",
        backend,
        stop=0.99,
    )
    last = [result[f"row[{i}]"][-1] for i in range(1, 5)]
    assert last == [8, 9, 6, 7]
    assert [result[f"table[{i},{j}]"][-1] for i in (1, 2) for j in (1, 2)] == [8, -8, 9, -9]


def test_an_assertion_under_an_if_is_checked_at_its_event_only(backend: Backend) -> None:
    text = """
model M
  Integer k(start = 0, fixed = true);
algorithm
  when sample(0.1, 0.1) then
    k := pre(k) + 1;
    if k < {least} then
      assert(false, "too early");
    end if;
  end when;
end M;
"""
    assert run(text.replace("{least}", "1"), backend).ended is None
    ended = run(text.replace("{least}", "2"), backend).ended
    assert ended is not None and ended.code == "R430" and "too early" in ended.message


def test_a_condition_asks_for_the_value_before_the_event(backend: Backend) -> None:
    result = run(
        """
model M
  type Light = enumeration(dark, lit);
  Light light(start = Light.dark, fixed = true);
algorithm
  when light == Light.dark and time > 0.2 and time < 0.5 then
    light := Light.lit;
  elsewhen light == Light.lit and time > 0.6 then
    light := Light.dark;
  end when;
end M;
""",
        backend,
    )
    assert at_samples(result, "light") == [1, 2, 2, 2, 2, 1, 1, 1, 1]


def test_whens_that_set_one_variable_act_one_after_the_other(backend: Backend) -> None:
    result = run(
        """
model M
  Integer n(start = 0, fixed = true), at[3](each start = 0, each fixed = true), m;
  Integer late(start = 0, fixed = true);
algorithm
  for i in 1:3 loop
    when {initial(), sample(0.5, 0.5)} then
      n := n + i;
      at[i] := n;
    end when;
  end for;
  when time >= 0.2 then
    late := late + 1;
  end when;
  when time >= 0.2 then
    late := 10*late;
  end when;
  m := n;
end M;
""",
        backend,
    )
    assert [result[f"at[{i}]"][0] for i in (1, 2, 3)] == [1, 3, 6]
    assert [result[f"at[{i}]"][-1] for i in (1, 2, 3)] == [13, 15, 18]  # t = 0.5 and t = 1
    assert at_samples(result, "m") == at_samples(result, "n") == [6] * 4 + [12] * 5
    assert at_samples(result, "late") == [0] + [10] * 8


def test_a_truth_set_by_a_when_lasts_for_its_event_where_it_is_taken_back(backend: Backend) -> None:
    result = run(
        """
model M
  Boolean now;
  Integer n(start = 0, fixed = true);
algorithm
  now := false;
  when sample(0.5, 0.25) then
    now := true;
  end when;
equation
  when now then
    n = pre(n) + 1;
  end when;
end M;
""",
        backend,
    )
    assert at_samples(result, "n") == [0, 0, 0, 0, 1, 1, 2, 2, 2]
    assert not result["now"].any()
