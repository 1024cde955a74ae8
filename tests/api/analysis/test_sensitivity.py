"""Sensitivities against closed forms and against differences of runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from planarc import Model, UsageError, load
from planarc.api.analysis import partials
from planarc.core.options import Backend


def test_of_a_filter(lag: Model) -> None:
    # x = exp(-t/T), u = 0: dx/dT = t/T^2*exp(-t/T), dy/dc1 = x
    found = lag.sensitivities(["T", "c[1]"], stop_time=3)
    t = found.time
    assert found.method == "equations"
    assert np.max(np.abs(found["x", "T"] - t / 4 * np.exp(-t / 2))) < 1e-8
    assert np.max(np.abs(found["y", "c[1]"] - np.exp(-t / 2))) < 1e-8
    assert np.max(np.abs(found["x", "c[1]"])) == 0
    assert np.max(np.abs(found.values("x") - np.exp(-t / 2))) < 1e-8


@pytest.mark.parametrize("parameter", ["crankBody.m", "couplerBody.I", "crank.r[1]", "world.g"])
def test_of_a_loop_agree_with_differences_of_runs(four_bar: Model, parameter: str) -> None:
    # Another length of the crank changes how the loop starts, too.
    value = four_bar.parameters[parameter].value
    h = 2e-3 * value
    runs = [
        four_bar.simulate(
            1.5,
            intervals=50,
            tolerance=1e-13,
            parameters={parameter: value + k * h},
            solver="cvode-adams",
        )
        for k in (2, 1, -1, -2)
    ]
    found = four_bar.sensitivities([parameter], stop_time=1.5, intervals=50)
    rows = [np.searchsorted(r.time, found.time - 1e-12) for r in runs]
    for name in ("revA.phi", "revD.w", "revC.frame_a.f[1]"):
        far, near, below, farthest = (r[name][i] for r, i in zip(runs, rows, strict=True))
        differences = (8 * (near - below) - (far - farthest)) / (12 * h)
        error = np.max(np.abs(found[name, parameter] - differences))
        assert error < 1e-6 * max(1.0, np.max(np.abs(differences)))


def test_of_a_loop_that_changes_its_states(crank_slider: Model) -> None:
    model = load(
        "model S extends Base(main.stateSelect = StateSelect.never, "
        "bigEnd.stateSelect = StateSelect.never, smallEnd.stateSelect = StateSelect.never); end S;"
        + crank_slider.request.file.read_text("utf-8").replace("CrankSlider", "Base"),  # type: ignore[union-attr]
        "S",
    )
    assert len(model.simulate(2).states) > 1
    found = model.sensitivities(["crank.m"], stop_time=2, intervals=50)
    same = crank_slider.sensitivities(["crank.m"], stop_time=2, intervals=50)
    for name in ("slide.s", "main.w"):
        size = np.max(np.abs(same[name, "crank.m"]))
        assert np.max(np.abs(found[name, "crank.m"] - same[name, "crank.m"])) < 1e-6 * size


@pytest.mark.parametrize("backend", list(Backend))
def test_formulas_and_differences_agree(
    four_bar: Model, backend: Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Model(four_bar.request, backend)
    asked = ["crankBody.m", "crank.r[1]"]
    found = model.sensitivities(asked, stop_time=0.5, intervals=10)
    assert (found.method, found.derivatives) == ("equations", "formulas")

    def none(*_: Any) -> Any:
        raise partials.NoFormulaError

    monkeypatch.setattr(partials.Formulas, "at", none)
    same = model.sensitivities(asked, stop_time=0.5, intervals=10)
    assert (same.method, same.derivatives) == ("equations", "differences")
    for parameter in asked:
        for name in ("revA.phi", "revD.w", "revC.frame_a.f[1]"):
            size = max(1.0, np.max(np.abs(same[name, parameter])))
            assert np.max(np.abs(found[name, parameter] - same[name, parameter])) < 1e-6 * size


@pytest.mark.parametrize("backend", list(Backend))
def test_of_a_pendulum_by_its_length(backend: Backend) -> None:
    """Its own variational equation, with J = I + m*l^2:

    J*phi'' = -m*g*l*cos(phi)
    J*s'' = m*g*l*sin(phi)*s - m*g*cos(phi) - 2*m*l*phi'',  s = d(phi)/dl
    """
    m, inertia, length, g = 2.0, 0.3, 0.7, 9.81
    model = load(
        "model P inner PlanarMultiBody.World world(n={0, -1});"
        " parameter Real l = 0.7; parameter Real tilt = 0.5;"
        " PlanarMultiBody.Joints.Revolute hinge(phi(start=tilt, fixed=true), w(fixed=true));"
        " PlanarMultiBody.Parts.Body bob(m=2, I=0.3, r_CM={l, 0});"
        " equation connect(world.frame_b, hinge.frame_a); connect(hinge.frame_b, bob.frame_a);"
        " end P;",
        backend=str(backend),
    )
    found = model.sensitivities(["l", "tilt"], stop_time=2, intervals=40)
    assert found.derivatives == "formulas"
    total = inertia + m * length**2

    def rates(_: float, z: Any) -> Any:
        phi, w, s, ds, r, dr = z
        a = -m * g * length * np.cos(phi) / total
        by_length = (m * g * (length * np.sin(phi) * s - np.cos(phi)) - 2 * m * length * a) / total
        return w, a, ds, by_length, dr, m * g * length * np.sin(phi) * r / total

    start = (0.5, 0, 0, 0, 1, 0)
    exact = solve_ivp(rates, (0, 2), start, "DOP853", found.time, rtol=1e-13, atol=1e-13).y
    for name, parameter, expected in (
        ("hinge.phi", "l", exact[2]),
        ("hinge.w", "l", exact[3]),
        ("hinge.phi", "tilt", exact[4]),
    ):
        assert np.max(np.abs(found[name, parameter] - expected)) < 1e-8 * np.max(np.abs(expected))


def test_a_start_value_of_the_user_does_not_move(four_bar: Model) -> None:
    """What the parameter gives the angle counts only where the user gives none."""
    model = load(
        "model S parameter Real a = 2; Real x(start=a, fixed=true); equation der(x) = -x; end S;"
    )
    t = model.sensitivities(["a"], stop_time=1).time
    assert np.allclose(model.sensitivities(["a"], stop_time=1)["x", "a"], np.exp(-t), atol=1e-8)
    assert not model.sensitivities(["a"], stop_time=1, start={"x": 3.0})["x", "a"].any()


def test_initial_equations_move_the_start() -> None:
    """x begins at rest, at u/k: d(x)/dk = -u/k^2; its start has no formula."""
    model = load(
        "model I parameter Real k = 2; parameter Real u = 3; Real x;"
        " initial equation der(x) = 0; equation der(x) = u - k*x; end I;"
    )
    found = model.sensitivities(["k"], stop_time=1)
    assert found.derivatives == "differences"
    assert np.allclose(found["x", "k"], -3 / 4, atol=1e-7)


def test_of_a_model_with_events_come_from_runs() -> None:
    model = load(
        "model Ball parameter Real e = 0.8; Real h(start=1, fixed=true); Real v(fixed=true);"
        " equation der(h) = v; der(v) = -9.81;"
        " when h < 0 then reinit(v, -e*pre(v)); end when; end Ball;"
    )
    found = model.sensitivities(["e"], stop_time=0.7)
    fall = np.sqrt(2 / 9.81)
    after = found.time > fall + 1e-2
    assert found.method == "differences"
    assert np.allclose(found["v", "e"][after], 9.81 * fall, rtol=1e-5)


def sampled(when: str, parameter: str) -> Model:
    return load(
        f"model S parameter Real {parameter}; Real x(start=1, fixed=true);"
        " discrete Real s(start=0, fixed=true); discrete Real c(start=0, fixed=true);"
        f" equation der(x) = -x; when {when} then s = x; c = pre(c) + 1; end when;"
        " annotation(experiment(StopTime=1, Interval=0.05, Tolerance=1e-9)); end S;"
    )


@pytest.mark.parametrize("instant", [0.5, 0.50001, 0.49999, 0.52, 1.0])
def test_rows_at_an_event_that_moves_with_the_parameter_are_one_sided(instant: float) -> None:
    """s = exp(-T) from T on, at the row of the event, too; also where an event is near a row."""
    found = sampled("time >= T", f"T = {instant}").sensitivities(["T"])
    happened = found.time >= instant
    assert np.allclose(found["s", "T"], np.where(happened, -np.exp(-instant), 0), atol=1e-6)
    assert np.allclose(found.values("s"), np.where(happened, np.exp(-instant), 0), atol=1e-9)
    assert np.allclose(found["x", "T"], 0, atol=1e-6)


def test_rows_at_samples_whose_interval_is_the_parameter() -> None:
    found = sampled("sample(0.1, p)", "p = 0.25").sensitivities(["p"])
    fired = np.floor((found.time - 0.1) / 0.25 + 1e-9)
    at = 0.1 + 0.25 * fired
    assert np.allclose(found["s", "p"], np.where(fired >= 0, -fired * np.exp(-at), 0), atol=1e-6)
    assert np.allclose(found.values("s"), np.where(fired >= 0, np.exp(-at), 0), atol=1e-9)


def test_of_a_ball_that_strikes_at_a_row() -> None:
    """h0 = g/2*t1^2 with t1 = 0.5; thereafter v = e*g*t1 - g*(t - t1)."""
    model = load(
        "model Ball parameter Real e = 0.8; parameter Real h0 = 9.81/8;"
        " Real h(start=h0, fixed=true); Real v(fixed=true); equation der(h) = v; der(v) = -9.81;"
        " when h < 0 then reinit(v, -e*pre(v)); end when; end Ball;"
    )
    found = model.sensitivities(["h0", "e"], stop_time=0.9, intervals=9)
    after = found.time > 0.49
    assert np.allclose(found["v", "h0"], np.where(after, 9.81 * 1.8 / (9.81 * 0.5), 0), atol=1e-5)
    assert np.allclose(found["v", "e"], np.where(after, 9.81 * 0.5, 0), atol=1e-5)
    assert np.allclose(found["h", "e"], after * 9.81 * 0.5 * (found.time - 0.5), atol=1e-5)


def test_what_events_on_both_sides_of_a_row_change_has_no_derivative_there() -> None:
    """At 0.5 one of two events comes later with p, the other earlier."""
    model = load(
        "model B parameter Real p = 0.5; discrete Real a(start=0, fixed=true);"
        " discrete Real b(start=0, fixed=true); Real x(start=1, fixed=true); Real y; equation"
        " der(x) = -p*x; y = a + b; when time >= p then a = time; end when;"
        " when time >= 1 - p then b = 2*time; end when; end B;"
    )
    found = model.sensitivities(["p"], stop_time=1, intervals=10)
    at = found.time == 0.5
    assert np.array_equal(np.isnan(found["y", "p"]), at)
    assert np.allclose(found["y", "p"][~at], np.where(found.time > 0.5, -1, 0)[~at], atol=1e-6)
    assert np.allclose(found["x", "p"], -found.time * np.exp(-0.5 * found.time), atol=1e-6)


def test_tables_of_pandas(lag: Model) -> None:
    pytest.importorskip("pandas")
    found = lag.sensitivities(["T"], stop_time=1)
    frame = found.to_pandas(["x"])
    assert np.array_equal(frame["x", "T"], found["x", "T"])


WRONG: list[tuple[str, Callable[[Model], Any], str]] = [
    ("name", lambda m: m.sensitivities(["TT"]), "no parameter"),
    ("none", lambda m: m.sensitivities([]), "no parameter is named"),
    ("None", lambda m: m.sensitivities(None), "no parameter is named"),  # type: ignore[arg-type]
    ("array", lambda m: m.sensitivities(["c"]), r"`c` is an array: name .* as in `c\[1\]`"),
    ("variable", lambda m: m.sensitivities(["x"]), r"a variable,[^\0]*as in `x\(start=x0\)`"),
    ("follows", lambda m: m.sensitivities(["y"]), "`y` is a variable, not a parameter$"),
    ("start", lambda m: m.sensitivities(["x.start"]), "`x.start` is the start value of a variable"),
    ("integer", lambda m: m.sensitivities(["n"]), "no derivative"),
    ("result", lambda m: m.sensitivities(["T"], stop_time=1)["z", "T"], "no variable"),
    (
        "one name",
        lambda m: m.sensitivities(["T"], stop_time=1)["x"],
        r'two names, of a variable and of a parameter[^\0]*write e.g. `\["x", "T"\]`',
    ),
    ("key", lambda m: m.sensitivities(["T"], stop_time=1)["x", "U"], "no parameter"),
]


@pytest.mark.parametrize("wrong", [w[1:] for w in WRONG], ids=[w[0] for w in WRONG])
def test_a_wrong_request_is_refused(lag: Model, wrong: Any) -> None:
    request, words = wrong
    with pytest.raises(UsageError, match=words):
        request(lag)
