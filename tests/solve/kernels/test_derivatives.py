"""All derivatives from formulas, held against differences: of every value by states and by
parameters, through torn loops, contacts, friction, tables and functions, at random states."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import planarc
from planarc.api.analysis.partials import Formulas, NoFormulaError
from planarc.api.analysis.point import Point, open_point
from planarc.core.options import Backend, RunOptions
from planarc.ir.derivatives import Scope
from planarc.solve.solvers import cvode

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "tests" / "benchmarks"))

from engine_bench import model as family  # noqa: E402

EXAMPLES = "PlanarMultiBody.Examples"
CASES = ROOT / "tests" / "cases"

BLOCKS = """model Signals "Functions, tables and blocks of the standard library"
  function bump "An algorithm with a loop and a choice"
    input Real x;
    input Real k;
    output Real y;
  algorithm
    y := 0;
    for i in 1:3 loop
      y := y + sin(i*x)/(i + k);
    end for;
    if x > 0.2 then
      y := y*exp(-x);
    end if;
  end bump;
  parameter Real gain = 1.3;
  Modelica.Blocks.Sources.Sine sine(f=0.3, amplitude=gain);
  Modelica.Blocks.Continuous.FirstOrder lag(T=0.4, k=2, y(start=0.3));
  Modelica.Blocks.Math.Product product;
  Modelica.Blocks.Tables.CombiTable1Ds table(table=[0, 0; 1, 2; 2, 1; 4, 3]);
  Real v(start=0.5, fixed=true);
equation
  connect(sine.y, lag.u);
  connect(lag.y, product.u1);
  product.u2 = bump(v, gain);
  table.u = 1 + v*v;
  der(v) = -v + product.y + 0.3*table.y[1] + sqrt(v*v + gain);
