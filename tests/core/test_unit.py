"""Units as dimensions."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planarc.core import unit


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("N.m", "J"),
        ("kg.m2/s2", "J"),
        ("N", "kg.m/s2"),
        ("m3.kg-1.s-2", "m3/(kg.s2)"),
        ("kN", "N"),
        ("mm", "m"),
        ("rad/s", "1/s"),
        ("W/(m2.K)", "kg/(s3.K)"),
        ("kW.h", "J"),
        ("min", "s"),
        ("Pa", "N/m2"),
        ("V", "W/A"),
        ("Ohm", "V/A"),
        ("F", "C/V"),
        ("H", "Wb/A"),
        ("daN", "N"),
        ("%", "1"),
    ],
)
def test_equal_dimensions(one: str, other: str) -> None:
    assert unit.parse(one) is not None
    assert unit.parse(one) == unit.parse(other)


@pytest.mark.parametrize("text", ["", "nonsense", "m//s", "m.", "(m", "m)", "m^2", "kg m"])
def test_what_is_no_unit_is_not_known(text: str) -> None:
    assert unit.parse(text) is None


exponents = st.integers(-4, 4).map(Fraction)


@given(st.tuples(*[exponents] * 7))
def test_the_text_of_a_dimension_is_that_dimension(dimension: unit.Dimension) -> None:
    assert unit.parse(unit.unit_text(dimension)) == dimension


@pytest.mark.parametrize(
    ("of", "text"),
    [
        ("kg.m/s2", "N"),
        ("kg.m2/s2", "N.m"),
        ("kg/s2", "N/m"),
        ("kg.m3/s2", "N.m2"),
        ("kg.m2/s3", "W"),
        ("kg/(m.s2)", "Pa"),
        ("s2/kg", "m/N"),
        ("kg.m/s", "kg.m/s"),
        ("kg.m2", "kg.m2"),
        ("m/s2", "m/s2"),
        ("V/A", "Ohm"),
        ("C/V", "F"),
        ("N/A", "N/A"),
    ],
)
def test_units_are_written_as_engineers_do(of: str, text: str) -> None:
    dimension = unit.parse(of)
    assert dimension is not None
    assert unit.unit_text(dimension) == text


@given(st.tuples(*[exponents] * 7), st.tuples(*[exponents] * 7))
def test_division_undoes_multiplication(a: unit.Dimension, b: unit.Dimension) -> None:
    assert unit.divide(unit.multiply(a, b), b) == a


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("m", "m/s"),
        ("rad/s", "rad/s2"),
        ("m/s2", "m/s3"),
        ("1", "1/s"),
        ("N.m", "N.m/s"),
        ("N/m", "N/(m.s)"),
        ("J/(kg.K)", "J/(kg.K.s)"),
        ("W/(m2.s)", "W/(m2.s2)"),
        ("", ""),
        ("smoots", ""),
        ("m/s/s", ""),
    ],
)
def test_the_unit_of_a_derivative(text: str, rate: str) -> None:
    assert unit.rate_text(text) == rate
    if rate:
        before, after = unit.parse(text), unit.parse(rate)
        seconds = unit.parse("s")
        assert before is not None and after is not None and seconds is not None
        assert unit.multiply(after, seconds) == before
