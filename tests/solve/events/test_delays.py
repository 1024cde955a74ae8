"""`delay` against closed forms: of functions of time, and delay differential equations."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from planarc import Model, PlanarcError, load
from planarc.api.result import Result, RunStopped

SOLVERS = ["cvode-bdf", "cvode-adams", "lsoda", "scipy-bdf"]


def model(folder: Path, body: str, name: str = "M") -> Model:
    file = folder / f"{name}.mo"
    file.write_text(f"model {name}\n{body}\nend {name};\n")
    return load(file)


def run(folder: Path, body: str, backend: str = "native", solver: str = "auto") -> Result:
    return model(folder, body).simulate(backend=backend, solver=solver, tolerance=1e-9)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_delay_of_a_sine(tmp_path: Path, backend: str) -> None:
    result = run(
        tmp_path,
        "Real y = delay(sin(time), 0.7);  annotation(experiment(StopTime=3));",
        backend,
    )
    exact = [math.sin(t - 0.7) if t > 0.7 else 0.0 for t in result.time]
    assert result["y"] == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("fast", [30, 300])
def test_delay_of_what_turns_often_within_a_step(tmp_path: Path, fast: int, solver: str) -> None:
    """The states move evenly, so that steps are long."""
    body = f"""
      Real x(start=0, fixed=true);
      Real y = delay(sin({fast}*time) + x, 0.5);
    equation
      der(x) = 0.1;
      annotation(experiment(StopTime=10));
    """
    result = run(tmp_path, body, solver=solver)
    late = np.maximum(result.time - 0.5, 0.0)
    assert result["y"] == pytest.approx(np.sin(fast * late) + 0.1 * late, abs=1e-7)


def by_steps(t: float) -> float:
    """der(x) = -x(t - 1), x = 1 up to 0: a polynomial on each step of length 1."""
    return math.fsum(
        (-1) ** k * (t - k + 1) ** k / math.factorial(k) for k in range(int(t) + 2) if t >= k - 1
    )


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_method_of_steps(tmp_path: Path, backend: str, solver: str) -> None:
    body = """
      parameter Real T = 1;
      Real x(start=1, fixed=true);
    equation
      der(x) = -delay(x, T);
      annotation(experiment(StopTime=4));
    """
    result = run(tmp_path, body, backend, solver)
    assert result["x"] == pytest.approx([by_steps(t) for t in result.time], abs=3e-7)
    assert len(result.time) == 501


def test_error_falls_with_the_tolerance(tmp_path: Path) -> None:
    body = """
      Real x(start=1, fixed=true);
    equation
      der(x) = -delay(x, 1);
      annotation(experiment(StopTime=4));
    """
    delayed = model(tmp_path, body)
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        result = delayed.simulate(tolerance=tolerance)
        errors.append(abs(result["x"] - [by_steps(t) for t in result.time]).max())
    assert all(b < a / 10 for a, b in pairwise(errors))


def test_linear_equation_grows_with_its_root(tmp_path: Path) -> None:
    # x = exp(s*t) solves der(x) = a*x(t - T) where s = a*exp(-s*T). From x = 1 other roots
    # die out, so that the ratio over one second tends to exp(s).
    s = 0.5
    a = s * math.exp(s * 0.8)
    body = f"""
      Real x(start=1, fixed=true);
    equation
      der(x) = {a!r}*delay(x, 0.8);
      annotation(experiment(StopTime=20, Interval=1));
    """
    x = run(tmp_path, body)["x"]
    assert x[-1] / x[-2] == pytest.approx(math.exp(s), rel=1e-7)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_jump_comes_back_exactly(tmp_path: Path, backend: str) -> None:
    body = """
      Real u = if time < 0.5 then 0 else 1;
      Real y = u - 0.5*delay(y, 0.25);
      Integer n(start=0, fixed=true);
      discrete Real at(start=-1, fixed=true);
    equation
      when delay(u, 0.3) > 0.5 then
        n = pre(n) + 1;
        at = time;
      end when;
      annotation(experiment(StopTime=1.4));
    """
    result = run(tmp_path, body, backend)
    for begin, value in ((0.0, 0.0), (0.5, 1.0), (0.75, 0.5), (1.0, 0.75), (1.25, 0.625)):
        inside = (result.time > begin) & (result.time < begin + (0.5 if begin == 0 else 0.25))
        assert result["y"][inside] == pytest.approx(value, abs=1e-12)
    assert result["n"][-1] == 1
    assert result["at"][-1] == pytest.approx(0.8, abs=1e-12)
    assert [e.time for e in result.events] == pytest.approx([0.5, 0.75, 0.8, 1.0, 1.25])


@pytest.mark.parametrize("sign", ["", "-"])
@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_held_signal_bounds_no_step(tmp_path: Path, backend: str, sign: str) -> None:
    """Long and short delays of what changes at events only, beside a motion that is smooth."""
    body = f"""
      Integer n(start=0, fixed=true);
      Real u = {sign}n;
      Real late = delay(-u, 0.001);
      Real later = delay(2*u + 1, 1.25);
      Real gate = delay(if x > 0.95 then 5 else 7, 0.002);
      Real x(start=1, fixed=true);
    equation
      der(x) = -0.01*x;
      when sample(0.5, 0.5) then
        n = pre(n) + 1;
      end when;
      annotation(experiment(StopTime=10, Interval=0.1));
    """
    result = run(tmp_path, body, backend)
    for name, interval, scale, start in (("late", 0.001, -1, 0), ("later", 1.25, 2, 1)):
        t = result.time - interval
        clear = abs(2 * t - np.round(2 * t)) > 1e-6  # beside the jumps
        exact = start + scale * (-1 if sign else 1) * np.maximum(np.floor(2 * t), 0)
        assert result[name][clear] == pytest.approx(exact[clear], abs=0)
    closed = -100 * math.log(0.95)
    t = result.time - closed - 0.002
    clear = abs(t) > 1e-4  # the error of x, by its small rate
    assert result["gate"][clear] == pytest.approx(np.where(t < 0, 5, 7)[clear], abs=0)
    assert result["x"] == pytest.approx(np.exp(-0.01 * result.time), rel=1e-7)
    assert result.statistics.steps < 750  # 10,000 where steps are bounded
    times = sorted({round(e.time, 6) for e in result.events})
    jumps = {k / 2 for k in range(1, 21)}
    back = {j + d for j in jumps for d in (0.001, 1.25) if j + d <= 10}
    assert times == pytest.approx(sorted(jumps | back | {closed, closed + 0.002}), abs=1e-4)


def test_of_held_and_smooth_signals_the_smooth_ones_bound_steps(tmp_path: Path) -> None:
    body = """
      Real u = delay(if time < 0.5 then 1.1 else 3.3, 1e-6);
      Real y = delay(sin(5*time), 0.01);
      annotation(experiment(StopTime=1));
    """
    result = run(tmp_path, body)
    assert result["y"] == pytest.approx(np.sin(5 * np.maximum(result.time - 0.01, 0)), abs=1e-10)
    t = 0.5 + 1e-6
    far = abs(result.time - t) > 1e-9
    # No digit is lost where a short piece of the past goes on as a tangent.
    assert result["u"][far].tolist() == np.where(result.time < t, 1.1, 3.3)[far].tolist()
    assert result.statistics.steps >= 100


def test_what_is_rounded_with_events_is_held(tmp_path: Path) -> None:
    body = """
      Integer n(start=0, fixed=true);
      Integer m = integer(delay(n, 0.003));
      Real last = delay(m, 0.004);
    equation
      when sample(0.5, 0.5) then
        n = pre(n) + 1;
      end when;
      annotation(experiment(StopTime=10, Interval=0.1));
    """
    result = run(tmp_path, body)
    assert result.statistics.steps < 1000  # 2,500 where they are bounded
    t = result.time - 0.007
    clear = abs(2 * t - np.round(2 * t)) > 1e-6
    exact = np.maximum(np.floor(2 * t), 0)
    assert result["last"][clear].tolist() == exact[clear].tolist()


@pytest.mark.parametrize(
    "signal", ["if b then 1 else 0", "noEvent(integer(2*x + integer(y)))", "noEvent(integer(2*x))"]
)
def test_what_changes_without_an_event_is_not_held(tmp_path: Path, signal: str) -> None:
    """A discrete variable with an equation is another one from row to row."""
    body = f"""
      Real x(start=0, fixed=true);
      Real y = 0.3;
      Boolean b = noEvent(x > 0.5);
      Integer k = {signal};
      Real late = delay(k, 0.002);
    equation
      der(x) = 1;
      annotation(experiment(StopTime=1, Interval=0.25));
    """
    result = run(tmp_path, body)
    assert result.events == ()
    assert result.statistics.steps >= 500


@pytest.mark.parametrize("solver", ["auto", "lsoda"])
def test_relay_oscillates(tmp_path: Path, solver: str) -> None:
    # x rises at 1 until 0.3 s after it passed 0.2, and falls likewise: a triangle.
    body = """
      Real x(start=0, fixed=true);
    equation
      der(x) = if delay(x, 0.3) > 0.2 then -1 else 1;
      annotation(experiment(StopTime=3));
    """
    result = run(tmp_path, body, solver=solver)
    assert [e.time for e in result.events] == pytest.approx([0.5, 1.1, 1.7, 2.3, 2.9], abs=1e-8)
    assert (result["x"].max(), result["x"].min()) == pytest.approx((0.5, -0.1), abs=1e-8)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_delay_that_changes(tmp_path: Path, backend: str) -> None:
    body = """
      Real T = 0.5 + 0.4*sin(3*time);
      Real y = delay(sin(time), T, 1);
      annotation(experiment(StopTime=5));
    """
    result = run(tmp_path, body, backend)
    then = result.time - result["T"]
    assert result["y"] == pytest.approx(np.where(then > 0, np.sin(then), 0.0), abs=1e-9)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_derivative_of_a_delay(tmp_path: Path, backend: str) -> None:
    body = """
      Real y = delay(sin(2*time), 0.3);
      Real v = der(y);
      annotation(experiment(StopTime=2));
    """
    result = run(tmp_path, body, backend)
    late = result.time > 0.3 + 1e-9
    phase = 2 * (result.time - 0.3)
    assert result["v"][late] == pytest.approx(2 * np.cos(phase[late]), abs=1e-9)
    assert result["v"][result.time < 0.29] == pytest.approx(0)


def test_index_reduction_through_a_delay(tmp_path: Path) -> None:
    # A damper between the ground and a slider that follows the delayed motion of a mass.
    body = """
      Real s(start=0, fixed=true), v(start=1, fixed=true), r, f;
    equation
      der(s) = v;
      der(v) = -4*s;
      r = delay(s, 0.5);
      f = 3*der(r);
      annotation(experiment(StopTime=3));
    """
    result = run(tmp_path, body)
    late = result.time > 0.51
    exact = 3 * np.cos(2 * (result.time[late] - 0.5))
    assert result["f"][late] == pytest.approx(exact, abs=3e-4)


def test_delayed_growth_settles(tmp_path: Path) -> None:
    body = """
      Real x(start=0.5, fixed=true);
    equation
      der(x) = x*(1 - delay(x, 1));
      annotation(experiment(StopTime=300, Interval=1));
    """
    delayed = model(tmp_path, body)
    result = delayed.simulate()
    assert result["x"][-50:] == pytest.approx(1, abs=1e-4)  # stable while T < pi/2


@pytest.mark.parametrize("gain", [0.5, -3.0])
def test_start_that_depends_on_the_delay(tmp_path: Path, gain: float) -> None:
    body = f"""
      Real x;
      Real z = 1 + ({gain})*delay(z, 0.5);
    initial equation
      der(x) = 0;
    equation
      der(x) = -2*delay(x, 0.5) - x + 6;
      annotation(experiment(StopTime=0.4));
    """
    result = run(tmp_path, body)
    assert result["x"] == pytest.approx(2, abs=1e-8)
    assert result["z"] == pytest.approx(1 / (1 - gain), abs=1e-8)


def test_delay_of_a_parameter_and_by_nothing(tmp_path: Path) -> None:
    body = "parameter Real p = 3; Real y = delay(p, 1) + delay(time, 0);"
    result = run(tmp_path, body)
    assert result["y"] == pytest.approx(3 + result.time)


@pytest.mark.parametrize(
    ("body", "code"),
    [
        ("Real y = delay(sin(time), -1);", "L362"),
        ("Real y = delay(sin(time), time);", "L363"),
        ("Real y = delay(sin(time), time, 1 + time);", "L363"),
        ("parameter Real T = -1; Real y = delay(sin(time), T);", "R461"),
        ("Real y = 1 + delay(y, 1);", "R463"),
        ("Real y = delay(sin(time), 1); Real v = der(y); Real a = der(v);", "S315"),
    ],
)
def test_delays_that_cannot_be(tmp_path: Path, body: str, code: str) -> None:
    with pytest.raises(PlanarcError) as caught:
        run(tmp_path, body)
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_delay_beyond_its_maximum_ends_the_run(tmp_path: Path) -> None:
    with pytest.raises(RunStopped, match="R462") as caught:
        run(tmp_path, "Real y = delay(sin(time), 2*time, 1);")
    assert caught.value.result.time[-1] < 0.52


def test_no_linear_model(tmp_path: Path) -> None:
    body = "Real x(start=1, fixed=true); equation der(x) = -delay(x, 1);"
    with pytest.raises(PlanarcError, match="R474"):
        model(tmp_path, body).linearize()


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_delay_while_steps_collapse_ends_the_run(backend: str) -> None:
    """At a pole the inner points of a step coincide, and no polynomial goes through them."""
    text = "model M Real x(start=1, fixed=true); equation der(x) = x^2 + delay(x, 0.01); end M;"
    with pytest.raises(RunStopped, match="R42"):
        load(text, backend=backend).simulate(2.0)


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_delay_of_the_time_zero_is_its_signal(tmp_path: Path, backend: str) -> None:
    # Also in a loop, where a signal from the past would be no equation for x.
    body = """
      parameter Real T = 0;
      parameter Real k = 2;
      Real x(start=1, fixed=true);
      Real y = x - 0.5*delay(y, k*T);
    equation
      der(x) = -x;
      annotation(experiment(StopTime=1));
    """
    instant = model(tmp_path, body)
    result = instant.simulate(backend=backend, tolerance=1e-9)
    assert result["y"] == pytest.approx(result["x"] / 1.5, abs=1e-12)
    with pytest.warns(UserWarning, match="`T` is structural"):
        late = instant.simulate(parameters={"T": 0.25}, backend=backend, tolerance=1e-9)
    y, t = late["y"], late.time
    past = np.interp(t - 0.5, t, y, left=y[0])
    assert np.max(np.abs(y - late["x"] + 0.5 * past)[t < 0.49]) < 1e-9
