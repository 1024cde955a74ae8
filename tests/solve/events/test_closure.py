"""Loops of numbers through when-clauses and equations, against their solutions."""

from __future__ import annotations

import numpy as np
import pytest

import planarc
from planarc.solve.events.closure import close_loop


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


@pytest.mark.parametrize("gain", [-0.45, 0.45, -0.999, 3.0, -20.0])
def test_a_clause_in_a_loop_with_an_equation(backend: str, gain: float) -> None:
    """a = k*b + 1 and b = 2*a + x: a = (k*x + 1)/(1 - 2*k)."""
    result = planarc.load(
        f"""model M
  Real x(start=0, fixed=true), a(start=0, fixed=true), b;
equation
  der(x) = 1;
  b = 2*a + x;
  when sample(0.5, 0.5) then
    a = {gain}*b + 1;
  end when;
end M;""",
        backend=backend,
    ).simulate(0.8)
    assert result["a"][-1] == pytest.approx((gain * 0.5 + 1) / (1 - 2 * gain), rel=1e-9)
    assert len(result.events) == 1


def test_several_numbers_and_a_truth(backend: str) -> None:
    """The truth that the numbers switch belongs to their solution."""
    result = planarc.load(
        """model M
  Real x(start=0, fixed=true), a(start=0, fixed=true), c(start=0, fixed=true), b;
  Boolean low = b < -1;
equation
  der(x) = 1;
  b = 2*a + x + c;
  when sample(0.5, 0.5) then
    a = 3*b + 1;
    c = a - 5*b;
  end when;
end M;""",
        backend=backend,
    ).simulate(0.6)
    assert [result[n][-1] for n in ("a", "c", "low")] == pytest.approx([-2.5, 10 / 3, 1])


def test_a_loop_without_a_solution_is_told(backend: str) -> None:
    model = planarc.load(
        """model M
  Real a(start=0, fixed=true), b;
equation
  b = a + 1;
  when sample(0.5, 0.5) then
    a = b;
  end when;
end M;""",
        backend=backend,
    )
    with pytest.raises(planarc.RunStopped) as stopped:
        model.simulate(0.8)
    (found,) = stopped.value.diagnostics
    assert found.code == "R433"
    assert "`a`" in found.message


def test_a_curved_loop() -> None:
    """x = cos(y), y = sin(x) + 1, from far away."""
    w = [0.0, 5.0, -3.0]

    def one_pass() -> bool:
        w[1], w[2] = float(np.cos(w[2])), float(np.sin(w[1])) + 1
        return True

    assert close_loop(w, [1, 2], one_pass)
    assert w[1] == pytest.approx(np.cos(w[2]), abs=1e-10)
    assert w[2] == pytest.approx(np.sin(w[1]) + 1, abs=1e-10)
    assert w[0] == 0
