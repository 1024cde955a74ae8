"""Blocks: sources at their corners, controllers against closed forms, logic by its tables."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

HEAD = """
  import Modelica.Blocks.{Continuous, Logical, Nonlinear, Routing, Sources};
  import M = Modelica.Blocks.Math;
  import Init = Modelica.Blocks.Types.Init;
"""


@pytest.fixture
def compute(run: Callable[..., Any]) -> Callable[..., Any]:
    return lambda body, **options: run(HEAD + body, **options)


def at(result: Any, name: str, time: float) -> float:
    """The value at an instant, after its events."""
    return float(result[name][np.searchsorted(result.time, time + 1e-9) - 1])


#: Source, then values at times; at a corner the value after it.
SOURCES = {
    "Constant(k=3)": {0: 3, 1: 3},
    "Step(height=2, offset=1, startTime=0.5)": {0.4: 1, 0.5: 3, 1: 3},
    "Ramp(height=2, duration=0.4, startTime=0.2)": {0.1: 0, 0.4: 1, 0.6: 2, 1: 2},
    "Sine(amplitude=2, f=0.5, offset=1)": {0: 1, 0.5: 3, 1: 1},
    "Cosine(amplitude=2, f=0.5, startTime=0.5)": {0: 0, 0.5: 2, 1: 0},
    "ContinuousClock(startTime=0.25)": {0.2: 0, 1: 0.75},
    "ExpSine(f=0.25, damping=2)": {1: np.exp(-2)},
    "Exponentials(riseTime=0.5, riseTimeConst=0.1)": {
        0.2: 1 - np.exp(-2),
        1: (1 - np.exp(-5)) * np.exp(-5),
    },
    "Pulse(amplitude=5, width=20, period=0.5)": {0.05: 5, 0.1: 0, 0.3: 0, 0.5: 5, 0.65: 0},
    "Pulse(period=0.2, nperiod=2)": {0.05: 1, 0.25: 1, 0.45: 0, 0.85: 0},
    "SawTooth(amplitude=2, period=0.5)": {0.25: 1, 0.5: 0, 0.75: 1},
    "Trapezoid(rising=0.1, width=0.2, falling=0.1, period=0.5)": {
        0.05: 0.5,
        0.2: 1,
        0.35: 0.5,
        0.45: 0,
        0.55: 0.5,
    },
    "TimeTable(table=[0, 0; 0.5, 1; 0.5, 3; 1, 2])": {0.25: 0.5, 0.5: 3, 0.75: 2.5},
}


@pytest.mark.parametrize("source", SOURCES)
def test_sources(compute: Callable[..., Any], source: str) -> None:
    name, _, arguments = source.partition("(")
    result = compute(f"  Sources.{name} source({arguments};")
    for time, value in SOURCES[source].items():
        assert at(result, "source.y", time) == pytest.approx(value, abs=1e-9), time


def test_a_path_from_rest_to_rest_keeps_its_limits(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Sources.KinematicPTP2 path(
    q_begin={0, 1}, q_end={1, 0.5}, qd_max={2, 4}, qdd_max={10, 10}, startTime=0.1);
  Sources.KinematicPTP acceleration(deltaq={1}, qd_max={2}, qdd_max={10}, startTime=0.1);
  Real v(start=0, fixed=true);
  Real q(start=0, fixed=true);
equation
  der(v) = acceleration.y[1];
  der(q) = v;
"""
    )
    assert at(result, "path.q[1]", 1.0) == pytest.approx(1)
    assert at(result, "path.q[2]", 1.0) == pytest.approx(0.5)
    assert np.max(result["path.qd[1]"]) == pytest.approx(2)
    assert np.max(np.abs(result["path.qdd[1]"])) == pytest.approx(10)
    np.testing.assert_allclose(result["path.q[1]"], result["q"], atol=1e-7)
    np.testing.assert_allclose(result["path.qd[1]"], result["v"], atol=1e-7)


