"""Time events and samples: none is lost, wherever the run stands in time."""

from __future__ import annotations

import math

import pytest

import planarc
from planarc.core.diagnostic import PlanarcError, Severity

SOLVERS = ["cvode-bdf", "lsoda", "scipy-bdf"]


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("start", [0.0, -0.5, 1e6, 1.7e9])
@pytest.mark.parametrize("from_zero", [False, True])
def test_a_run_may_begin_at_any_time(
    backend: str, solver: str, start: float, from_zero: bool
) -> None:
    """101 samples, two instants written in two ways, and a root: as many as from zero."""
    model = planarc.load(
        f"""model M
  Integer n(start=0, fixed=true), a(start=0, fixed=true), b(start=0, fixed=true);
  Integer c(start=0, fixed=true);
  Real x(start=0, fixed=true);
equation
  der(x) = 1;
  when sample({0.0 if from_zero and start > 0 else start!r}, 1e-2) then
    n = pre(n) + 1;
  end when;
  when time >= {start!r} + 0.5 then
    a = pre(a) + 1;
  end when;
  when 0.1*(time - ({start!r})) > 0.07 then
    b = pre(b) + 1;
  end when;
  when x > 0.255 then
    c = pre(c) + 1;
  end when;
end M;""",
        backend=backend,
    )
    result = model.simulate(start + 1, start_time=start, intervals=10, solver=solver)
    assert [int(result[name][-1]) for name in "nabc"] == [101, 1, 1, 1]
    assert result["x"][-1] == pytest.approx(1.0, abs=1e-4)


def test_short_runs_have_their_samples(backend: str) -> None:
    model = planarc.load(
        """model M
  Integer n(start=0, fixed=true);
equation
  when sample(0, 1e-12) then
    n = pre(n) + 1;
  end when;
end M;""",
        backend=backend,
    )
    assert model.simulate(1e-10, intervals=4)["n"][-1] == 101
    with pytest.raises(PlanarcError) as caught:
        model.simulate(1.0)
    (found,) = caught.value.diagnostics
    assert (found.code, found.span.line) == ("R434", 4)
    assert "1e+12 times" in found.message
    with pytest.raises(PlanarcError):
        model.simulate(1e6 + 1e-6, start_time=1e6)


@pytest.mark.parametrize("interval", ["0", "-1"])
def test_a_sampler_without_instants_is_told(backend: str, interval: str) -> None:
    model = planarc.load(
        f"""model M
  Integer n(start=0, fixed=true);
equation
  when sample(0, {interval}) then
    n = pre(n) + 1;
  end when;
end M;""",
        backend=backend,
    )
    result = model.simulate(1.0)
    (found,) = result.warnings
    assert (found.code, found.severity, found.span.line) == ("R434", Severity.WARNING, 4)
    assert result["n"][-1] == 0


@pytest.mark.parametrize("solver", ["cvode-bdf", "cvode-adams", "lsoda"])
def test_a_jump_may_set_off_what_no_digit_of_the_time_shows(backend: str, solver: str) -> None:
    """The first step behind it is smaller than the digits of the time: no event again."""
    text = """
    model M
      Real x(start=0, fixed=true);
    equation
      der(x) = 1e18*(if time < 0.1 then 0 else 1) - x;
    end M;
    """
    result = planarc.load(text, backend=backend).simulate(1, tolerance=1e-8, solver=solver)
    assert result.ended is None
    assert result.at("x", 1) == pytest.approx(1e18 * (1 - math.exp(-0.9)), rel=1e-6)
