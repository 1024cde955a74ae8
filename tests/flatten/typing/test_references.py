"""What a reference to a member of an array of components means."""

from __future__ import annotations

import pytest

import planarc

CHAINS = """
model Chain parameter Integer n = 1; Real x[n] = {i*time for i in 1:n}; end Chain;
model Square parameter Integer n = 1; Real m[n, n] = identity(n); end Square;
record Row parameter Integer n = 1; Real x[n] = fill(1.0, n); end Row;
model Net parameter Integer n = 1; Chain c[n]; end Net;
Chain a[2](n={3, 2});
Square s[2](n={3, 2});
Row r[2](n={3, 2});
Net b[2](n={1, 2});
"""


@pytest.mark.parametrize(
    "body",
    [
        "Real y[2, 3] = a.x;",
        "Real y[2, 2] = -a.x + 2*a.x;",
        "Real y = sum(transpose(a.x));",
        "Real y = sum(a.x);",
        "Real y[2] = a.x[:]*{1, 2, 3};",
        "Real y[2, 3] = s.m[1, :];",
        "Integer k = size(a.x, 2);",
        "Real y[2, 3]; algorithm y := a.x;",
        "Real y; initial equation y = sum(a.x); equation der(y) = 1;",
        "equation a.x = {{1, 2, 3}, {4, 5, 6}};",
        "Row y[2] = r;",
        "Real y = sum(b.c.n);",
    ],
)
def test_members_of_different_sizes_make_no_array(body: str) -> None:
    with pytest.raises(planarc.PlanarcError, match=r"F272.*have the sizes") as refused:
        planarc.load(f"model M {CHAINS} {body} end M;")
    assert len(refused.value.diagnostics) == 1


def test_entries_that_all_members_have_make_one() -> None:
    result = planarc.load(f"""
    model M {CHAINS}
      Real first[2] = a.x[1]; Real two[2, 2] = a.x[1:2]; Real one = b[2].c[2].x[1];
      Real total = sum(sum(a[i].x) for i in 1:2);
    end M;
    """).simulate(1.0)
    assert [result.at(n, 1.0) for n in ("first[2]", "two[2,2]", "total")] == [1.0, 2.0, 9.0]