def test_boolean_sources(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Sources.BooleanStep step(startTime=0.5);
  Sources.BooleanPulse pulse(width=25, period=0.4);
  Sources.BooleanTable table(table={0.2, 0.6});
  Sources.SampleTrigger trigger(period=0.25);
  Integer n(start=0, fixed=true);
equation
  when trigger.y then
    n = pre(n) + 1;
  end when;
"""
    )
    for name, time, value in (
        ("step", 0.4, 0), ("step", 0.6, 1), ("pulse", 0.05, 1), ("pulse", 0.2, 0),
        ("pulse", 0.45, 1), ("table", 0.1, 0), ("table", 0.4, 1), ("table", 0.8, 0),
    ):  # fmt: skip
        assert at(result, f"{name}.y", time) == value, (name, time)
    assert at(result, "n", 0.9) == 4


def test_lags_follow_a_step(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Continuous.FirstOrder first(k=2, T=0.3, initType=Init.InitialState, u=1);
  Continuous.SecondOrder second(k=2, w=8, D=0.25, initType=Init.InitialState, u=1);
  Continuous.CriticalDamping critical(n=2, f=1, normalized=false, initType=Init.InitialState, u=1);
  Continuous.Integrator integral(k=3, y_start=1, u=2);
  Continuous.FirstOrder settled(k=2, T=0.3, initType=Init.SteadyState, u=1.5);
"""
    )
    t = result.time
    np.testing.assert_allclose(result["first.y"], 2 * (1 - np.exp(-t / 0.3)), atol=1e-7)
    w = 8 * np.sqrt(1 - 0.25**2)
    swing = np.exp(-2 * t) * (np.cos(w * t) + 2 / w * np.sin(w * t))
    np.testing.assert_allclose(result["second.y"], 2 * (1 - swing), atol=1e-6)
    x = 2 * np.pi * t
    np.testing.assert_allclose(result["critical.y"], 1 - (1 + x) * np.exp(-x), atol=1e-7)
    np.testing.assert_allclose(result["integral.y"], 1 + 6 * t, atol=1e-8)
    np.testing.assert_allclose(result["settled.y"], 3, atol=1e-9)


def test_an_integrator_is_set_anew(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Continuous.Integrator integral(use_reset=true, use_set=true, u=1);
equation
  integral.reset = time > 0.5;
  integral.set = 10;
"""
    )
    assert at(result, "integral.y", 0.4) == pytest.approx(0.4)
    assert at(result, "integral.y", 1.0) == pytest.approx(10.5)


def test_a_controller_s_step_response(compute: Callable[..., Any]) -> None:
    result = compute("  Continuous.PID pid(k=2, Ti=0.5, Td=0.1, Nd=10, u=1);")
    t = result.time
    exact = 2 * (1 + t / 0.5 + 10 * np.exp(-t / 0.01))
    np.testing.assert_allclose(result["pid.y"], exact, atol=1e-5)


def test_transfer_function_and_state_space_agree_with_the_closed_form(
    compute: Callable[..., Any],
) -> None:
    result = compute(
        """
  Continuous.TransferFunction f(b={1, 3}, a={1, 3, 2}, initType=Init.InitialState, u=1);
  Continuous.StateSpace s(
    A=[0, 1; -2, -3], B=[0; 1], C=[3, 1], initType=Init.InitialState, u={1});
  Continuous.TransferFunction gain(b={6}, a={2}, u=1);
"""
    )
    t = result.time
    exact = 1.5 - 2 * np.exp(-t) + 0.5 * np.exp(-2 * t)
    np.testing.assert_allclose(result["f.y"], exact, atol=1e-7)
    np.testing.assert_allclose(result["s.y[1]"], exact, atol=1e-7)
    assert result["gain.y"][-1] == 3


@pytest.mark.parametrize("kind", ["P", "PI", "PD", "PID"])
def test_a_limited_controller_without_limits_is_the_plain_one(
    compute: Callable[..., Any], kind: str
) -> None:
    result = compute(
        f"""
  Continuous.LimPID pid(
    controllerType=Modelica.Blocks.Types.SimpleController.{kind},
    k=2, Ti=0.5, Td=0.1, wd=1, yMax=1000);
equation
  pid.u_s = 1;
  pid.u_m = 0;
"""
    )
    t = result.time
    exact = 1 + 0 * t
    if "I" in kind:
        exact = exact + t / 0.5
    if "D" in kind:
        exact = exact + 10 * np.exp(-t / 0.01)
    np.testing.assert_allclose(result["pid.y"], 2 * exact, atol=1e-5)
    assert result["pid.controlError"][-1] == 1


def test_a_limited_controller_does_not_wind_up(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Continuous.LimPID pid(
    controllerType=Modelica.Blocks.Types.SimpleController.PI, k=2, Ti=0.5, yMax=1);
  Continuous.Integrator plant(u=pid.y);
equation
  pid.u_s = 5;
  connect(plant.y, pid.u_m);
""",
        stop=10.0,
    )
    assert np.max(result["pid.y"]) <= 1 + 1e-9
    # An ideal integral would have grown to 20 on the way; the overshoot stays small.
    assert np.max(result["plant.y"]) < 5.3
    assert result["plant.y"][-1] == pytest.approx(5, abs=1e-2)


