"""Every integrator gives the answers that the laws of mechanics ask for."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions, Solver
from planarc.solve.simulate import simulate
from planarc.solve.solvers import sundials
from planarc.solve.solvers.sundials import Unavailable

SOLVERS = [Solver.CVODE_BDF, Solver.CVODE_ADAMS, Solver.LSODA, Solver.SCIPY_BDF]


def run(tools: Any, mechanism: Any, **options: Any) -> Any:
    program = mechanism.program()
    options.setdefault("tolerance", 1e-8)
    return simulate(
        program, tools.Interpreter(program), RunOptions(backend=Backend.NUMPY, **options)
    )


def pendulum_angle(t: np.ndarray) -> np.ndarray:
    """From the horizontal, released at rest: sin(theta/2) = k sn(K + w t), theta from below."""
    k = math.sin(math.pi / 4)
    sn = ellipj(ellipk(k * k) + math.sqrt(9.81) * t, k * k)[0]
    return 2 * np.arcsin(k * sn) - math.pi / 2


@pytest.mark.parametrize("solver", SOLVERS)
def test_pendulum_follows_its_elliptic_function(tools: Any, solver: Solver) -> None:
    result = run(tools, tools.pendulum(stop=5.0), solver=solver)
    assert result.ended is None
    assert np.max(np.abs(result["rev.phi"] - pendulum_angle(result.time))) < 3e-6
    energy = 0.5 * result["der(rev.phi)"] ** 2 + 9.81 * np.sin(result["rev.phi"])
    assert np.ptp(energy) < 3e-5


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_error_falls_with_the_tolerance(tools: Any, solver: Solver) -> None:
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        result = run(tools, tools.pendulum(stop=3.0), solver=solver, tolerance=tolerance)
        errors.append(np.max(np.abs(result["rev.phi"] - pendulum_angle(result.time))))
    assert errors[0] > 5 * errors[1] > 25 * errors[2] > 125 * errors[3]
    assert errors[3] < 1e-7


def test_all_solvers_agree_on_a_four_bar(tools: Any) -> None:
    results = [run(tools, tools.four_bar(), solver=s, intervals=50) for s in SOLVERS]
    for other in results[1:]:
        for name in ("revA.phi", "revD.phi", "lambda0"):
            assert np.allclose(other[name], results[0][name], rtol=2e-4, atol=2e-4), name


def test_rows_stand_where_they_were_asked_for(tools: Any) -> None:
    result = run(tools, tools.pendulum(stop=1.0), interval=0.3)
    assert np.allclose(result.time, [0.0, 0.3, 0.6, 0.9, 1.0], atol=0)
    assert result.time[-1] == 1.0
    result = run(tools, tools.pendulum(stop=1.0), start=0.5, stop=0.5)
    assert result.time.tolist() == [0.5]
    assert len(run(tools, tools.pendulum()).time) == 501


def test_a_model_without_states_runs_without_an_integrator(tools: Any) -> None:
    """A crank that is driven by time: its rod follows."""

    def driven(t: Any, q: list[Any]) -> list[Any]:
        return [t.sub(q[0], t.time), t.sub(t.call("sin", q[1]), t.mul(t.const(0.5), q[0]))]

    mechanism = tools.Mechanism(
        [tools.Coordinate("a.phi"), tools.Coordinate("b.phi")],
        mass=lambda t, q: [[t.one, t.zero], [t.zero, t.one]],
        force=lambda t, q, v: [t.zero, t.zero],
        constraints=driven,
        stop=1.5,
    )
    result = run(tools, mechanism, intervals=30)
    assert result.ended is None
    assert result.statistics.solver == "none"
    assert np.allclose(result["b.phi"], np.arcsin(result.time / 2), atol=1e-10)
    assert np.allclose(result["der(b.phi)"], 0.5 / np.sqrt(1 - result.time**2 / 4), atol=1e-9)


def test_a_missing_library_is_replaced_and_named(
    tools: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise Unavailable("scikit-sundae is not installed")

    monkeypatch.setattr("planarc.solve.solvers.cvode.open_sundials", missing)
    result = run(tools, tools.pendulum(), solver=Solver.AUTO)
    assert result.statistics.solver == "lsoda (scipy)"
    assert "scikit-sundae is not installed" in result.statistics.reason
    with pytest.raises(PlanarcError, match=r"R450.*cvode-bdf"):
        run(tools, tools.pendulum(), solver=Solver.CVODE_BDF)


def test_libraries_are_found_by_the_wheels_list(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "sksundae").mkdir()
    (tmp_path / "sksundae" / "__init__.py").touch()
    record = tmp_path / "scikit_sundae-1.2.0.dist-info" / "RECORD"
    record.parent.mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "sksundae", raising=False)
    libs = "scikit_sundae.libs"
    for names in (
        [f"{libs}/libsundials_core-94.so.7.9.0", f"{libs}/libsundials_cvode-1.so.7"],
        [f"sksundae/.dylibs/libsundials_{part}.7.3.0.dylib" for part in ("core", "cvode")],
        [f"{libs}/sundials_core-a1.dll", f"{libs}/sundials_cvode-b2.dll"],
    ):
        listed = ["sksundae/c_cvode.pxd", "sksundae/sundials_core.pxd", *names[::-1]]
        record.write_text("".join(f"{name},sha256=QGpDpI,177065\n" for name in listed))
        assert sundials._library_files() == [tmp_path / name for name in names]
    record.write_text("")
    with pytest.raises(Unavailable, match="brings no SUNDIALS library"):
        sundials._library_files()
    monkeypatch.setitem(sys.modules, "sksundae", None)
    with pytest.raises(Unavailable, match="is not installed"):
        sundials._library_files()


def test_an_interrupt_keeps_the_rows(tools: Any) -> None:
    program = tools.pendulum(stop=50.0).program()
    kernel = tools.Interpreter(program)
    inner, calls = kernel.rhs, [0]

    def rhs(*arguments: Any) -> int:
        calls[0] += 1
        if calls[0] == 400:
            raise KeyboardInterrupt
        return inner(*arguments)

    kernel.rhs = rhs
    for solver in SOLVERS:
        calls[0] = 0
        result = simulate(program, kernel, RunOptions(backend=Backend.NUMPY, solver=solver))
        assert result.ended.code == "R440"
        assert 5 < len(result.time) < 501
        assert np.all(np.diff(result.time) > 0)
        assert np.max(np.abs(result["rev.phi"])) < 4


def test_progress_is_told_in_simulated_time(tools: Any) -> None:
    program = tools.pendulum(stop=2.0).program()
    seen: list[float] = []
    simulate(
        program,
        tools.Interpreter(program),
        RunOptions(backend=Backend.NUMPY),
        progress=seen.append,
    )
    assert seen == sorted(seen)
    assert seen[-1] == 2.0
    assert len(seen) >= 2
