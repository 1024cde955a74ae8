"""Filters and controllers against their polynomials: steps, ways to start, amplitudes, limits."""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from typing import Any

import numpy as np
import pytest

HEAD = """
  import Modelica.Blocks.{Continuous, Logical};
  import Init = Modelica.Blocks.Types.Init;
  import R = Modelica.Mechanics.Rotational;
  import T = Modelica.Mechanics.Translational;
"""


@pytest.fixture
def compute(run: Callable[..., Any]) -> Callable[..., Any]:
    return lambda body, **options: run(HEAD + body, **options)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
def test_lags_in_a_row_follow_a_step(compute: Callable[..., Any], order: int) -> None:
    result = compute(
        f"""
  Continuous.CriticalDamping lags(
    n={order}, f=0.8, normalized=false, initType=Init.InitialState, u=1);
"""
    )
    x = 2 * np.pi * 0.8 * result.time
    left = sum(x**i / factorial(i) for i in range(order))
    np.testing.assert_allclose(result["lags.y"], 1 - left * np.exp(-x), atol=1e-7)


#: Blocks that must pass a swing at their critical frequency with the amplitude 1/sqrt(2).
SWINGS = {
    "Continuous.CriticalDamping x(n=4, f=2, initType=Init.SteadyState)": "u = {}; y = x.y;",
    "Continuous.FirstOrder x(T=1/(4*Modelica.Constants.pi))": "u = {}; y = x.y;",
    "R.Sources.Position x(f_crit=2)": "phi_ref = {}; y = x.phi; connect(x.flange, j.flange_a);",
    "T.Sources.Position x(f_crit=2)": "s_ref = {}; y = x.s; connect(x.flange, m.flange_a);",
    "R.Sources.Speed x(f_crit=2)": "w_ref = {}; y = x.w; connect(x.flange, j.flange_a);",
    "T.Sources.Speed x(f_crit=2)": "v_ref = {}; y = x.v; connect(x.flange, m.flange_a);",
}


@pytest.mark.parametrize("block", SWINGS)
def test_a_filter_passes_its_critical_frequency_with_half_the_power(
    compute: Callable[..., Any], block: str
) -> None:
    parts = "  R.Components.Inertia j(J=1);\n" if block[0] == "R" else ""
    parts += "  T.Components.Mass m(m=1);\n" if block[0] == "T" else ""
    equations = SWINGS[block].format("sin(4*Modelica.Constants.pi*time)")
    result = compute(f"{parts}  {block};\n  Real y;\nequation\n  x.{equations}\n", stop=6.0)
    late = result.time > 4
    wave = np.stack([np.sin(4 * np.pi * result.time), np.cos(4 * np.pi * result.time)], axis=1)
    parts_of, *_ = np.linalg.lstsq(wave[late], result["y"][late], rcond=None)
    assert np.hypot(*parts_of) == pytest.approx(np.sqrt(0.5), abs=1e-6)


