"""Arrays of functions declared with `:`, which begin empty and take the size of their values."""

from __future__ import annotations

import pytest

from planarc import compiler
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request

ABOVE = """
  function above input Real x[:]; input Real limit; output Real y[:];
  algorithm
    for e in x loop
      if e > limit then y := cat(1, y, {e}); end if;
    end for;
  end above;
"""
PRIMES = """
  function primes input Integer n; output Integer p[:];
  protected Boolean found;
  algorithm
    for k in 2:n loop
      found := true;
      for q in p loop
        if mod(k, q) == 0 then found := false; end if;
      end for;
      if found then p := cat(1, p, {k}); end if;
    end for;
  end primes;
"""


@pytest.mark.parametrize("backend", list(Backend))
@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        (f"{ABOVE} parameter Real limit = 2; Real v[:] = above({{1, 3, 2, 5}}, limit);", [3, 5]),
        (f"{ABOVE} parameter Real limit = 9; Real v[:] = above({{1, 3}}, limit);", []),
        (f"{PRIMES} parameter Integer v[:] = primes(12);", [2, 3, 5, 7, 11]),
        (
            f"{PRIMES} Integer v[:](start = primes(4), each fixed = true);"
            " equation when time > 2 then v = pre(v); end when;",
            [2, 3],
        ),
        (f"{PRIMES} parameter Integer n = 6; Integer v[1] = {{sum(primes(n))}};", [10]),
    ],
)
def test_an_array_that_grows_has_the_size_of_its_last_value(
    backend: Backend, declared: str, expected: list[float]
) -> None:
    model = f"model M {declared} end M;"
    options = RunOptions(stop=1, intervals=2, backend=backend)
    result = compiler.run(compiler.compile_model(Request(text=model), backend), options)
    found = [result[f"v[{k + 1}]"][-1] for k in range(len(expected))]
    assert found == expected
    assert f"v[{len(expected) + 1}]" not in result


def test_a_size_that_changes_while_running_is_refused() -> None:
    model = f"model M {ABOVE} Real v = sum(above({{1, 3}}, time)); end M;"
    with pytest.raises(PlanarcError) as problem:
        compiler.compile_model(Request(text=model), Backend.NUMPY)
    assert problem.value.diagnostics[0].code in ("L301", "L321")
