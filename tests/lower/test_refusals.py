"""Flat models that do not hold together are refused, though `flatten` lets none through."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from planarc.core.diagnostic import PlanarcError
from planarc.core.source import NOWHERE, Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir import flat
from planarc.lower.pipeline import lower
from planarc.parse.parser import parse_annotation, parse_file, parse_text


def flat_model(text: str) -> flat.FlatModel:
    library = Library([], parse_file, parse_annotation)
    (name,) = library.add_file(parse_text(Source("t.mo", text)))
    return flatten(library, name)


def refused(model: flat.FlatModel) -> str:
    with pytest.raises(PlanarcError) as caught:
        lower(model)
    return caught.value.diagnostics[0].code


def number(value: float) -> flat.Expression:
    return flat.Literal(flat.REAL, NOWHERE, value)


def numbers(*values: float) -> flat.Expression:
    items = tuple(map(number, values))
    return flat.Array(flat.Type(flat.Base.REAL, (len(items),)), NOWHERE, items)


def with_equation(text: str, **changes: Any) -> flat.FlatModel:
    """The model with its first equation changed."""
    model = flat_model(text)
    first, *rest = model.equations
    return replace(model, equations=(replace(first, **changes), *rest))


def test_subscripts_of_a_scalar() -> None:
    index = flat.Index(flat.REAL, NOWHERE, number(1), (number(1),))
    assert refused(with_equation("model M Real x; equation x = 1; end M;", right=index)) == "L311"


def test_a_value_of_another_size_than_its_parameter() -> None:
    model = flat_model("model M parameter Real p[2] = {1, 2}; Real x = p[1]; end M;")
    variables = tuple(
        replace(v, binding=numbers(1, 2, 3)) if v.name == "p" else v for v in model.variables
    )
    assert refused(replace(model, variables=variables)) == "L331"


def test_sides_of_different_sizes() -> None:
    text = "model M Real x[2]; equation x = {1, 2}; end M;"
    assert refused(with_equation(text, right=numbers(1, 2, 3))) == "L344"


def test_branches_of_different_length() -> None:
    model = flat_model(
        "model M Real x; equation if time > 1 then x = 1; else x = 2; end if; end M;"
    )
    (equation,) = model.equations
    assert isinstance(equation, flat.IfEquation)
    longer = replace(equation, otherwise=equation.otherwise * 2)
    assert refused(replace(model, equations=(longer,))) == "L345"


def test_a_when_inside_of_a_when() -> None:
    model = flat_model(
        "model M discrete Real x; equation when time > 1 then x = 1; end when; end M;"
    )
    (equation,) = model.equations
    assert isinstance(equation, flat.WhenEquation)
    ((condition, _),) = equation.branches
    nested = replace(equation, branches=((condition, (equation,)),))
    assert refused(replace(model, equations=(nested,))) == "L346"


def test_a_visual_with_a_record() -> None:
    model = flat_model("model M Real x = time; end M;")
    pair = flat.Record(
        flat.Type(flat.Base.RECORD, (), "Pair", (), (("a", flat.REAL), ("b", flat.REAL))),
        NOWHERE,
        (number(1), number(2)),
    )
    visual = flat.Visual("part", "arrow", (("length", pair),), NOWHERE)
    assert refused(replace(model, visuals=(visual,))) == "L361"