def test_corners(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Nonlinear.Limiter limiter(uMax=0.5, uMin=-0.2);
  Nonlinear.VariableLimiter variable(limit1=0.5, limit2=-0.2);
  Nonlinear.DeadZone zone(uMax=0.5, uMin=-0.2);
  Nonlinear.SlewRateLimiter slew(Rising=1, Falling=-2, Td=1e-4);
  M.Abs size;
  M.Sign sign;
equation
  limiter.u = 2*time - 1;
  variable.u = 2*time - 1;
  zone.u = 2*time - 1;
  size.u = 2*time - 1;
  sign.u = 2*time - 1;
  slew.u = if time < 0.5 then 0 else 10;
"""
    )
    u = 2 * result.time - 1
    np.testing.assert_allclose(result["limiter.y"], np.clip(u, -0.2, 0.5), atol=1e-12)
    np.testing.assert_allclose(result["variable.y"], np.clip(u, -0.2, 0.5), atol=1e-12)
    np.testing.assert_allclose(result["zone.y"], u - np.clip(u, -0.2, 0.5), atol=1e-12)
    np.testing.assert_allclose(result["size.y"], np.abs(u), atol=1e-12)
    np.testing.assert_allclose(result["sign.y"], np.sign(u), atol=1e-12)
    assert result["slew.y"][-1] == pytest.approx(0.5, abs=1e-6)


FORMULAS = {
    "M.Gain b(k=3, u=x)": lambda x: 3 * x,
    "M.Add b(k2=-1, u1=x, u2=2)": lambda x: x - 2,
    "M.Add3 b(k3=-1, u1=x, u2=2, u3=3)": lambda x: x - 1,
    "M.Feedback b(u1=x, u2=2)": lambda x: x - 2,
    "M.Product b(u1=x, u2=x)": lambda x: x * x,
    "M.Division b(u1=x, u2=1 + x)": lambda x: x / (1 + x),
    "M.Sqrt b(u=x)": np.sqrt,
    "M.Exp b(u=x, base=2)": lambda x: 2**x,
    "M.Log b(u=1 + x, base=10)": lambda x: np.log10(1 + x),
    "M.Power b(u=x, N=3)": lambda x: x**3,
    "M.Sin b(u=x)": np.sin,
    "M.Atan2 b(u1=x, u2=-1)": lambda x: np.arctan2(x, -1),
    "M.Max b(u1=x, u2=0.5)": lambda x: np.maximum(x, 0.5),
    "M.Min b(u1=x, u2=0.5)": lambda x: np.minimum(x, 0.5),
    "M.Sum b(nin=3, u={x, 2, 3}, k={1, 2, 3})": lambda x: x + 4 + 9,
    "M.MultiSum b(nu=2, u={x, 2})": lambda x: x + 2,
    "M.MultiProduct b(nu=3, u={x, 2, 3})": lambda x: 6 * x,
    "M.LinearDependency b(y0=1, k1=2, k2=3, u1=x, u2=1)": lambda x: 2 * x + 4,
    "M.WrapAngle b(u=x + 3)": lambda x: np.where(x + 3 < np.pi, x + 3, x + 3 - 2 * np.pi),
    "Routing.RealPassThrough b(u=x)": lambda x: x,
    "M.BooleanToReal b(u=x > 0.505, realTrue=2)": lambda x: np.where(x > 0.505, 2, 0),
    "Logical.Switch b(u1=x, u2=x > 0.505, u3=-x)": lambda x: np.where(x > 0.505, x, -x),
    "Logical.Timer b(u=x > 0.505)": lambda x: np.maximum(x - 0.505, 0),
}


@pytest.mark.parametrize("block", FORMULAS)
def test_blocks_compute_their_formulas(compute: Callable[..., Any], block: str) -> None:
    result = compute(f"  Real x = time;\n  {block};")
    # At a jump both values are right.
    instants = np.array([event.time for event in result.events])
    rows = np.all(np.abs(result.time[:, None] - instants) > 1e-6, axis=1)
    exact = FORMULAS[block](result.time[rows])
    np.testing.assert_allclose(result["b.y"][rows], exact, atol=1e-9)


def test_vectors_of_signals(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  M.MatrixGain matrix(K=[1, 2; 3, 4], u={1, 10});
  Routing.Multiplex3 join(n2=2, u1={1}, u2={2, 3}, u3={4});
  Routing.DeMultiplex2 split(n1=1, n2=2);
  Routing.ExtractSignal extract(nin=3, nout=2, extract={3, 1}, u={5, 6, 7});
  Routing.RealReplicator copies(nout=2, u=8);
  Routing.Extractor chosen(nin=3, u={5, 6, 7}, index=2);
equation
  split.u = {1, 2, 3};
"""
    )
    expected = {
        "matrix.y[1]": 21, "matrix.y[2]": 43, "join.y[3]": 3, "join.y[4]": 4, "split.y1[1]": 1,
        "split.y2[2]": 3, "extract.y[1]": 7, "extract.y[2]": 5, "copies.y[2]": 8, "chosen.y": 6,
    }  # fmt: skip
    for name, value in expected.items():
        assert result[name][-1] == value, name


