"""The error falls with the tolerance, and with the step, by law: for every solver, through
events, and where states are exchanged on the way.

Solvers hold the error of each step, so the error at the end goes with the tolerance to a
power a little below one. What is asked here is a power of at least POWER over several
decades, and that none of them is worse than the one before it but for a factor.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

import planarc

SOLVERS = ["cvode-bdf", "cvode-adams", "lsoda", "scipy-bdf"]
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
POWER = 0.65

#: A ball that falls on a floor from 1 m and loses 30 % of its speed at each bounce.
BALL = """
model Ball
  Real h(start=1, fixed=true), v(start=0, fixed=true);
  parameter Real k = 2;  // of the medium: terminal speed sqrt(9.81/k)
equation
  der(h) = v;
  der(v) = -9.81 + k*v^2*(if v < 0 then 1 else -1);
  when h < 0 then
    reinit(v, -0.7*pre(v));
  end when;
end Ball;
"""

#: A crank with a slider: the slider is preferred as a state, and must give way at each
#: dead centre. No gravity.
SLIDER = """
model Slider
  parameter Real r = 0.3, l = 1;
  Real phi(start=0.4, fixed=true, stateSelect=StateSelect.avoid);
  Real s(start=1.27, stateSelect=StateSelect.prefer);
  Real w(start=3, fixed=true) = der(phi);
  Real v = der(s);
  Real f;
equation
  (s - r*cos(phi))^2 + (r*sin(phi))^2 = l^2;
  der(w) = 2*f*(s - r*cos(phi))*r*sin(phi) + 2*f*r^2*sin(phi)*cos(phi);
  0.1*der(v) = 2*f*(s - r*cos(phi));
end Slider;
"""

PENDULUM = """
model Pendulum
  Real phi(start=0, fixed=true), w(start=0, fixed=true);
equation
  der(phi) = w;
  der(w) = -9.81*cos(phi);
end Pendulum;
"""

FALL = """
model Fall "y' = -2*t*y^2, y = 1/(1 + t^2)"
  Real y(start=1, fixed=true);
equation
  der(y) = -2*time*y^2;
end Fall;
"""


@pytest.fixture(scope="module", params=SOLVERS)
def solver(request: pytest.FixtureRequest) -> str:
    if request.param in ("cvode-bdf", "cvode-adams"):
        pytest.importorskip("sksundae")
    return str(request.param)


def falls(errors: list[float], least: float = 0.0) -> None:
    """Over all tolerances with the power asked for, and never up by more than a factor 3.
    Errors below `least` are rounding."""
    errors = [max(e, least) for e in errors]
    assert all(b <= 3 * a for a, b in pairwise(errors)), errors
    whole = math.log10(errors[0] / errors[-1]) / math.log10(TOLERANCES[0] / TOLERANCES[-1])
    assert whole > POWER or errors[-1] == least, errors


def bounces(count: int) -> list[float]:
    """The instants at which the ball meets the floor, in closed form.

    Down, v' = -g + k*v^2: from rest it falls h in acosh(exp(k*h))/sqrt(g*k), and arrives at
    the speed u with u^2 = g/k*(1 - exp(-2*k*h)). Up, v' = -g - k*v^2: from u it rises for
    atan(u*sqrt(k/g))/sqrt(g*k), to log(1 + k*u^2/g)/(2*k).
    """
    g, k, h, t = 9.81, 2.0, 1.0, 0.0
    found = []
    for _ in range(count):
        t += math.acosh(math.exp(k * h)) / math.sqrt(g * k)
        found.append(t)
        u = 0.7 * math.sqrt(g / k * (1 - math.exp(-2 * k * h)))
        t += math.atan(u * math.sqrt(k / g)) / math.sqrt(g * k)
        h = math.log(1 + k * u * u / g) / (2 * k)
    return found


def test_the_instants_of_bounces_converge(solver: str) -> None:
    exact = np.array(bounces(6))
    model = planarc.load(BALL)
    errors = []
    for tolerance in TOLERANCES:
        result = model.simulate(float(exact[-1]) + 0.05, tolerance=tolerance, solver=solver)
        assert result.ended is None
        times = np.array([e.time for e in result.events])  # turns of v, too
        errors.append(float(np.abs(times - exact[:, None]).min(axis=1).max()))
    falls(errors, least=1e-12)
    assert errors[-1] < 1e-7


def test_a_run_converges_through_exchanges_of_states(solver: str) -> None:
    """The energy stays, and the crank agrees with quadrature of its own equation."""
    model = planarc.load(SLIDER)
    drifts = []
    for tolerance in TOLERANCES:
        result = model.simulate(4.0, tolerance=tolerance, solver=solver)
        assert result.ended is None
        assert len(result.states) > 1  # the slider was a state, and had to give way
        energy = 0.5 * result["w"] ** 2 + 0.05 * result["v"] ** 2
        drifts.append(float(np.ptp(energy)))
    falls(drifts)
    assert drifts[-1] < 1e-6


def test_the_energy_of_a_pendulum_drifts_with_the_tolerance(solver: str) -> None:
    model = planarc.load(PENDULUM)
    drifts = []
    for tolerance in TOLERANCES:
        result = model.simulate(10.0, tolerance=tolerance, solver=solver)
        energy = 0.5 * result["w"] ** 2 + 9.81 * np.sin(result["phi"])
        drifts.append(float(np.ptp(energy)))
    falls(drifts)
    assert drifts[-1] < 1e-6


@pytest.mark.parametrize("tolerance", [1e-11, 1e-12, 1e-13])
def test_tolerances_near_rounding_are_still_reached(solver: str, tolerance: float) -> None:
    result = planarc.load(FALL).simulate(2.0, tolerance=tolerance, solver=solver)
    assert result.ended is None
    assert result.warnings == ()
    assert np.max(np.abs(result["y"] - 1 / (1 + result.time**2))) < 1e3 * tolerance


@pytest.mark.parametrize(("method", "order"), [("euler", 1), ("rk4", 4)])
def test_fixed_steps_have_the_order_of_their_method(method: str, order: int) -> None:
    model, errors = planarc.load(FALL), []
    for step in (0.1, 0.05, 0.025, 0.0125):
        result = model.simulate(2.0, fixed_step=step, solver=method, intervals=20)
        errors.append(float(np.max(np.abs(result["y"] - 1 / (1 + result.time**2)))))
    ratios = [a / b for a, b in pairwise(errors)]
    assert ratios[-1] == pytest.approx(2**order, rel=0.12), ratios


def test_fixed_steps_keep_their_order_through_exchanges_of_states() -> None:
    """The energy of the slider's crank falls with the fourth power of the step."""
    model, drifts = planarc.load(SLIDER), []
    for step in (0.008, 0.004, 0.002):
        result = model.simulate(4.0, fixed_step=step, solver="rk4")
        assert len(result.states) > 1
        energy = 0.5 * result["w"] ** 2 + 0.05 * result["v"] ** 2
        drifts.append(float(np.ptp(energy)))
    assert all(a > 8 * b for a, b in pairwise(drifts)), drifts
