"""Which fields a model has, and how far their sliders go."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import planarc
from planarc.ir.dae import Kind
from planarc.request.request import Request
from planarc.view.page.controls import REST, Group, groups_of, slider


def fields_of(model: planarc.Model) -> tuple[Group, ...]:
    return groups_of(model.program, model.compiled().parameters())


def test_the_model_comes_first_and_the_world_late(swing: Request) -> None:
    groups = fields_of(planarc.load(str(swing.file)))
    titles = [g.title for g in groups]
    assert titles[0] == ""
    assert titles[-2:] == ["world", REST]
    assert [f.name for f in groups[0].fields] == ["L", "heavy", "n"]
    assert dict(zip(titles, (g.description for g in groups), strict=True))["bob"] == "Body"


def test_fields_tell_units_bounds_and_kinds(swing: Request) -> None:
    model = planarc.load(str(swing.file))
    found = {f.name: f for g in fields_of(model) for f in g.fields}
    length = found["L"]
    assert (length.unit, length.value, length.minimum, length.maximum) == ("m", 1.0, 0.1, 5.0)
    assert (length.low, length.high) == (0.1, 5.0)
    assert length.description == "Length of the rod"
    assert (found["heavy"].kind, found["heavy"].structural) == ("Boolean", True)
    assert (found["n"].kind, found["n"].minimum) == ("Integer", 1.0)
    gravity = found["world.gravityType"]
    assert gravity.literals == ("NoGravity", "UniformGravity", "PointGravity")
    start = found["hinge.phi"]
    assert start.start
    assert start.unit == "deg"
    assert start.value * start.factor == pytest.approx(math.degrees(0.5))


def test_what_cannot_be_set_has_no_field(swing: Request) -> None:
    found = {f.name for g in fields_of(planarc.load(str(swing.file))) for f in g.fields}
    assert "twice" not in found  # final
    assert "bob.m" not in found  # follows from n
    assert not [n for n in found if "olor" in n]


def test_what_does_not_move_it_stands_apart(swing: Request) -> None:
    groups = fields_of(planarc.load(str(swing.file)))
    rest = {f.name for f in groups[-1].fields}
    assert "world.nominalLength" in rest
    assert "world.mu" in rest  # without a point field
    assert not rest & {"L", "n", "world.g", "world.n[1]", "hinge.phi"}


@given(
    st.floats(-1e9, 1e9),
    st.one_of(st.none(), st.floats(-1e9, 1e9)),
    st.one_of(st.none(), st.floats(-1e9, 1e9)),
    st.sampled_from(["", "m", "rad"]),
)
def test_a_slider_holds_its_value_and_keeps_the_bounds(
    value: float, minimum: float | None, maximum: float | None, unit: str
) -> None:
    low, high = slider(Kind.REAL, value, minimum, maximum, unit)
    assert low < high
    inside = (minimum is None or value >= minimum) and (maximum is None or value <= maximum)
    if inside and minimum != maximum:
        assert low <= value <= high
        assert maximum is None or high <= max(maximum, value + 1.0)
        assert minimum is None or low >= min(minimum, value)


def test_a_slider_of_a_length_goes_from_a_fifth_to_more_than_double() -> None:
    assert slider(Kind.REAL, 0.4, None, None, "m") == (0.08, 1.0)
    assert slider(Kind.REAL, -0.4, None, None, "m") == (-1.0, -0.08)
    assert slider(Kind.REAL, 1.0, None, None, "rad") == (-math.pi, math.pi)
    # Bounds of another size than the value make no slider.
    assert slider(Kind.REAL, 1.0, 0.0, 1e60, "kg") == (0.2, 2.5)
