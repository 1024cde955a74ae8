"""Values with units become numbers, exactly; units that do not fit are refused."""

from __future__ import annotations

import math

import pytest

from planarc.core.diagnostic import UsageError
from planarc.core.quantity import in_unit, of_pint


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("20cm", "m", 0.2),
        ("-3e-2 mm", "m", -3e-5),
        ("500ms", "s", 0.5),
        ("1.5 kN", "N", 1500.0),
        ("45deg", "rad", math.radians(45)),
        ("45°", "rad", math.radians(45)),
        ("2rev", "rad", 4 * math.pi),
        ("90 deg/s", "rad/s", math.pi / 2),
        ("3000rpm", "rad/s", 100 * math.pi),
        ("1 N.m/deg", "N.m/rad", 180 / math.pi),
        ("5 g*cm^2", "kg.m2", 5e-7),
        ("36km/h", "m/s", 10.0),
        ("2kg.m/s2", "N", 2.0),
        ("3bar", "Pa", 3e5),
        ("20degC", "K", 293.15),
        ("0degC", "K", 273.15),
        ("300K", "degC", 26.85),
        ("0K", "degC", -273.15),
        ("0degC", "degC", 0.0),
        ("20degC", "degC", 20.0),
        ("20degC", "mK", 293150.0),
        ("0deg", "rad", 0.0),
        ("50%", "1", 0.5),
        ("5 1/s", "Hz", 5.0),
        ("20cm", "mm", 200.0),
        ("1mm", "mm", 1.0),
    ],
)
def test_a_number_is_taken_in_the_unit_that_is_wanted(text: str, unit: str, number: float) -> None:
    found = in_unit("x", text, unit)
    assert found == pytest.approx(number, rel=1e-15)
    if "deg" not in text and "r" not in text:
        assert found == number


@pytest.mark.parametrize("text", ["12", "2,5", "abc", "1e3", "", "-", "{1,2}", "m", "1.2.3"])
def test_what_is_no_number_with_a_unit_is_left_alone(text: str) -> None:
    assert in_unit("x", text, "m") is None


@pytest.mark.parametrize(
    ("text", "unit", "told"),
    [
        ("20kg", "m", "takes a value in `m`, not `20kg`.*give it in `m` or `cm` or `mm`"),
        ("20mx", "m", "the unit `mx` of `x` is not known.*did you mean `m`"),
        ("5Hz", "rad/s", "takes a value in `rad/s`.*`rev/min`"),
        ("5N.m", "N.m/rad", "did you mean `N.m/rad`"),
        ("5m", "", "takes a number without unit, not `5m`.*write `x=5`"),
        ("5deg", "1", "takes a number without unit"),
        ("30deg", "", "not `30deg`.*write `x=0.523599`, which it is in units of the SI"),
        ("2Ym30", "", "write `x=2`$"),
        ("2km", "", "write `x=2000`, which it is in units of the SI"),
        ("5N", "kg.m3/s9", "give it in `kg.m3/s9`"),
    ],
)
def test_a_unit_that_does_not_fit_is_told(text: str, unit: str, told: str) -> None:
    with pytest.raises(UsageError, match=f"(?s)C115.*{told}"):
        in_unit("x", text, unit)


@pytest.mark.parametrize(
    ("text", "number"),
    [("1e400m", math.inf), ("-1e400m", -math.inf), ("1e-999999999m", 0.0), ("1e308km", math.inf)],
)
def test_numbers_beyond_all_bounds_take_no_time(text: str, number: float) -> None:
    assert in_unit("x", text, "m") == number


class Length:
    """A quantity as pint makes them."""

    magnitude = 0.2
    dimensionality = {"[length]": 1}  # noqa: RUF012

    def to_base_units(self) -> Length:
        return self

    def __str__(self) -> str:
        return "20 centimeter"


def test_quantities_of_pint_are_taken() -> None:
    assert of_pint("x", Length(), "m") == 0.2
    assert of_pint("x", Length(), "mm") == 200.0
    for unit in ("kg", "1", ""):
        with pytest.raises(UsageError, match=r"C115.*not `20 centimeter`"):
            of_pint("x", Length(), unit)


def test_quantities_of_the_real_pint_are_taken() -> None:
    pint = pytest.importorskip("pint")
    u = pint.UnitRegistry()
    assert of_pint("x", 45 * u.deg, "rad") == pytest.approx(math.radians(45))
    assert of_pint("x", 3000 * u.rpm, "rad/s") == pytest.approx(100 * math.pi)
    assert of_pint("x", u.Quantity(20, u.degC), "K") == pytest.approx(293.15)
    assert of_pint("x", u.Quantity(300, u.kelvin), "degC") == pytest.approx(26.85)
