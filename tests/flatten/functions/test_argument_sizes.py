"""Arrays that are given to a function have the sizes that its other arguments say."""

from __future__ import annotations

import pytest

import planarc

TEXT = """
function total
  input Integer n;
  input Real x[n];
  output Real y;
algorithm
  y := sum(x);
end total;
function weighted
  input Real x[:];
  input Real w[size(x, 1)];
  output Real y;
algorithm
  y := x*w;
end weighted;
function solved
  input Real A[:, size(A, 1)];
  input Real b[size(A, 1)];
  output Real y[size(A, 1)];
algorithm
  y := A*b;
end solved;
function through
  input Real x[:];
  output Real y;
algorithm
  y := weighted(x, {1, 2});
end through;
"""
REFUSED = {
    "a number": ("Real y=total(3, {1, time})", "F270", "Real[3]"),
    "another array": ("Real y=weighted({1, time}, {1, 2, 3})", "F270", "Real[2]"),
    "a matrix": ("Real y[2]=solved({{1, 2, 3}, {1, 2, time}}, {1, 2})", "F270", "Real[:, 2]"),
    "a constant": ("constant Integer n=3; Real y=total(n, {1, time})", "L331", "size 3"),
    "in a function": ("Real y=through({1, 2, time})", "L331", "size 3"),
}
ACCEPTED = {
    "a number": "Real y=total(2, {1, time})",
    "another array": "Real y=weighted({1, time}, {1, 2})",
    "a matrix": "Real y[2]=solved({{1, 2}, {1, time}}, {1, 2})",
    "each entry": "Real y[3]=total(2, {{1, 2}, {1, 2}, {1, time}})",
    "in a function": "Real y=through({1, time})",
    "nothing": "Real x[0]; Real y=total(0, x) + time",
}


@pytest.mark.parametrize(("declared", "code", "size"), REFUSED.values(), ids=REFUSED)
def test_another_size_is_refused(declared: str, code: str, size: str) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(f"{TEXT}model M\n  {declared};\nend M;\n", "M")
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert size in found.message


@pytest.mark.parametrize("declared", ACCEPTED.values(), ids=ACCEPTED)
def test_the_same_size_is_accepted(declared: str) -> None:
    planarc.load(f"{TEXT}model M\n  {declared};\nend M;\n", "M")
