"""Iterators without a range, and reductions."""

from __future__ import annotations

import pytest

import planarc

DEDUCED = {
    "a loop over a vector": (
        'Real v[2]={1, 2}; equation for i loop assert(v[i, i] > 0, ""); end for',
        "v",
        1,
        2,
    ),
    "a sum of a number": ("Real z=1; Real x=sum(z[i] for i)", "z", 0, 1),
    "components": (
        "Modelica.Blocks.Sources.Constant c[2](each k=1); Real x=sum(c[i, i].y for i)",
        "c",
        1,
        2,
    ),
    "a function": (
        "function f input Real u[2]; output Real y; algorithm for i loop y := u[i, i]; end for; "
        "end f; Real x=f({1, time})",
        "u",
        1,
        2,
    ),
}


@pytest.mark.parametrize(("body", "name", "has", "given"), DEDUCED.values(), ids=DEDUCED)
def test_an_iterator_indexes_a_dimension_that_is_there(
    body: str, name: str, has: int, given: int
) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        planarc.load(f"model M\n  {body};\nend M;\n")
    (found,) = caught.value.diagnostics
    assert found.code == "F218"
    assert found.message.startswith(f"`{name}` has {has} dimension")
    assert found.message.endswith(f", not {given}")


@pytest.mark.parametrize(
    "declared",
    [
        "parameter Integer k=sum(m[i] for i in 1:n)",
        "parameter Integer k=1 - product(i for i in 1:n)",
        "parameter Integer k=sum(i*j for i in 1:2, j in 1:n)",
        "parameter Integer k=sum(m[i] for i)",
        "block B output Integer y=1; end B; B c[n]; Integer k=sum(c[i].y for i in 1:n)",
        "Boolean b[n]; Integer k=sum(if b[i] then 1 else 0 for i in 1:n)",
        "parameter Real k=sum(m[i] for i in 1:n)",
    ],
)
def test_a_sum_of_no_integers_is_an_integer(declared: str) -> None:
    head = "parameter Integer n=0; parameter Integer m[n]=fill(1, n);"
    body = f"{head} {declared}; Real x=k + time;"
    assert planarc.load(f"model M\n  {body}\nend M;\n").simulate(1.0)["x"][-1] == 1


def test_a_sum_of_no_reals_is_a_real() -> None:
    body = "Real v[0]; Integer k=sum(v[i] for i in 1:0);"
    with pytest.raises(planarc.PlanarcError, match="must be of type Integer, but is Real"):
        planarc.load(f"model M\n  {body}\nend M;\n")


@pytest.mark.parametrize(
    "declared",
    [
        "parameter Integer a[:]={i for i in 1:0}",
        "parameter Integer a[:]={m[i] for i in 1:0}",
        "parameter Boolean a[:]={i > 2 for i in 1:0}",
        'parameter String a[:]={"a" for i in 1:0}',
        "type E=enumeration(p, q); parameter E a[:]={E.p for i in 1:0}",
        "record R Integer n; end R; R a[:]={R(i) for i in 1:0}",
        "function f input Integer n; output Integer k; protected Integer v[:]={i*i for i in 1:n}; "
        "algorithm k := sum(v); end f; constant Integer a[f(0)]={m[i] for i in 1:f(0)}",
    ],
)
def test_an_array_of_no_entries_has_the_type_that_these_would_have(declared: str) -> None:
    body = f"parameter Integer m[0]; {declared}; Real x=size(a, 1) + time;"
    assert planarc.load(f"model M\n  {body}\nend M;\n").simulate(1.0)["x"][-1] == 1


@pytest.mark.parametrize(
    ("entries", "sizes"),
    [
        ("{{i, 2} for i in 1:0}", [0, 2]),
        ("{i + j for i in 1:0, j in 1:3}", [3, 0]),
        ("{i + j for i in 1:3, j in 1:0}", [0, 3]),
        ("{fill(i, 2, 3) for i in 1:0}", [0, 2, 3]),
    ],
)
def test_an_array_of_no_entries_has_their_sizes(entries: str, sizes: list[int]) -> None:
    body = f"Integer a[{', '.join(':' for _ in sizes)}]={entries}; Integer n[:]=size(a);"
    result = planarc.load(f"model M\n  {body}\nend M;\n").simulate(1.0)
    assert [result[f"n[{k + 1}]"][-1] for k in range(len(sizes))] == sizes


def test_entries_that_are_not_there_must_fit() -> None:
    body = "parameter Integer a[:]={0.5*i for i in 1:0};"
    with pytest.raises(planarc.PlanarcError, match=r"of type Integer\[:\], but is Real\[0\]"):
        planarc.load(f"model M\n  {body}\nend M;\n")
