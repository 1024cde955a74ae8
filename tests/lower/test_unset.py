"""Variables of functions without a value on some way: whoever asks for one there ends the run."""

from __future__ import annotations

import numpy as np
import pytest

from planarc import compiler
from planarc.core.options import RunOptions
from planarc.ir.result import Result
from planarc.request.request import Request

RESULT = """
  if x > 1 then
    y := 2*x;
  elseif x < 0 then
    y := -1;
  end if;
"""
READ = """
  if x > 1 then
    k := 2;
  end if;
  y := k*x;
"""
#: Read only where it has a value: nothing is wrong.
CHOSEN = """
  if x > 1 then
    k := 2;
  end if;
  y := if x > 1 then k*x else -1;
  if x > 1 then
    y := y + k;
  end if;
"""
SEARCH = """
  for i in 1:3 loop
    if x < i then
      y := i;
      return;
    end if;
  end for;
  y := 10;
"""
#: The other way ends in an assertion, which is told, and not that a value lacks.
ASSERTED = """
  if x < 1 then
    y := x;
  else
    assert(false, "too large");
  end if;
"""
LOOP = """
  for i in 1:3 loop
    if x > i then
      k := x*i;
    end if;
  end for;
  y := k;
"""


def run(body: str, x: str) -> Result:
    text = f"""model M
  function f input Real x; output Real y; protected Real k; algorithm {body}
  end f;
  Real y = f({x}); annotation(experiment(StopTime=4));
end M;"""
    return compiler.run(compiler.compile_model(Request(text=text)), RunOptions(intervals=40))


@pytest.mark.parametrize(
    ("body", "x", "message", "ends"),
    [
        (RESULT, "3 - time", "`M.f` gives its output `y` no value", 2.0),
        (READ, "3 - time", "`k` is used before it has a value", 2.0),
        (ASSERTED, "time", "too large", 1.0),
        (LOOP, "3 - time", "`k` is used before it has a value", 2.0),
    ],
)
def test_a_missing_value_ends_the_run(body: str, x: str, message: str, ends: float) -> None:
    result = run(body, x)
    assert result.ended is not None
    assert result.ended.code == "R430"
    assert message in result.ended.message
    assert ends <= result.time[-1] <= ends + 0.1 + 1e-9


@pytest.mark.parametrize(
    ("body", "law"),
    [
        (CHOSEN, lambda t: np.where(t > 1, 2 * t + 2, -1)),
        (SEARCH, lambda t: np.where(t < 3, np.floor(t) + 1, 10)),
    ],
)
def test_what_is_read_where_it_has_a_value_runs(body: str, law: object) -> None:
    result = run(body, "time")
    assert result.ended is None
    assert not result.program.assertions
    assert callable(law)
    np.testing.assert_allclose(result["y"], law(result.time))
