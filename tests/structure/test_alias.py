"""Alias elimination: what vanishes, what stays, and whose name it bears."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir.dae import Dae
from planarc.ir.expr import text
from planarc.ir.sorted import SortedDae
from planarc.structure.alias import eliminate_aliases
from planarc.structure.signs import Signs

Make = Callable[..., Dae]
Sort = Callable[..., SortedDae]


def _aliases(dae: Dae) -> dict[str, str]:
    found = eliminate_aliases(dae, Signs(dae.parameters)).aliases
    return {a.name: ("-" if a.sign < 0 else "") + text(a.target) for a in found}


@pytest.mark.parametrize(
    ("equations", "expected"),
    [
        (["a = b", "der(a) = sin(a)"], {"b": "a"}),
        (["0 = a + b", "der(a) = sin(a)"], {"b": "-a"}),
        (["2*a = -2*b", "der(a) = sin(a)"], {"b": "-a"}),
        (["a = b", "b = -c", "c = d", "der(a) = 1"], {"b": "a", "c": "-a", "d": "-a"}),
        (["a = p", "b = 2*a + 1"], {"a": "p", "b": "2*p + 1"}),
        (["2*a = 3"], {"a": "1.5"}),
        (["v = der(x)", "a = der(v)", "a = -sin(x)"], {"v": "der(x)", "a": "der(der(x))"}),
        (["v = -der(x)", "u = der(v)", "u = sin(x)"], {"v": "-der(x)", "u": "-der(der(x))"}),
        (["0 = f1 + f2 + f3", "f3 = 0", "f1 = time"], {"f3": "0", "f2": "-f1"}),
        (["a = time", "b = 2*a"], {}),  # changes with time: computed, not an alias
        (["a = sin(b)", "der(b) = a + 1"], {}),
        (["a = sin(b)", "der(b) = a"], {"a": "der(b)"}),
        (["p*a = p*b", "der(a) = 1"], {}),  # says nothing when p is set to 0
        (["p*a = 1"], {}),
        (["a*a = 4"], {}),  # a curved equation keeps both branches
        (["2*a = b", "der(a) = 1"], {}),
        (["x = -x", "y = x"], {"x": "0", "y": "0"}),
        (["der(x) = x"], {}),
        (["a = event[0]", "b = a"], {"b": "a"}),
    ],
)
def test_what_is_eliminated(make: Make, equations: list[str], expected: dict[str, str]) -> None:
    assert _aliases(make(*equations, p=2.0)) == expected


def test_the_ends_of_a_long_chain_meet(make: Make) -> None:
    n = 3000
    equations = [f"x{i} = {'-' if i % 2 else ''}x{i + 1}" for i in range(n)]
    found = _aliases(make(*equations, f"der(x{n}) = 1"))
    assert len(found) == n
    assert {v.lstrip("-") for v in found.values()} == {"x0"}


def test_constants_run_through_sums(make: Make) -> None:
    n = 500
    equations = [f"x{i + 1} = x{i} + p" for i in range(n)]
    found = _aliases(make(*reversed(equations), "x0 = 0", p=1.0))
    assert found["x500"] == "500*p"


@pytest.mark.parametrize(
    ("attributes", "kept"),
    [
        ({}, "a"),
        ({"b": {"select": "prefer"}}, "b"),
        ({"a": {"select": "avoid"}}, "b"),
        ({"a": {"protected": True}}, "b"),
        ({"a": {"protected": True}, "b": {"select": "never"}}, "a"),
    ],
)
def test_which_name_stays(make: Make, attributes: dict[str, Any], kept: str) -> None:
    dae = make("a = b", "der(b) = 1", attributes=attributes)
    assert eliminate_aliases(dae, Signs(())).kept == (kept,)


def test_derivatives_of_constants_are_zero(sort: Sort) -> None:
    model = sort("x = p", "v = der(x)", "der(y) = v - y", p=3.0)
    assert [text(c.symbol) for c in model.candidates] == ["y"]
    assert {a.name: text(a.target) for a in model.aliases} == {"x": "p", "v": "0"}


def test_a_sum_over_all_variables_costs_no_more_than_its_size(make: Make) -> None:
    n = 400
    equations = [f"v{i} = der(x{i})" for i in range(n)] + [f"der(v{i}) = 1" for i in range(n)]
    total = " + ".join(f"v{i}^2" for i in range(n))
    dae = make(*equations, f"e = {total}")
    before = len(dae.table.all)
    assert len(_aliases(dae)) == n
    assert len(dae.table.all) - before < 20 * n


# Starts, fixed and StateSelect of a set ----------------------------------------------------


def _candidate(model: SortedDae) -> tuple[str, str, str | None, bool, bool]:
    (c,) = model.candidates
    start = None if c.start is None else text(c.start)
    return text(c.symbol), c.display, start, c.start_written, c.fixed


def test_a_written_start_carries_its_sign(sort: Sort) -> None:
    model = sort("x = -y", "der(x) = -x", attributes={"y": {"start": "p"}}, p=2.0)
    assert _candidate(model) == ("x", "x", "-p", True, False)


def test_a_fixed_start_goes_before_a_written_one(sort: Sort) -> None:
    attributes = {"x": {"start": 1, "select": "prefer"}, "y": {"start": 2, "fixed": True}}
    model = sort("x = y", "der(x) = -x", attributes=attributes)
    assert _candidate(model) == ("x", "x", "2", True, True)


def test_the_start_of_a_derivative_is_that_of_its_name(sort: Sort) -> None:
    attributes = {"w": {"start": 3, "fixed": True, "select": "prefer"}}
    model = sort("w = der(phi)", "der(w) = -phi", attributes=attributes)
    phi, w = model.candidates
    assert (text(w.symbol), w.display, text(w.start or w.symbol)) == ("der(phi)", "w", "3")
    assert w.fixed
    assert not phi.fixed


def test_two_fixed_starts_that_disagree_are_an_error(make: Make, sort: Sort) -> None:
    attributes = {"x": {"start": 1, "fixed": True}, "y": {"start": "p", "fixed": True}}
    with pytest.raises(PlanarcError) as info:
        sort("x = -y", "der(x) = -x", attributes=attributes, p=2.0)
    (d,) = info.value.diagnostics
    assert d.code == "S304"
    assert d.message == (
        "`x` and `y` are held at starts that disagree: `x = -y`, but start = 1 and start = p"
    )
    sort("x = -y", "der(x) = -x", attributes=attributes, p=-1.0)  # these agree


def test_a_constant_held_at_another_value_is_an_error(sort: Sort) -> None:
    with pytest.raises(PlanarcError, match="S305"):
        sort("x = 2", "der(y) = x", attributes={"x": {"start": 1, "fixed": True}})
    sort("x = 2", "der(y) = x", attributes={"x": {"start": 2, "fixed": True}})
