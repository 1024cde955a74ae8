"""Effort is counted: a run ends alike however fast the machine is, and creeping is told."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import count

import numpy as np
import pytest

import planarc
from planarc.core.diagnostic import Diagnostic
from planarc.solve import effort

Stopped = Callable[..., tuple[Diagnostic, planarc.Result]]
BACKENDS = ["numpy", "native"]

TURNING = """model Turning
  Real x(start=1, fixed=true), y(start=0, fixed=true);
equation
  der(x) = y;
  der(y) = -x;
end Turning;
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_run_that_would_never_end(backend: str, stopped: Stopped) -> None:
    diagnostic, result = stopped(TURNING, backend, 1e9, interval=1e4, tolerance=1e-10)
    assert diagnostic.code == "R426"
    assert "10,000 steps bring the run forward by " in diagnostic.message
    assert " s of 1e+09 s: it would take " in diagnostic.message
    assert diagnostic.span is not None
    assert diagnostic.span.line in (4, 5)
    assert "a larger `--tolerance`" in str(diagnostic.hint)
    assert result.statistics.steps == effort.STRETCH


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_end_depends_on_no_clock(
    backend: str, stopped: Stopped, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slow clock, a clock that stands, and marches of other lengths: the same end."""
    options = {"interval": 1e4, "tolerance": 1e-10}
    first = stopped(TURNING, backend, 1e9, **options)[0].message
    slow = count(step=10.0)
    for clock in (lambda: next(slow), lambda: 0.0):
        monkeypatch.setattr(time, "perf_counter", clock)
        monkeypatch.setattr(time, "process_time", clock)
        assert stopped(TURNING, backend, 1e9, **options)[0].message == first
    for work in (100, 10_000_000):
        monkeypatch.setattr(effort, "WORK_NATIVE", work)
        monkeypatch.setattr(effort, "WORK_PYTHON", work)
        assert stopped(TURNING, backend, 1e9, **options)[0].message == first


@pytest.mark.parametrize("backend", BACKENDS)
def test_results_do_not_depend_on_the_length_of_marches(
    backend: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = planarc.load(TURNING)
    runs = []
    for work in (1, 1000, 10_000_000):
        monkeypatch.setattr(effort, "WORK_NATIVE", work)
        monkeypatch.setattr(effort, "WORK_PYTHON", work)
        runs.append(model.simulate(20.0, backend=backend))
    for other in runs[1:]:
        assert np.array_equal(runs[0]["x"], other["x"])
        assert runs[0].statistics.steps == other.statistics.steps


def test_the_steps_of_marches() -> None:
    """They grow, are few again after a restart, and never pass the end of a stretch."""
    program = planarc.load(TURNING).program
    own = effort.Effort(program, True, 0.0, 1e9)
    taken = []
    for _ in range(4):
        taken.append(own.steps)
        own.take(0.0, own.steps)
    assert taken == [2, 128, 8192, effort.STRETCH - 2 - 128 - 8192]
    assert own.steps == effort.STRETCH
    own.restart()
    assert own.steps == effort.FIRST
