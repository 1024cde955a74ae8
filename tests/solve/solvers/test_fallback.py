"""Without CVODE's library scipy takes over, with the same answers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request
from planarc.solve.solvers import cvode
from planarc.solve.solvers.sundials import Unavailable

EXAMPLES = Path(__file__).parents[3] / "examples"
BALL = """model Ball
  Real h(start=1, fixed=true), v(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then reinit(v, -0.8*pre(v)); end when;
end Ball;"""


def run(request: Request, backend: Backend) -> Any:
    options = RunOptions(stop=1.5, intervals=30, tolerance=1e-9, backend=backend)
    return compiler.run(compiler.compile_model(request, backend), options)


@pytest.fixture
def unopened(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise Unavailable("the library is of another version")

    monkeypatch.setattr(cvode, "Cvode", refuse)


@pytest.mark.parametrize("backend", list(Backend))
def test_the_fallback_agrees_and_is_named(
    backend: Backend, unopened: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    four_bar = run(Request(EXAMPLES / "four_bar.pmo"), backend)
    ball = run(Request(text=BALL), backend)
    assert four_bar.statistics.solver.startswith("lsoda (scipy)")
    assert "another version" in four_bar.statistics.reason
    monkeypatch.undo()
    direct = run(Request(EXAMPLES / "four_bar.pmo"), backend)
    assert np.max(np.abs(four_bar["revA.phi"] - direct["revA.phi"])) < 1e-5
    fall = np.sqrt(2 / 9.81)
    assert [e.time for e in ball.events] == pytest.approx([fall, fall * 2.6], abs=1e-6)
