"""When a block counts as solved: by what its unknowns do to its equations, in both back ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planarc


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


def run(body: str, backend: str) -> planarc.Result:
    return planarc.load(f"model M\n{body}\nend M;", backend=backend).simulate(1.0, intervals=10)


@pytest.mark.parametrize("ohm", [1.0, 1e3, 1e6, 1e9, 1e12])
def test_a_current_counts_by_the_voltage_it_makes(backend: str, ohm: float) -> None:
    body = f"""
  Real i, v;
equation
  22 + time = {ohm}*i + v;
  v = 0.025*log(i/1e-15 + 1);"""
    result = run(body, backend)
    i, v = result["i"], result["v"]
    assert ohm * i + v == pytest.approx(22 + np.array(result.time), rel=1e-9)
    assert v == pytest.approx(0.025 * np.log(i / 1e-15 + 1), rel=1e-9)


@pytest.mark.parametrize("size", [1e-12, 1e-6, 1.0, 1e6, 1e12])
def test_a_root_is_as_exact_in_any_unit(backend: str, size: float) -> None:
    """u = x/size solves u^3 + u = 1 whatever the unit of x."""
    result = run(f"Real x(start={size}); equation (x/{size})^3 + x/{size} = 1;", backend)
    assert result["x"][0] / size == pytest.approx(0.6823278038280193, rel=1e-13)


def test_a_root_at_zero_ends(backend: str) -> None:
    """Nothing is left there that a step could be measured by; rounding must not fail it."""
    body = """
  Real x(start=0.1), y(start=0.1), u, v;
equation
  u = 0.1*time;
  v = (u + 0.2) - 0.2 - u;
  sin(x) + x^2*y = v;
  y + sin(x)*y^2 = v;"""
    result = run(body, backend)
    assert np.abs(result["x"]).max() < 1e-15
    assert np.abs(result["y"]).max() < 1e-15


def test_a_cycle_of_two_points_is_left(backend: str) -> None:
    """From the right start Newton's steps on atan(x) go to and fro with equal residuals."""
    start = 1.0
    for _ in range(60):  # 2*x = (1 + x^2)*atan(x)
        start -= ((1 + start**2) * math.atan(start) - 2 * start) / (
            2 * start * math.atan(start) - 1
        )
    result = run(f"Real x(start={start!r}); equation atan(x) = 0;", backend)
    assert result["x"][0] == pytest.approx(0.0, abs=1e-12)