def test_a_bessel_filter_delays_a_slow_signal_by_one_time(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  R.Sources.Position x(f_crit=4, phi_ref=0.5*time);
  R.Components.Inertia j(J=1);
equation
  connect(x.flange, j.flange_a);
""",
        stop=2.0,
    )
    delay = np.sqrt(1.5 * (np.sqrt(5) - 1)) / (8 * np.pi)
    assert result["x.phi"][-1] == pytest.approx(0.5 * (2 - delay), abs=1e-8)


#: What a block gives and holds at the start, for u = 2: kind of start, then variables.
STARTS = {
    "FirstOrder x(k=3, T=0.5, y_start=4": {
        "SteadyState": {"x.y": 6, "der(x.y)": 0},
        "InitialState": {"x.y": 4},
        "InitialOutput": {"x.y": 4},
    },
    "SecondOrder x(k=3, w=2, D=0.5, y_start=4, yd_start=5": {
        "SteadyState": {"x.y": 6, "x.yd": 0, "der(x.yd)": 0},
        "InitialState": {"x.y": 4, "x.yd": 5},
        "InitialOutput": {"x.y": 4, "x.yd": 5},
    },
    "PI x(k=3, T=0.5, x_start=4, y_start=5": {
        "InitialState": {"x.x": 4, "x.y": 18},
        "InitialOutput": {"x.y": 5},
    },
    "Derivative x(k=3, T=0.5, x_start=4, y_start=5": {
        "SteadyState": {"x.y": 0, "x.x": 2},
        "InitialState": {"x.x": 4, "x.y": -12},
        "InitialOutput": {"x.y": 5},
    },
    "Derivative x(k=0, T=0.5, x_start=4, y_start=5": {
        "InitialState": {"x.x": 4, "x.y": 0},
        "InitialOutput": {"x.x": 2, "x.y": 0},
    },
    "PID x(k=3, Ti=0.5, Td=0.1, xi_start=4, xd_start=1, y_start=5": {
        "InitialState": {"x.I.y": 4, "x.D.x": 1, "x.y": 3 * (2 + 4 + 10)},
        "InitialOutput": {"x.y": 5, "x.D.y": 0},
    },
    "CriticalDamping x(n=3, f=1, x_start={1, 3, 4}, y_start=5": {
        "SteadyState": {"x.x[1]": 2, "x.x[2]": 2, "x.y": 2},
        "InitialState": {"x.x[1]": 1, "x.x[2]": 3, "x.y": 4},
        "InitialOutput": {"x.x[1]": 2, "x.x[2]": 2, "x.y": 5},
    },
    "TransferFunction x(b={1, 6}, a={1, 2, 4}, x_start={1, 3}, y_start=5": {
        "SteadyState": {"x.x[1]": 0, "x.x[2]": 0.5, "x.y": 3},
        "InitialState": {"x.x[1]": 1, "x.x[2]": 3, "x.y": 19},
        "InitialOutput": {"x.y": 5},
    },
    "TransferFunction x(b={6}, a={2}, y_start=5": {
        "SteadyState": {"x.y": 6},
        "InitialOutput": {"x.y": 6},
    },
    "LimIntegrator x(outMax=9, y_start=4": {
        "InitialState": {"x.y": 4},
        "InitialOutput": {"x.y": 4},
    },
}


@pytest.mark.parametrize(
    ("block", "start"), [(b, s) for b, starts in STARTS.items() for s in starts]
)
def test_blocks_start_as_asked(compute: Callable[..., Any], block: str, start: str) -> None:
    result = compute(f"  Continuous.{block}, u=2, initType=Init.{start});", stop=0.1)
    for name, value in STARTS[block][start].items():
        assert result[name][0] == pytest.approx(value, abs=1e-8), name


def test_controllers_start_at_rest_in_a_loop(compute: Callable[..., Any]) -> None:
    """At rest the error is zero, whatever the gains."""
    result = compute(
        """
  Continuous.PI pi(k=2, T=0.4, initType=Init.SteadyState);
  Continuous.FirstOrder plant(k=1.5, T=0.2, initType=Init.SteadyState);
  Continuous.PID pid(k=2, Ti=0.4, Td=0.1, initType=Init.SteadyState);
  Continuous.SecondOrder swing(k=1.5, w=4, D=0.7, initType=Init.SteadyState);
equation
  pi.u = 3 - plant.y;
  plant.u = pi.y;
  pid.u = 3 - swing.y;
  swing.u = pid.y;
"""
    )
    for name, value in {"plant.y": 3, "swing.y": 3, "pi.y": 2, "pid.y": 2}.items():
        np.testing.assert_allclose(result[name], value, atol=1e-7, err_msg=name)


def test_a_derivative_decays_with_its_lag(compute: Callable[..., Any]) -> None:
    result = compute("  Continuous.Derivative d(k=2, T=0.2, initType=Init.InitialState, u=1);")
    np.testing.assert_allclose(result["d.y"], 10 * np.exp(-result.time / 0.2), atol=1e-6)


@pytest.mark.parametrize("strict", ["false", "true"])
def test_a_limited_integrator_leaves_its_limit_at_once(
    compute: Callable[..., Any], strict: str
) -> None:
    result = compute(
        f"  Continuous.LimIntegrator x(outMax=0.5, strict={strict}, u=if time < 1 then 1 else -1);",
        stop=2.5,
    )
    t = result.time
    ideal = np.where(t < 1, np.minimum(t, 0.5), np.maximum(0.5 - (t - 1), -0.5))
    # Without events the limit is passed by as much as one step brings.
    allowed = {"false": 1e-7, "true": 1e-2}[strict]
    np.testing.assert_allclose(result["x.y"], ideal, atol=allowed)


def test_a_limited_controller_does_not_wind_up(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Continuous.LimPID c(
    controllerType=Modelica.Blocks.Types.SimpleController.PI, k=2, Ti=0.25, Ni=1, yMax=1,
    initType=Init.InitialState, u_s=1, u_m=0);
""",
        stop=2.0,
    )
    # At the limit Ti*der(i) = e + (1 - k*(e + i))/k, so that i tends to 1/k.
    ideal = 0.5 * (1 - np.exp(-result.time / 0.25))
    np.testing.assert_allclose(result["c.I.y"], ideal, atol=1e-7)
    np.testing.assert_allclose(result["c.y"], 1)


