"""Functions whose course hangs on an Integer that chooses an array's entry."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import PlanarcError

SEARCH = """
function search "The next entry from `last` on that is above u, and how far it is"
  input Real table[:];
  input Real u;
  input Integer last;
  output Integer next;
  output Real gap;
algorithm
  next := last;
  while next < size(table, 1) and u >= table[next] loop
    next := next + 1;
  end while;
  gap := table[next] - u;
end search;
model Steps
  parameter Real table[:] = {0.5, 1.0, 1.75, 2.5};
  discrete Integer last(start=1, fixed=true);
  discrete Real gap(start=0, fixed=true);
algorithm
  when sample(0.25, 0.5) then
    (last, gap) := search(table, time, LAST);
  end when;
end Steps;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_search_goes_on_from_where_it_was(backend: str) -> None:
    model = planarc.load(SEARCH.replace("LAST", "pre(last)"), backend=backend)
    result = model.simulate(3.0, intervals=600)
    table = np.array([0.5, 1.0, 1.75, 2.5])
    for at in np.arange(0.25, 3.0, 0.5):
        row = np.flatnonzero(np.isclose(result.time, at + 0.1))[-1]
        found = min(int(np.searchsorted(table, at, side="right")) + 1, 4)
        assert result["last"][row] == found
        assert result["gap"][row] == pytest.approx(table[found - 1] - at, abs=1e-12)


def test_an_integer_that_chooses_no_entry_may_be_counted_down() -> None:
    counting = """
    function halvings
      input Integer n;
      output Integer k = 0;
    protected
      Integer m = n;
    algorithm
      while m > 1 loop
        m := integer(m/2);
        k := k + 1;
      end while;
    end halvings;
    model M
      discrete Integer n(start=5, fixed=true);
      Integer k = halvings(n);
    equation
      when sample(0, 1) then
        n = pre(n) + 1;
      end when;
    end M;
    """
    result = planarc.load(counting).simulate(12)
    assert result["n"][-1] == 18
    assert list(result["k"]) == [math.floor(math.log2(n)) for n in result["n"]]


SLICES = """
model M
  function chosen "The product of the first m entries, or the entry from m on that is positive"
    input Integer m;
    input Real a[3], b[3];
    input Boolean product;
    output Real y;
  protected
    Integer i = m;
  algorithm
    if product then
      y := a[1:m]*b[1:m];
    else
      while a[i] < 0 loop
        i := i + 1;
      end while;
      y := a[i];
    end if;
  end chosen;
  Integer m = integer(4*time) + FIRST;
  Real y = chosen(m, {1, 2, 3}, {4, 5, 6}, PRODUCT);
end M;
"""


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_slices_may_end_at_an_integer_that_varies(backend: str) -> None:
    text = SLICES.replace("FIRST", "0").replace("PRODUCT", "true")
    result = planarc.load(text, backend=backend).simulate(0.9, intervals=9)
    for t, y in zip(result.time, result["y"], strict=True):
        if not np.isclose(4 * t, np.round(4 * t)):
            assert y == [0, 4, 14, 32][int(4 * t)]


@pytest.mark.parametrize(("first", "at"), [(0, 0.0), (1, 0.75)])
def test_a_run_ends_where_an_integer_chooses_no_entry(first: int, at: float) -> None:
    text = SLICES.replace("FIRST", str(first)).replace("PRODUCT", "false")
    message = f"the subscript {4 * first} is outside of 1 to 3"
    with pytest.raises(PlanarcError, match=message) as refused:
        planarc.load(text, backend="numpy").simulate(1.0)
    assert refused.value.diagnostics[0].code == "R430"
    if isinstance(refused.value, planarc.RunStopped):
        assert refused.value.result.time[-1] == pytest.approx(at)