end Signals;
"""

MODELS = {
    "four_bar": f"{EXAMPLES}.Loops.FourBar",
    "crank_slider": f"{EXAMPLES}.Loops.CrankSlider",
    "two_loops": f"{EXAMPLES}.Loops.TwoLoops",
    "engine": f"{EXAMPLES}.Loops.PistonEngine",
    "cam": f"{EXAMPLES}.CurveCurveJoint.CamFollower",
    "spline": f"{EXAMPLES}.CurveCurveJoint.SplineCam",
    "sides": f"{EXAMPLES}.CurveCurveJoint.CurveCurveJointSwitchSides",
    "line_force": f"{EXAMPLES}.Elementary.LineForceWithTwoMasses",
    "bouncing": f"{EXAMPLES}.Elementary.BouncingMass",
    "friction": CASES / "i5_breakaway",
    "chain": family("chain", 5),
    "ladder": family("ladder", 3),
    "blocks": BLOCKS,
}
#: Compiled for both back ends; the others share their code up to the printer.
BOTH = ("four_bar", "cam", "friction", "chain", "ladder", "blocks")
ASKED = [*((n, Backend.NATIVE) for n in MODELS), *((n, Backend.NUMPY) for n in BOTH)]


def loaded(name: str, backend: Backend) -> planarc.Model:
    source = MODELS[name]
    if isinstance(source, Path):
        source = next(source.glob("*.pmo"))
    return planarc.load(source, backend=str(backend))


def some_parameters(model: planarc.Model) -> dict[str, float]:
    """Four of those that are not zero, from the first to the last."""
    real = [
        p
        for p in model.program.parameter_slots
        if p.settable and not p.structural and p.kind.value == "Real" and p.default
    ]
    return {p.name: float(p.default or 0.0) for p in real[:: max(1, len(real) // 4)][:4]}


def at_start(
    model: planarc.Model, options: RunOptions, name: str = "", value: float = 0.0
) -> Point:
    values = {**options.values, name: value} if name else options.values
    return open_point(model, replace(options, values=values))


def differences(near: Any, h: float) -> Any:
    """Of order four; `near(k)` gives the values at k steps."""
    return (8 * (near(1) - near(-1)) - near(2) + near(-2)) / (12 * h)


@pytest.mark.parametrize(("name", "backend"), ASKED, ids=[f"{n}-{b}" for n, b in ASKED])
def test_formulas_agree_with_differences(name: str, backend: Backend) -> None:
    model = loaded(name, backend)
    options = RunOptions(backend=backend)
    values = some_parameters(model)
    point = at_start(model, options)
    slots = [c.slot for c in model.program.columns if not c.constant]
    y = point.y + 1e-3 * np.random.default_rng(7).normal(size=len(point.y))
    here, by_states, by_parameters = Formulas(point, values, options).at(point.t, y, slots)
    assert np.array_equal(here, point.outputs(y)[slots])
    for j in range(len(y)):
        h = 1e-4 * max(1.0, abs(y[j]))
        unit = h * np.eye(len(y))[j]
        expected = differences(lambda k, u=unit: point.outputs(y + k * u)[slots], h)
        assert np.max(np.abs(by_states[:, j] - expected)) < 1e-6 * max(1, np.max(np.abs(expected)))
    for j, (parameter, value) in enumerate(values.items()):
        h = 1e-4 * abs(value)
        sides = {k: at_start(model, options, parameter, value + k * h) for k in (-2, -1, 1, 2)}
        for side in sides.values():
            side.kernel.select(point.selection)
            side.accept(point.y)
        expected = differences(lambda k, s=sides: s[k].outputs(y)[slots], h)
        error = np.max(np.abs(by_parameters[:, j] - expected))
        assert error < 1e-6 * max(1, np.max(np.abs(expected)))


def test_the_past_has_no_formula_by_parameters() -> None:
    text = (
        "model D parameter Real k = 2; Real x(start=1, fixed=true);"
        " equation der(x) = -k*delay(x, 0.1); end D;"
    )
    compiled = planarc.load(text).compiled()
    assert compiled.slopes(Scope.ALL) is None
    assert compiled.slopes(Scope.RATES) is not None


@pytest.mark.parametrize("backend", list(Backend))
def test_a_point_without_derivative_is_told(backend: Backend) -> None:
    text = "model S Real x(start=0, fixed=true); equation der(x) = 1 - sqrt(abs(x)); end S;"
    options = RunOptions(backend=backend)
    point = open_point(planarc.load(text, backend=str(backend)), options)
    with pytest.raises(NoFormulaError):
        Formulas(point, {}, options).at(0.0, np.array([0.0]), [point.states[0].derivative])
    _, found, _ = Formulas(point, {}, options).at(
        0.0, np.array([0.25]), [point.states[0].derivative]
    )
    assert found[0, 0] == pytest.approx(-1.0)


def test_equal_code_of_models_that_may_be_asked_for_more() -> None:
    """An Integer and a Real parameter give the same code; only one has derivatives."""
    text = "model K parameter Integer n = 2; Real x(start=1, fixed=true);"
    text += " equation der(x) = -n*x; end K;"
    for kind in ("Integer", "Real"):
        model = planarc.load(text.replace("Integer", kind))
        point = open_point(model, RunOptions())
        found = Formulas(point, {"n": 2.0}, RunOptions()).at(
            0.0, point.y, [point.states[0].derivative]
        )
        assert found[2][0, 0] == pytest.approx(-1.0)


# CVODE


def run(monkeypatch: pytest.MonkeyPatch, source: str, most: float, **options: Any) -> Any:
    """From formulas from `most` evaluations for differences on, however few states there are."""
    monkeypatch.setattr(cvode, "MOST_DIFFERENCES", most)
    monkeypatch.setattr(cvode, "FEWEST_COMPILED", 1)
    return planarc.load(source).simulate(solver="cvode-bdf", **options)


def test_cvode_goes_on_with_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    """From where differences have cost enough, in machine code: the same motion, and no
    evaluation for differences any more."""
    monkeypatch.setattr(cvode, "JUDGED_OFTEN", 50)
    chain = family("chain", 12)
    asked: Any = {"stop_time": 1, "tolerance": 1e-9}
    found = {most: run(monkeypatch, chain, most, **asked) for most in (0, 30, float("inf"))}
    counts = {most: r.statistics for most, r in found.items()}
    assert "(native)" in counts[0].solver
    assert [("formulas" in c.reason) for c in counts.values()] == [True, True, False]
    jacobians = counts[0].jacobians
    assert jacobians > 2
    assert counts[float("inf")].rhs_calls - counts[0].rhs_calls >= 24 * (jacobians - 1)
    for r in found.values():
        assert np.max(np.abs(r["rev[6].phi"] - found[0]["rev[6].phi"])) < 1e-6


@pytest.mark.parametrize("name", ["crank_slider", "sides", "bouncing"])
def test_through_events_and_other_states(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    source = str(MODELS[name])
    derived = run(monkeypatch, source, 0, stop_time=2, tolerance=1e-9)
    plain = run(monkeypatch, source, float("inf"), stop_time=2, tolerance=1e-9)
    assert "formulas" in derived.statistics.reason
    assert len(derived.events) == len(plain.events)
    assert len(derived.states) == len(plain.states)
    for state in derived.states[0].states:
        a, b = derived[state][-1], plain[state][-1]
        assert a == pytest.approx(b, abs=1e-5 * max(1, abs(b)))


def test_machine_code_takes_differences_where_there_is_no_derivative(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """sqrt(x) at x = 0, where the run begins and, for one of two, stays."""
    text = "model R Real x(start=0, fixed=true); Real y(start=0, fixed=true); Real z(start=1,"
    text += " fixed=true); equation der(x) = 1 - sqrt(x) - 50*(z - x); der(y) = -sqrt(abs(y));"
    text += " der(z) = 100*(x - z) + y; end R;"
    derived = run(monkeypatch, text.replace("sqrt(x)", "sqrt(abs(x))"), 0, stop_time=1)
    plain = run(monkeypatch, text.replace("sqrt(x)", "sqrt(abs(x))"), 1e9, stop_time=1)
    assert derived.statistics.jacobians > 0
    assert derived["z"][-1] == pytest.approx(plain["z"][-1], abs=1e-5)


BEARINGS = """model Bearings "Two bearings that stick at first: who holds how much is open"
  import Modelica.Mechanics.Rotational;
  Rotational.Components.Inertia rotor(J=0.5, phi(start=0, fixed=true), w(start=0, fixed=true));
  Rotational.Components.BearingFriction left(tau_pos=[0, 1]);
  Rotational.Components.BearingFriction right(tau_pos=[0, 2]);
  Rotational.Sources.Torque drive;
equation
  drive.tau = time;
  connect(drive.flange, left.flange_a);
  connect(left.flange_b, rotor.flange_a);
  connect(rotor.flange_b, right.flange_a);
end Bearings;
"""


@pytest.mark.parametrize("backend", list(Backend))
def test_a_mode_that_leaves_unknowns_open_is_told(backend: Backend) -> None:
    model = planarc.load(BEARINGS, backend=str(backend))
    stuck = open_point(model, RunOptions(backend=backend))
    with pytest.raises(NoFormulaError):
        Formulas(stuck, {}, RunOptions(backend=backend)).at(0.0, stuck.y, [])
    sliding = open_point(model, RunOptions(backend=backend, stop=5.0), at=4.0)
    rates = [c.derivative for c in sliding.states]
    _, found, _ = Formulas(sliding, {}, RunOptions(backend=backend)).at(4.0, sliding.y, rates)
    assert np.isfinite(found).all()


def test_cvode_goes_through_such_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    found = run(monkeypatch, BEARINGS, 0, stop_time=6, tolerance=1e-8)
    t = found.time
    assert found["rotor.w"] == pytest.approx(np.where(t > 3, (t - 3) ** 2, 0.0), abs=1e-6)
