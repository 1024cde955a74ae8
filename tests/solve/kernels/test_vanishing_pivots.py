"""Pivots that were good when the order of elimination was chosen, and vanish in the run."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import planarc


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


# p = 0 exactly at the row t = 0.5, where the block is [[0, 1], [1, 0]].
PAIR = """
model Pair
  parameter Real k = 1;
  Real p = k*(1 - 2*time);
  Real a, b, x(start=0, fixed=true);
equation
  p*a + b = 1;
  a - p*b = 2;
  der(x) = a;
end Pair;
"""


def test_a_small_block_passes_its_zero_coefficient(backend: str) -> None:
    result = planarc.load(PAIR, backend=backend).simulate(1.0, tolerance=1e-10, intervals=10)
    p = 1 - 2 * result.time
    assert 0.0 in p
    assert result["a"] == pytest.approx((p + 2) / (p**2 + 1), rel=1e-12)
    assert result["b"] == pytest.approx((1 - 2 * p) / (p**2 + 1), rel=1e-12)
    # Integral of (p + 2)/(p^2 + 1) over p from -1 to 1, dt = -dp/2.
    assert result["x"][-1] == pytest.approx(np.pi / 2, rel=1e-8)


def test_a_parameter_may_take_the_coefficient_away(backend: str) -> None:
    model = planarc.load(PAIR, backend=backend)
    result = model.simulate(1.0, parameters={"k": 0}, intervals=10)
    assert result["a"] == pytest.approx(np.full(11, 2.0), rel=1e-12)
    assert result["b"] == pytest.approx(np.full(11, 1.0), rel=1e-12)


N, K = 12, 0.2
# The diagonal d goes from 1 to -1, beside it stand k and -k. As n is even, it is singular nowhere.
# At the start only the diagonal is large enough for pivots; at t = 0.5 it is 0.
CHAIN = f"""
model Chain
  parameter Integer n = {N};
  parameter Real k = {K};
  Real d = 1 - 2*time;
  Real z[n], x(start=0, fixed=true);
equation
  d*z[1] + k*z[2] = 1;
  for i in 2:n - 1 loop
    d*z[i] + k*z[i + 1] - k*z[i - 1] = i;
  end for;
  d*z[n] - k*z[n - 1] = n;
  der(x) = z[3];
end Chain;
"""


def chain(t: float) -> np.ndarray:
    off = np.full(N - 1, K)
    matrix = np.diag(np.full(N, 1 - 2 * t)) + np.diag(off, 1) - np.diag(off, -1)
    return np.linalg.solve(matrix, np.arange(1.0, N + 1.0))


def test_a_large_block_is_solved_whole_where_its_pivots_vanish(backend: str) -> None:
    model = planarc.load(CHAIN, backend=backend)
    assert any(block.direct is not None for block in model.program.blocks)
    result = model.simulate(1.0, tolerance=1e-9, intervals=100)
    assert 0.5 in result.time
    found = np.array([result[f"z[{i}]"] for i in range(1, N + 1)])
    expected = np.array([chain(t) for t in result.time]).T
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
    whole = quad(lambda t: chain(t)[2], 0, 1, points=[0.5], epsabs=1e-10, epsrel=1e-10)[0]
    assert result["x"][-1] == pytest.approx(whole, rel=1e-7)


@pytest.mark.parametrize("offset", [1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
def test_a_pivot_near_zero_costs_no_accuracy(backend: str, offset: float) -> None:
    """Rows just beside the instant at which all pivots vanish."""
    model = planarc.load(CHAIN, backend=backend)
    result = model.simulate(0.5 + offset, start_time=0.5 - offset, intervals=2)
    found = np.array([result[f"z[{i}]"] for i in range(1, N + 1)])
    expected = np.array([chain(t) for t in result.time]).T
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
