"""Two results part where the tube ends, in value and in time."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planarc.view.table.compare import Comparison, compare_tables
from planarc.view.table.table import Table

T = np.linspace(0.0, 10.0, 501)


def table(time: np.ndarray, **columns: np.ndarray) -> Table:
    return Table(time, columns, {})


def compare(a: Table, b: Table, tolerance: float = 1e-3, width: float = 1e-3) -> Comparison:
    return compare_tables(a, b, tolerance, width)


@settings(max_examples=50)
@given(
    st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=30),
    st.floats(0, 0.1),
    st.floats(0, 0.1),
)
def test_a_result_agrees_with_itself(values: list[float], tolerance: float, width: float) -> None:
    a = table(np.arange(len(values), dtype=float), x=np.array(values))
    assert compare(a, a, tolerance, width).same


def test_other_sampling_of_one_curve_is_no_difference() -> None:
    coarse = np.linspace(0.0, 10.0, 200)
    assert compare(table(T, x=np.sin(T)), table(coarse, x=np.sin(coarse))).same


def test_a_difference_within_the_tube_is_none_and_one_outside_is_told() -> None:
    a = table(T, x=np.sin(T))
    size = float(np.ptp(np.sin(T)))
    assert compare(a, table(T, x=np.sin(T) + 0.9e-3 * size), width=0).same
    found = compare(a, table(T, x=np.sin(T) + 1.1e-3 * size), width=0)
    assert [p.name for p in found.parted] == ["x"]
    assert found.parted[0].most == pytest.approx(1.1e-3 * size, rel=1e-6)


def test_a_step_may_come_a_little_later_but_not_much() -> None:
    def step(at: float) -> np.ndarray:
        return (at < T).astype(float)

    a = table(T, x=step(5.0))
    assert compare(a, table(T, x=step(5.02)), width=0.005).same
    found = compare(a, table(T, x=step(5.2)), width=0.005)
    assert found.parted[0].time == pytest.approx(5.06, abs=0.021)
    assert (found.parted[0].a, found.parted[0].b) == (1.0, 0.0)


def test_rounding_around_zero_is_no_difference_unless_it_is_asked_for() -> None:
    noise = 1e-17 * np.sin(97 * T)
    a, b = table(T, x=noise), table(T, x=np.zeros(501))
    assert compare_tables(a, b, 1e-3, 1e-3, absolute=1e-12).same
    assert [p.name for p in compare(a, b).parted] == ["x"]
    apart = table(T, x=np.full(501, 1.1e-12))
    found = compare_tables(a, apart, 1e-3, 1e-3, absolute=1e-12)
    assert found.parted[0].most == pytest.approx(1.1e-12, rel=1e-4)


@pytest.mark.parametrize("value", [1e5, -3.0])
def test_rounding_of_a_value_that_stays_is_no_difference(value: float) -> None:
    a = table(T, x=value * (1 + 1e-15 * np.sin(97 * T)))
    assert compare(a, table(T, x=np.full(501, value))).same
    assert not compare(a, table(T, x=np.full(501, value * (1 + 1e-11)))).same


def test_they_are_told_in_the_order_in_which_they_part() -> None:
    a = table(T, x=np.zeros(501), y=np.zeros(501), z=np.zeros(501))
    b = table(T, z=np.zeros(501), y=(T > 2) * 5.0, x=(T > 4) * 2.0)
    assert [p.name for p in compare(a, b).parted] == ["y", "x"]


def test_missing_variables_and_other_ends_are_told() -> None:
    found = compare(table(T, x=T, y=T), table(T[:301], x=T[:301], z=T[:301]))
    assert (found.only_a, found.only_b) == (("y",), ("z",))
    assert found.ends == (10.0, 6.0)
    assert not found.same
    assert found.parted == ()


def test_what_is_no_number_agrees_with_nothing_else() -> None:
    hole = np.sin(T)
    hole[100:110] = np.nan
    assert compare(table(T, x=hole), table(T, x=hole)).same
    found = compare(table(T, x=np.sin(T)), table(T, x=hole))
    assert found.parted[0].time == pytest.approx(T[100])


def test_infinite_values_agree_with_each_other_alone() -> None:
    up, down = np.where(T > 5, np.inf, T), np.where(T > 5, -np.inf, T)
    back = np.where(T > 8, 5.0, up)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert compare(table(T, x=up), table(T, x=up)).same
        (parted,) = compare(table(T, x=up), table(T, x=back)).parted
        (other,) = compare(table(T, x=up), table(T, x=down)).parted
    assert parted.time == pytest.approx(8, abs=0.1)
    assert (parted.a, parted.b, parted.most) == (np.inf, 5.0, np.inf)
    assert (other.b, other.most) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("unit", "other", "ratio", "shift"),
    [("m", "mm", 1000, 0), ("rad", "deg", 180 / np.pi, 0), ("K", "degC", 1, -273.15)],
)
def test_values_count_in_the_unit_of_the_reference(
    unit: str, other: str, ratio: float, shift: float
) -> None:
    t = np.linspace(0, 1, 11)
    a = Table(t, {"x": t + 1}, {"x": unit})
    b = Table(t, {"x": (t + 1) * ratio + shift}, {"x": other})
    assert compare(a, b).same
    assert compare(b, a).same
    assert not compare(a, Table(t, b.columns, {"x": unit})).same


def test_units_without_a_common_measure_are_told() -> None:
    t = np.linspace(0, 1, 11)
    a, b = (Table(t, {"x": t, "y": t}, {"x": unit}) for unit in ("m", "s"))
    found = compare(a, b)
    assert (found.apart, found.compared, found.same) == ((("x", "m", "s"),), 1, False)


def test_results_without_time_in_common_are_not_said_to_agree() -> None:
    t = np.linspace(0, 1, 11)
    found = compare(table(t, x=t), table(t + 5, x=t))
    assert not found.meet
    assert not found.same