@pytest.mark.parametrize(
    ("block", "table"),
    [("And", "0001"), ("Or", "0111"), ("Xor", "0110"), ("Nor", "1000"), ("Nand", "1110")],
)
def test_truth_tables(compute: Callable[..., Any], block: str, table: str) -> None:
    result = compute(
        f"""
  Logical.{block} gate;
equation
  gate.u1 = time > 0.5;
  gate.u2 = mod(time, 0.5) > 0.25;
"""
    )
    found = "".join(str(int(at(result, "gate.y", t))) for t in (0.1, 0.4, 0.6, 0.9))
    assert found == table


def test_memory(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Logical.Hysteresis relay(uLow=-0.5, uHigh=0.5);
  Logical.OnOffController controller(bandwidth=1, reference=0);
  Logical.RSFlipFlop memory;
  Logical.Edge rise;
  Logical.FallingEdge fall;
  Logical.Change change;
  Logical.ZeroCrossing cross(enable=true);
  Integer n[4](each start=0, each fixed=true);
  Real wave = sin(2*Modelica.Constants.pi*time);
equation
  relay.u = wave;
  controller.u = wave;
  memory.S = wave > 0.9;
  memory.R = wave < -0.9;
  rise.u = wave > 0.1;
  fall.u = wave > 0.1;
  change.u = wave > 0.1;
  cross.u = wave - 0.1;
  when rise.y then
    n[1] = pre(n[1]) + 1;
  end when;
  when fall.y then
    n[2] = pre(n[2]) + 1;
  end when;
  when change.y then
    n[3] = pre(n[3]) + 1;
  end when;
  when cross.y then
    n[4] = pre(n[4]) + 1;
  end when;
""",
        stop=2.0,
    )
    assert [at(result, "relay.y", t) for t in (0.05, 0.25, 0.55, 0.75)] == [0, 1, 1, 0]
    assert [at(result, "controller.y", t) for t in (0.25, 0.5, 0.75, 1.0)] == [0, 0, 1, 1]
    assert [at(result, "memory.Q", t) for t in (0.05, 0.3, 0.6, 0.8)] == [0, 1, 1, 0]
    assert [at(result, f"n[{i}]", 2.0) for i in (1, 2, 3, 4)] == [2, 2, 4, 4]


def test_a_condition_ends_the_run(compute: Callable[..., Any]) -> None:
    result = compute("  Logical.TerminateSimulation stop(condition=time > 0.5);")
    assert result.time[-1] == pytest.approx(0.5)


def test_a_trapezoid_is_triggered(compute: Callable[..., Any]) -> None:
    result = compute(
        """
  Logical.TriggeredTrapezoid ramp(amplitude=2, rising=0.2, falling=0.4);
equation
  ramp.u = time > 0.1 and time < 0.5;
"""
    )
    for time, value in ((0.05, 0), (0.2, 1), (0.4, 2), (0.7, 1), (0.95, 0)):
        assert at(result, "ramp.y", time) == pytest.approx(value, abs=1e-8), time
