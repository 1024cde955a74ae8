"""The equations as a function, and linear models for other tools."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planarc

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"
CART = """model Cart "A mass on a spring"
  input Real f(start=0);
  parameter Real k = 4;
  parameter Real d = 0.2;
  Real x(start=0.5, fixed=true);
  Real v(start=0, fixed=true);
  output Real y = 2*x;
equation
  der(x) = v;
  der(v) = f - k*x - d*v;
end Cart;"""


@pytest.fixture(scope="module")
def cart() -> planarc.Model:
    return planarc.load(CART)


def test_the_function_gives_the_derivatives(cart: planarc.Model) -> None:
    f = cart.rhs(parameters={"k": 5})
    assert (f.states, f.inputs, f.t0) == (("x", "v"), ("f",), 0.0)
    assert (f.x0.tolist(), f.u0.tolist()) == ([0.5, 0.0], [0.0])
    assert f(0, [1, 2], [3]).tolist() == pytest.approx([2, 3 - 5 - 0.4])
    assert f(0, {"v": 2}, {"f": 1}).tolist() == pytest.approx([2, 1 - 2.5 - 0.4])
    assert f.outputs(0, [1, 2], names=["y", "v"]).tolist() == [2, 2]
    A, B = f.jacobian(0, [1, 2], [3])
    assert pytest.approx(np.array([[0, 1], [-5, -0.2]])) == A
    assert pytest.approx(np.array([[0], [1]])) == B


def test_the_jacobian_at_a_contact_that_rests_is_that_of_the_function() -> None:
    f = planarc.load("PlanarMultiBody.Examples.Contacts.RockingBlock").rhs()
    A, _ = f.jacobian(f.t0, f.x0)
    assert A.shape == (6, 6)
    step = 1e-6 * np.eye(6)
    rows = [(f(f.t0, f.x0 + h) - f(f.t0, f.x0 - h)) / 2e-6 for h in step]
    assert np.allclose(A, np.transpose(rows), atol=1e-5)


def test_another_integrator_comes_to_the_same_motion() -> None:
    from scipy.integrate import solve_ivp

    model = planarc.load(FOUR_BAR)
    f = model.rhs()
    found = solve_ivp(f, (0, 1), f.x0, rtol=1e-9, atol=1e-9)
    wanted = model.simulate(1, tolerance=1e-10)
    assert found.y[0, -1] == pytest.approx(wanted["revA.phi"][-1], abs=1e-6)


def test_relations_keep_their_truth_until_they_are_settled() -> None:
    text = """model Stop Real x(start=1, fixed=true); equation der(x) = if x > 0 then -1 else 1;
    end Stop;"""
    f = planarc.load(text).rhs()
    assert f(0, [-1])[0] == -1
    assert f.settle(0, [-1])
    assert f(0, [-1])[0] == 1


@pytest.mark.parametrize(
    ("x", "told"),
    [
        ([1], r"C203.*`x` takes 2 numbers, not the shape \(1,\)"),
        ([[1, 2]], "C203"),
        ("ab", "C202"),
        ([1, np.nan], "C202.*finite"),
        ({"q": 1}, "C201.*no state `q`"),
    ],
)
def test_wrong_numbers_are_told(cart: planarc.Model, x: object, told: str) -> None:
    with pytest.raises(planarc.UsageError, match=f"(?s){told}"):
        cart.rhs()(0, x)  # type: ignore[arg-type]


def test_a_vibration_is_answered_as_the_formula_says(cart: planarc.Model) -> None:
    w = np.array([0.0, 1.0, 2.0, 5.0])
    bode = cart.linearize().bode(w)
    wanted = 2 / (4 - w**2 + 0.2j * w)
    assert bode["y", "f"] == pytest.approx(wanted)
    assert bode.magnitude[0, 0] == pytest.approx(abs(wanted))
    assert bode.decibels[0, 0] == pytest.approx(20 * np.log10(abs(wanted)))
    assert bode.phase[0, 0] == pytest.approx(np.unwrap(np.angle(wanted)))
    own = cart.linearize().bode()
    assert own.w[own.magnitude[0, 0].argmax()] == pytest.approx(2, rel=0.02)
    undamped = cart.linearize(parameters={"d": 0}).bode([2.0])
    assert not np.isfinite(undamped.magnitude[0, 0, 0])
    with pytest.raises(planarc.UsageError, match="no output `z`"):
        bode["z", "f"]


def test_bode_is_drawn(cart: planarc.Model) -> None:
    pytest.importorskip("matplotlib").use("agg")
    size, angle = cart.linearize().bode().plot()
    assert (size.get_ylabel(), angle.get_ylabel()) == ("magnitude [dB]", "phase [deg]")


def test_scipy_takes_the_linear_model(cart: planarc.Model) -> None:
    linear = cart.linearize()
    system = linear.to_scipy()
    assert np.sort_complex(np.linalg.eigvals(system.A)) == pytest.approx(
        np.sort_complex(linear.eigenvalues)
    )


def test_control_takes_the_linear_model(cart: planarc.Model) -> None:
    pytest.importorskip("control")
    system = cart.linearize(outputs=["x", "der(x)"]).to_control()
    assert system.output_labels == ["x", "der_x"]


def test_a_missing_package_is_told(cart: planarc.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(planarc.UsageError, match=r"C221.*control"):
        cart.linearize().to_control()


def test_without_inputs_or_outputs_there_is_no_answer(cart: planarc.Model) -> None:
    for call in ("bode", "to_scipy", "to_control"):
        with pytest.raises(planarc.UsageError, match=r"C248.*no output"):
            getattr(cart.linearize(outputs=[]), call)()
        with pytest.raises(planarc.UsageError, match=r"C248.*no input"):
            getattr(planarc.load(FOUR_BAR).linearize(outputs=["revA.phi"]), call)()
    for w in ("fast", [], [-1.0], [np.nan]):
        with pytest.raises(planarc.UsageError, match="C202"):
            cart.linearize().bode(w)  # type: ignore[arg-type]
