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
