"""Signs of print in what planarc says of numbers."""

from __future__ import annotations

import pytest

from planarc.view.page.typeset import number, typeset, unit


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("1 = 3*2 - 2*2 - 1*1", "1 = 3×2 − 2×2 − 1×1"),
        ("x = 0.24 -> 0.22538", "x = 0.24 → 0.22538"),
        ("holds to 1e-05 of it", "holds to 10⁻⁵ of it"),
        ("3.5e+12 and -2.5e-3", "3.5×10¹² and −2.5×10⁻³"),
        ("from -1 to 2", "from −1 to 2"),
        ("`a-1*2 -> 1e-5` and a-1, x1e5", "`a-1*2 -> 1e-5` and a-1, x1e5"),
        ("impact of 5e-10 N.s at `a N.s`", "impact of 5×10⁻¹⁰ N·s at `a N.s`"),
        ("cvode-bdf (native)", "cvode-bdf (native)"),
    ],
)
def test_texts(text: str, printed: str) -> None:
    assert typeset(text) == printed


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (0.0, "0.000"), (1234.5678, "1235"), (-25650.0, "−25650"), (0.012345, "0.01235"),
        (1.5e-7, "1.500×10⁻⁷"), (float("nan"), "–"),
    ],
)  # fmt: skip
def test_numbers(value: float, printed: str) -> None:
    assert number(value) == printed


def test_units() -> None:
    assert [unit(u) for u in ("N.m", "m/s2", "1", "")] == ["N·m", "m/s²", "", ""]
