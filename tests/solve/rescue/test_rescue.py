"""Models whose equations do not let Newton's method through from their start values."""

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


def run(body: str, backend: str, stop: float = 1.0) -> planarc.Result:
    return planarc.load(f"model M\n{body}\nend M;", backend=backend).simulate(stop, intervals=10)


def codes(result: planarc.Result) -> list[str]:
    return [w.code for w in result.warnings]


def test_a_square_starts_beside_its_singular_point(backend: str) -> None:
    result = run("Real x; equation x^2 = 9 + time;", backend)
    assert result["x"] == pytest.approx([math.sqrt(9 + t) for t in result.time], rel=1e-9)
    assert codes(result) == ["R436"]
    assert "`x^2 = time + 9`" in result.warnings[0].message


def test_a_start_near_the_other_root_chooses_it_without_a_word(backend: str) -> None:
    result = run("Real x(start=-1); equation x^2 = 9;", backend)
    assert result["x"][0] == pytest.approx(-3.0, rel=1e-12)
    assert codes(result) == []


def test_a_diode_starts_from_nothing(backend: str) -> None:
    """exp(400) is no number to take a step from, exp(10/0.025) that of the first one."""
    body = """
  Real i, v;
equation
  10 = 100*i + v;
  i = 1e-14*(exp(v/0.025) - 1);"""
    result = run(body, backend)
    v = result["v"][0]
    assert 100 * result["i"][0] + v == pytest.approx(10, rel=1e-12)
    assert v == pytest.approx(0.025 * math.log(result["i"][0] / 1e-14 + 1), rel=1e-9)


def test_a_cubic_at_its_fold_goes_on_along_the_other_branch(backend: str) -> None:
    """x = -1 solves it at t = 0 and nothing near it does later: 2 does."""
    result = run("Real x(start=-1); equation x^3 - 3*x = 2 + 3*time;", backend)
    assert result["x"][0] == pytest.approx(2.0, rel=1e-9)
    assert result["x"][-1] == pytest.approx(2.2790187861665936, rel=1e-9)


def test_the_root_is_kept_by_a_motion_that_follows_it(backend: str) -> None:
    """y is 2*x or -2*x; whichever the start has taken is kept."""
    result = run("Real x(start=1, fixed=true), y; equation der(x) = -y; y^2 = 4*x^2;", backend)
    ratio = result["y"] / result["x"]
    assert ratio == pytest.approx(np.full(len(ratio), ratio[0]), rel=1e-9)
    assert abs(math.log(result["x"][-1])) == pytest.approx(2, rel=1e-3)


def test_without_a_solution_it_is_said_what_was_tried(backend: str) -> None:
    with pytest.raises(planarc.PlanarcError) as caught:
        run("Real x(start=1), y; equation x^2 + y^2 = -9; x - y^3 = 1;", backend)
    assert caught.value.diagnostics[0].code == "R410"
    told = str(caught.value)
    assert "`x^2 + y^2 = -9` is off by 10" in told
    assert "a line search" in told
    assert "a homotopy" in told
