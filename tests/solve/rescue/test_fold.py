"""Curves that turn back: a run jumps from a branch that ends to another one."""

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


def run(body: str, backend: str, stop: float) -> planarc.Result:
    return planarc.load(f"model M\n{body}\nend M;", backend=backend).simulate(stop, tolerance=1e-8)


#: y = tanh(5*u + 2.5*y) turns back where 1 = 2.5*(1 - y^2), at u = -EDGE and EDGE.
EDGE = (2.5 * math.sqrt(0.6) - math.atanh(math.sqrt(0.6))) / 5


def test_a_trigger_jumps_where_its_curve_turns_back(backend: str) -> None:
    result = run("Real u=2*sin(time), y(start=-1); equation y = tanh(5*u + 2.5*y);", backend, 9.0)
    rise = math.asin(EDGE / 2)
    assert [e.time for e in result.events] == pytest.approx(
        [rise, math.pi + rise, 2 * math.pi + rise], abs=1e-8
    )
    u, y = result["u"], result["y"]
    assert abs(y - np.tanh(5 * u + 2.5 * y)).max() < 1e-6
    high = np.sin(result.time - rise) > 1e-6
    assert (y[high] > math.sqrt(0.6) - 1e-3).all()
    assert [w.code for w in result.warnings] == ["R436"]


def test_an_oscillator_of_a_trigger_has_its_period(backend: str) -> None:
    """Between jumps x goes from one edge to the other, as der(x) = -y with y near to -1 or 1."""
    body = "Real x(start=0, fixed=true), y(start=-1); equation der(x) = -y; y = tanh(5*x + 2.5*y);"
    result = run(body, backend, 5.0)
    times = np.array([e.time for e in result.events])
    assert len(times) > 5
    halves = np.diff(times)

    def crossing(n: int = 200_001) -> float:
        """The time of one way: the integral of dx/y = (x as a function of y) along the branch."""
        low = math.sqrt(0.6)
        high = low
        for _ in range(200):  # the value right after a jump
            high = math.tanh(5 * EDGE + 2.5 * high) if high > low else 1.0
        y = np.linspace(low, high, n)
        slope = (1 / (1 - y**2) - 2.5) / 5
        f = slope / y
        return float(((f[1:] + f[:-1]) / 2 * np.diff(y)).sum())

    assert halves == pytest.approx(np.full(len(halves), crossing()), rel=1e-4)


def test_a_steep_limiter_is_followed_through_its_corners(backend: str) -> None:
    """An amplifier of gain 15,000 with its output fed back: flat, steep and flat again."""
    body = """
  Real u = 20*sin(time), y;
equation
  y = noEvent(min(15, max(-15, 15000*(u - y))));"""
    result = run(body, backend, 7.0)
    law = np.clip(result["u"] * 15000 / 15001, -15, 15)
    assert result["y"] == pytest.approx(law, abs=1e-6)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1.1e-10])
def test_a_generator_of_two_saturating_amplifiers_goes_on(backend: str, tolerance: float) -> None:
    """The jumps lie where a straight piece of a curve begins: steps before them become ever
    shorter, and none fails. Between them x goes from one edge to the other, as der(x) =
    -(p + e)/T with p = 15 or -15 and e = x/(A + 1)."""
    amplified, limit, T = 15000, 15, 0.0375
    stop, jumps = (2.0, 40) if backend == "native" else (0.12, 2)  # NumPy takes minutes for all
    saturated = "smooth(0, if 15000*{0} > 15 then 15 else max(-15, 15000*{0}))"
    result = planarc.load(
        f"""
model M
  Real x(start=0, fixed=true), p, q, e(start=0), d, i(start=0.01);
equation
  q = {saturated.format("e")};
  x - q = e;
  p = homotopy({saturated.format("d")}, -15);
  d - p = 1500*i;
  d - q = -1000*i;
  der(x) = -(p + e)/{T};
end M;
""",
        backend=backend,
    ).simulate(stop, tolerance=tolerance, intervals=20)
    edge = (limit - (limit / amplified - 0.4 * limit) / 0.6 - limit) * (1 + 1 / amplified)
    s = amplified + 1
    half = T * s * math.log((limit + edge / s) / (limit - edge / s))
    assert np.diff([event.time for event in result.events]) == pytest.approx(
        np.full(jumps - 1, half), rel=1e-5
    )
