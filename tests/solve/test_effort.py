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


def taken(text: str, native: bool) -> list[int]:
    """The steps of marches up to the end of a stretch, and of the one after a restart."""
    own = effort.Effort(planarc.load(text).program, native, 0.0, 1e9)
    found, way = [], None
    while way is None:
        found.append(own.steps)
        way = own.take(0.0, own.steps)
    own.restart()
    return [*found, own.steps]


def test_the_steps_of_marches() -> None:
    """They are as many as a tenth of a second takes, never pass the end of a stretch, and are few
    at the start where relations may switch at once."""
    assert taken(TURNING, native=True) == [effort.STRETCH] * 2
    many, rest = divmod(effort.STRETCH, effort.most_steps(planarc.load(TURNING).program, False))
    assert taken(TURNING, native=False)[many:-1] == [rest] * (rest > 0)
    switching = TURNING.replace("= y;", "= if y > 0 then y else 2*y;")
    most = effort.MOST_WITH_RELATIONS
    first, *others, last, again = taken(switching, native=True)
    assert (first, set(others), again) == (effort.FIRST, {most}, effort.FIRST)
    assert last == (effort.STRETCH - first) % most
