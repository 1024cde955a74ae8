"""A run that cannot go on, by every solver and in both back ends: when, why, which equation
on which line, which state was fastest, and the rows up to there."""

from __future__ import annotations

import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.cli.app import run
from planarc.core.diagnostic import Diagnostic
from planarc.core.options import FIXED_STEP

Stopped = Callable[..., tuple[Diagnostic, planarc.Result]]

ADAPTIVE = ["cvode-bdf", "cvode-adams", "lsoda", "scipy-bdf"]
FIXED = [solver.value for solver in FIXED_STEP]
BACKENDS = ["numpy", "native"]

#: x = 1/(1 - t)^2: no integrator comes beyond t = 1.
BLOW_UP = """model BlowUp
  Real slow(start=0, fixed=true), x(start=1, fixed=true), v(start=2, fixed=true);
equation
  der(slow) = 1;
  der(x) = v;
  der(v) = 6*x^2;
end BlowUp;
"""

#: The root has no value beyond t = 0.5.
ROOT = """model Root
  Real x(start=0, fixed=true), y(start=0, fixed=true), s;
equation
  der(y) = 3;
  s = sqrt(0.5 - time);
  der(x) = s;
end Root;
"""

#: z^2 + exp(z) is nowhere below 0.827; from t = 0.5288 on it would have to be.
BLOCK = """model Block
  Real x(start=0, fixed=true), y(start=0, fixed=true), z(start=1.2);
equation
  der(y) = 3;
  z^2 + exp(z) = 4 - 6*time;
  der(x) = z;
end Block;
"""

#: Below x = 0.3 it is pushed up, above it pulled down, 1e9 times as fast as it came.
ROUGH = """model Rough
  Real x(start=1, fixed=true), y(start=0, fixed=true);
equation
  der(y) = 1;
  der(x) = if time < 0.5 then -x else noEvent(if x > 0.3 then -1e9*x else 1e9);
end Rough;
"""


def options(solver: str) -> dict[str, object]:
    return {"solver": solver, **({"fixed_step": 1e-3} if solver in FIXED else {})}


def check_rows(result: planarc.Result, latest: float, earliest: float) -> None:
    assert earliest <= result.time[-1] <= latest
    assert all(np.isfinite(result[name]).all() for name in result)
    assert result.time[0] == 0
    assert (np.diff(result.time) >= 0).all()


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("solver", [*ADAPTIVE, *FIXED])
def test_a_blow_up(solver: str, backend: str, stopped: Stopped) -> None:
    diagnostic, result = stopped(BLOW_UP, backend, 2.0, **options(solver))
    assert diagnostic.code in ("R420", "R421")
    assert "`der(v) = 6*x^2`" in diagnostic.message
    assert diagnostic.span is not None
    assert diagnostic.span.line == 6
    fastest = str(diagnostic.hint).partition("moved fastest were ")[2]
    assert fastest.startswith(("`v` (rate ", "`x` (rate "))
    assert "`slow`" not in fastest.partition(" and ")[0]
    check_rows(result, 1.03, 0.99)  # a method of fixed steps sees it late
    before = result.time < 0.7
    if solver in ADAPTIVE:
        assert result["x"][before] == pytest.approx((1 - result.time[before]) ** -2, rel=1e-3)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("solver", [*ADAPTIVE, *FIXED])
def test_a_value_that_is_not_finite(solver: str, backend: str, stopped: Stopped) -> None:
    diagnostic, result = stopped(ROOT, backend, 2.0, **options(solver))
    assert diagnostic.code == "R421"
    assert diagnostic.message.startswith("right after t = 0.5 s `s = sqrt(")
    assert diagnostic.span is not None
    assert diagnostic.span.line == 5
    assert "moved fastest were `y` (rate 3)" in str(diagnostic.hint)
    check_rows(result, 0.5, 0.49)
    exact = (0.5**1.5 - (0.5 - result.time) ** 1.5) / 1.5
    assert result["x"] == pytest.approx(exact, abs=1e-3)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("solver", [*ADAPTIVE, *FIXED])
