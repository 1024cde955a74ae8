"""Variables of functions are their own, whatever the variables of the model are called."""

from __future__ import annotations

import pytest

import planarc

#: An array whose size is an input.
PARTS = """
  function f input Integer n; output Real y[n];
  algorithm for i in 1:n loop y[i] := i/n; end for; end f;
"""
#: One whose size is a local that is declared behind it.
TWICE = """
  function f input Real x[:]; output Real y[n]; protected Integer n = size(x, 1);
  algorithm for i in 1:n loop y[i] := 2*x[i]; end for; end f;
"""
#: A local that is read before it has a value.
EARLY = """
  function f input Real x; output Real y; protected Real a;
  algorithm y := a + x; a := x; end f;
"""


def last(body: str) -> float:
    return float(planarc.load(f"model M {body} end M;").simulate(1)["z"][-1])


@pytest.mark.parametrize(
    ("body", "z"),
    [
        (PARTS + "parameter Integer m = 3; Real y[4] = f(4); Real z = sum(f(m));", 2.0),
        (PARTS + "parameter Integer m = 3; Real y[4] = {time, 2, 3, 4}; Real z = sum(f(m));", 2.0),
        (PARTS + "parameter Integer n = 3; Real y[2] = {time, 2}; Real z = sum(f(n));", 2.0),
        (TWICE + "Real z = sum(f({1, time, 3}));", 10.0),
        (TWICE + "parameter Integer n = 5; Real z = sum(f({1, time, 3}));", 10.0),
        (
            "function f input Integer k; output Real y[k]; protected Real a[k];"
            " algorithm a := fill(1.0, k); y := a*2; end f;"
            " parameter Integer p = 2; Real a[3] = {time, 2, 3}; Real z = sum(f(p));",
            4.0,
        ),
    ],
)
def test_a_name_of_the_model_means_nothing_in_a_function(body: str, z: float) -> None:
    assert last(body) == pytest.approx(z, rel=1e-14)


@pytest.mark.parametrize("other", ["", "Real a = 17;", "constant Real a = 17;"])
@pytest.mark.parametrize("argument", ["time", "2"])
def test_a_local_without_a_value_is_told(other: str, argument: str) -> None:
    with pytest.raises(planarc.PlanarcError, match=r"L301.*`a` is used before it has a value"):
        planarc.load(f"model M {EARLY} {other} Real z = f({argument}); end M;")


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (EARLY, "`a` is used before it has a value"),
        (
            "function f input Real x; output Real y;"
            " algorithm if x > 3 then y := 1; end if; end f;",
            "`M.f` gives its output `y` no value",
        ),
    ],
)
def test_sizes_are_not_made_of_what_has_no_value(function: str, reason: str) -> None:
    """It was 0."""
    with pytest.raises(planarc.PlanarcError, match="F281") as caught:
        planarc.load(f"model M {function} Real w[integer(f(2))]; equation w = fill(1.0, 2); end M;")
    assert reason in caught.value.diagnostics[0].message