def test_a_trapezoid_turns_round_where_it_is(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Logical.TriggeredTrapezoid up(amplitude=-2, offset=1, rising=1, falling=0.5);
  Logical.TriggeredTrapezoid on(rising=0.2, u=time < 0.5);
  Logical.TriggeredTrapezoid steep(rising=0, falling=0, u=up.u);
equation
  up.u = time > 0.1 and time < 0.6 or time > 0.8;
""",
        stop=2.0,
    )
    t = result.time
    corners = [0, 0.1, 0.6, 0.8, 1.7], [1, 1, 0, 0.8, -1]
    # It rises to 0.5, falls by 0.4 and rises to the end.
    np.testing.assert_allclose(result["up.y"], np.interp(t, *corners), atol=1e-9)
    np.testing.assert_allclose(result["on.y"], np.interp(t, [0.5, 0.7], [1, 0]), atol=1e-9)
    assert set(result["steep.y"]) == {0, 1}


def test_resistance_may_change_its_sign_with_the_speed(compute: Callable[..., Any]) -> None:
    laws: dict[str, Callable[[float], float]] = {
        "Linear, true": lambda w: 2 * abs(w) / 10,
        "Linear, false": lambda w: 2 * w / 10,
        "Quadratic, true": lambda w: 2 * w * w / 100,
        "Quadratic, false": lambda w: 2 * w * abs(w) / 100,
    }
    declared = "  parameter Real v = 5;\n"
    connected = ""
    for i, law in enumerate(laws):
        kind, sided = law.split(", ")
        declared += f"""
  R.Sources.{kind}SpeedDependentTorque a{i}(tau_nominal=2, w_nominal=10, TorqueDirection={sided});
  T.Sources.{kind}SpeedDependentForce b{i}(f_nominal=2, v_nominal=10, ForceDirection={sided});
  R.Sources.ConstantSpeed c{i}(w_fixed=v);
  T.Sources.ConstantSpeed d{i}(v_fixed=v);
"""
        connected += f"  connect(a{i}.flange, c{i}.flange); connect(b{i}.flange, d{i}.flange);\n"
    for speed in (5, -5):
        body = declared.replace("v = 5", f"v = {speed}") + f"equation\n{connected}"
        result = compute(body, stop=0.1)
        for i, law in enumerate(laws.values()):
            assert result[f"a{i}.tau"][-1] == pytest.approx(law(speed))
            assert -result[f"b{i}.f"][-1] == pytest.approx(law(speed))