def test_a_block_without_solution(solver: str, backend: str, stopped: Stopped) -> None:
    diagnostic, result = stopped(BLOCK, backend, 2.0, **options(solver))
    assert diagnostic.code == "R422"
    assert "t = 0.528" in diagnostic.message
    assert diagnostic.span is not None
    assert diagnostic.span.line == 5
    assert "no solution from here on" in str(diagnostic.hint)
    assert "moved fastest were `y` (rate 3)" in str(diagnostic.hint)
    check_rows(result, 0.529, 0.52)
    z = result["z"]
    assert z**2 + np.exp(z) == pytest.approx(4 - 6 * result.time, abs=1e-9)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("solver", ["lsoda", "scipy-bdf"])
def test_steps_without_end(solver: str, backend: str, stopped: Stopped) -> None:
    """A slope that jumps at each step: the error test fails, or the run would creep."""
    diagnostic, result = stopped(ROUGH, backend, 2.0, solver=solver)
    assert diagnostic.code in ("R420", "R426")
    told = "10,000 steps bring " if diagnostic.code == "R426" else "the "
    assert diagnostic.message.startswith(f"the integration stopped at t = 0.5 s: {told}")
    assert "`x` was worst, which `der(x) = if time < 0.5 then -x" in diagnostic.message
    assert diagnostic.span is not None
    assert diagnostic.span.line == 5
    assert "fastest were `x` (rate " in str(diagnostic.hint)
    check_rows(result, 0.500001, 0.5)
    before = result.time < 0.5
    assert result["x"][before] == pytest.approx(np.exp(-result.time[before]), abs=1e-4)


@pytest.mark.parametrize("solver", [*ADAPTIVE, *FIXED])
def test_the_command_keeps_the_rows_and_fails(
    solver: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("root.pmo").write_text(ROOT, "utf-8")
    step = ["--fixed-step", "1e-3"] if solver in FIXED else []
    code = run(["simulate", "root.pmo", "--stop", "2", "--solver", solver, *step])
    told = capsys.readouterr().err
    assert code == 3
    assert "error[R421]" in told
    assert "root.pmo:5:3" in told
    lines = Path("Root.csv").read_text("utf-8").splitlines()
    assert 0.49 <= float(lines[-1].split(",")[0]) <= 0.5
    assert Path("Root.html").exists()


def test_numbers_too_large_for_the_page_tell_nothing_of_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("blow.pmo").write_text(BLOW_UP, "utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code = run(
            ["simulate", "blow.pmo", "--stop", "2", "--solver", "euler", "--fixed-step=1e-3"]
        )
    assert code == 3
    assert Path("BlowUp.html").exists()


#: Runs that would take hours; each gets SIGINT when it is under way.
INTERRUPTED = """
import os, signal, sys, threading
from planarc.cli.app import run
from planarc.core.options import FIXED_STEP
from planarc.solve.run import Run

fixed = [solver.value for solver in FIXED_STEP]
go = Run.go

def go_on(self, progress):
    timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))

    def told(t):
        if t > 1 and timer.ident is None:
            timer.start()

    go(self, told)

Run.go = go_on
for solver in sys.argv[2:]:
    step = ["--fixed-step", "1e-3"] if solver in fixed else []
    code = run(["--quiet", "simulate", "endless.pmo", "--stop", "1e5", "--interval", "0.1",
                "--solver", solver, "--backend", sys.argv[1], "--no-report",
                "--output", solver + ".csv", *step])
    print(solver, code, flush=True)
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_ctrl_c_keeps_the_rows_with_every_solver(backend: str, tmp_path: Path) -> None:
    (tmp_path / "endless.pmo").write_text(
        "model Endless Real x(start=1, fixed=true), v(start=0, fixed=true);"
        " equation der(x) = v; der(v) = -x; end Endless;",
        "utf-8",
    )
    solvers = [*ADAPTIVE, *FIXED]
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, backend, *solvers],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.stdout.split("\n")[:-1] == [f"{solver} 130" for solver in solvers], done.stderr
    assert done.stderr.count("error[R440]: interrupted at t = ") == len(solvers)
    for solver in solvers:
        lines = (tmp_path / f"{solver}.csv").read_text("utf-8").splitlines()
        assert len(lines) > 2
        t, x = (float(v) for v in lines[2].split(",")[:2])
        assert (t, x) == (pytest.approx(0.1), pytest.approx(np.cos(0.1), abs=1e-3))
