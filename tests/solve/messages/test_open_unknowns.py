"""Modes in which the equations leave unknowns open: loads are shared, motion is not guessed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.diagnostic import Severity
from planarc.core.options import Backend, RunOptions
from planarc.ir.program import Program
from planarc.request.request import Request
from planarc.solve.kernels.singular import solve_open
from planarc.solve.messages.open_unknowns import judge_open


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(text: str, backend: Backend, stop: float) -> Any:
    options = RunOptions(stop=stop, intervals=2000, tolerance=1e-8, backend=backend)
    return compiler.run(compiler.compile_model(Request(text=text), backend), options)


TWO_BEARINGS = """
model M
  import Modelica.Mechanics.Rotational;
  Rotational.Components.Inertia rotor(J=0.5, phi(start=0, fixed=true), w(start=0, fixed=true));
  Rotational.Components.BearingFriction left(tau_pos=[0, 1]);
  Rotational.Components.BearingFriction right(tau_pos=[0, 2]);
  Rotational.Sources.Torque drive;
equation
  drive.tau = {drive};
  connect(drive.flange, left.flange_a);
  connect(left.flange_b, rotor.flange_a);
  connect(rotor.flange_b, right.flange_a);
end M;
"""


class Rigid:
    """A kernel whose block is singular to rounding alone: nothing in it can be moved."""

    open_block = 0

    def __init__(self, program: Program) -> None:
        self.w = [0.0] * program.size

    def rhs(self, t: float, y: list[float], rates: list[float]) -> int:
        return 0

    def sway(self, block: int, amount: float) -> None: ...

    def outputs(self, t: float, y: list[float]) -> int:
        return 0


def test_what_cannot_be_moved_is_not_open() -> None:
    text = TWO_BEARINGS.format(drive="time")
    program = compiler.compile_model(Request(text=text)).program
    kernel: Any = Rigid(program)
    assert judge_open(program, kernel, 0.0, [0.0, 0.0]) is None


@pytest.mark.parametrize("sign", [1, -1])
def test_two_stuck_bearings_hold_together_and_break_away_at_their_sum(
    sign: int, backend: Backend
) -> None:
    result = run(TWO_BEARINGS.format(drive=f"{sign}*time"), backend, 6.0)
    assert result.ended is None
    t = result.time
    # 0.5*w' = t - 3 from t = 3 on.
    expected = sign * np.where(t > 3, (t - 3) ** 2, 0.0)
    assert result["rotor.w"] == pytest.approx(expected, abs=1e-6)
    taken = result["left.tau"] + result["right.tau"]
    assert taken[t < 3] == pytest.approx(sign * t[t < 3], abs=1e-9)
    assert np.all(np.abs(result["left.tau"]) <= 1 + 1e-9)
    assert np.all(np.abs(result["right.tau"]) <= 2 + 1e-9)
    told = [w for w in result.warnings if w.code == "R425"]
    assert len(told) == 1
    assert "`left` and `right`" in told[0].message


def test_two_bearings_lose_what_the_drive_gives(backend: Backend) -> None:
    result = run(TWO_BEARINGS.format(drive="5*sin(time)"), backend, 15.0)
    assert result.ended is None
    t, w = result.time, result["rotor.w"]
    assert w.max() > 0.5
    assert w.min() < -0.5
    given = np.trapezoid(5 * np.sin(t) * w, t)
    lost = np.trapezoid(3 * np.abs(w), t)
    assert 0.25 * w[-1] ** 2 == pytest.approx(given - lost, abs=5e-3)


def test_a_part_that_loses_its_mass_is_told(backend: Backend) -> None:
    result = run(
        """
model M
  Real x(start = 1, fixed = true), v(start = 0, fixed = true);
  Real mass = if time < 0.5 then 2 else 0;
equation
  v = der(x);
  mass*der(v) = 0;
end M;
""",
        backend,
        1.0,
    )
    assert result.ended is not None
    assert (result.ended.code, result.ended.severity) == ("R424", Severity.ERROR)
    assert "0.5 s" in result.ended.message
    assert result.time[-1] == pytest.approx(0.5)


# The elimination ---------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_open_unknowns_keep_their_values_and_all_rows_are_met(seed: int) -> None:
    random = np.random.default_rng(seed)
    n = int(random.integers(2, 9))
    rank = int(random.integers(1, n))
    a = random.normal(size=(n, rank)) @ random.normal(size=(rank, n))
    a *= 10.0 ** random.integers(-3, 4, size=(n, 1))  # rows in different units
    right = a @ random.normal(size=n)
    kept = random.normal(size=n).tolist()
    x = solve_open(a.tolist(), right.tolist(), kept)
    assert x is not None
    assert a @ np.array(x) == pytest.approx(right, rel=1e-6, abs=1e-9)
    assert sum(x[i] == kept[i] for i in range(n)) == n - rank


def test_rows_that_disagree_have_no_solution() -> None:
    assert solve_open([[1.0, 1.0], [2.0, 2.0]], [1.0, 2.1], [0.0, 0.0]) is None
    assert solve_open([[0.0]], [1.0], [0.0]) is None
    assert solve_open([[0.0]], [0.0], [3.0]) == [3.0]
