"""Derivatives with poles: a run ends before them, and follows no root that is no solution."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import planarc

#: Equations, the name of what falls, the time at which it arrives, and where.
POLES = {
    "der(x) = -1/x": ("Real x(start=1, fixed=true); equation der(x) = -1/x;", "x", 0.5),
    "from below": ("Real x(start=-1, fixed=true); equation der(x) = -1/x;", "x", 0.5),
    "in a loop": ("Real x(start=1, fixed=true), v; equation der(x) = v; v*x = -1;", "x", 0.5),
    "beside another": (
        "Real x(start=1, fixed=true), z(start=0, fixed=true); equation der(x) = -1/x; der(z) = x;",
        "x",
        0.5,
    ),
    "of third order": ("Real x(start=1, fixed=true); equation der(x) = -x^(-3);", "x", 0.25),
    "quick": ("Real x(start=1, fixed=true); equation der(x) = -1e3/x;", "x", 0.5e-3),
    "a fall on a line": (
        "Real x(start=1, fixed=true), v(start=0, fixed=true); "
        "equation der(x) = v; der(v) = -1/(x*abs(x));",
        "x",
        math.pi / math.sqrt(8),
    ),
    "a fall into a point field": (
        "Real x(start=1, fixed=true), y(start=0, fixed=true), u(start=0, fixed=true), "
        "v(start=0, fixed=true), r = sqrt(x^2 + y^2); "
        "equation der(x) = u; der(y) = v; der(u) = -x/r^3; der(v) = -y/r^3;",
        "x",
        math.pi / math.sqrt(8),
    ),
}


#: The same, where no derivative changes its sign.
EVEN_POLES = {
    "of second order": ("Real x(start=1, fixed=true); equation der(x) = -1/x^2;", "x", 1 / 3),
    "of fourth order": ("Real x(start=1, fixed=true); equation der(x) = -x^(-4);", "x", 0.2),
    "a fall with one sign": (
        "Real x(start=1, fixed=true), v(start=0, fixed=true); "
        "equation der(x) = v; der(v) = -1/x^2;",
        "x",
        math.pi / math.sqrt(8),
    ),
}


@pytest.fixture(params=["numpy", "native"])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param == "native":
        pytest.importorskip("llvmlite")
    return str(request.param)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("case", POLES)
def test_a_run_ends_at_a_pole(case: str, tolerance: float, backend: str) -> None:
    _ends(*POLES[case], tolerance, backend)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
@pytest.mark.parametrize("case", EVEN_POLES)
def test_a_run_ends_at_a_pole_without_a_change_of_sign(
    case: str, tolerance: float, backend: str
) -> None:
    _ends(*EVEN_POLES[case], tolerance, backend)


def _ends(body: str, name: str, arrival: float, tolerance: float, backend: str) -> None:
    model = planarc.load(f"model M {body} end M;", backend=backend)
    with pytest.raises(planarc.RunStopped) as caught:
        model.simulate(4 * arrival, tolerance=tolerance)
    result = caught.value.result
    assert caught.value.diagnostics[0].code in ("R420", "R421")
    assert result.time[-1] <= arrival * (1 + 100 * tolerance)
    assert result.time[-1] > 0.98 * arrival
    x = result[name] * np.sign(result[name][0])
    assert (x > -1e-9).all()
    assert (np.diff(x) <= 0).all()


@pytest.mark.parametrize(
    "derivative",
    [
        "cos(20*time)*100",
        "-x",
        "1e9*cos(1e9*x)",
        "1e7",
        "-1e6*(x - sin(time))",
        "-sin(x)/x",
        "-noEvent(sign(x))/9",
        "if time < 1 then 1 else 1e12*cos(time)",
    ],
)
def test_a_change_of_sign_that_is_none_is_passed(derivative: str, backend: str) -> None:
    body = f"Real x(start=0.7, fixed=true); equation der(x) = {derivative};"
    result = planarc.load(f"model M {body} end M;", backend=backend).simulate(2)
    assert result.time[-1] == 2


def test_a_dead_point_is_no_pole() -> None:
    # A rocker mechanism whose speeds are large beside its dead points: the way that a step leads
    # goes out of the loop's reach, where its rates grow as towards a pole.
    model = planarc.load(Path(__file__).parents[3] / "examples" / "four_bar.pmo")
    longer = {"coupler.r": [1.5, 0]}
    runs = [model.simulate(2, tolerance=t, parameters=longer) for t in (1e-9, 1e-12)]
    coarse, fine = (run.at("revB.phi", 2.0) for run in runs)
    assert coarse == pytest.approx(fine, abs=1e-5)
