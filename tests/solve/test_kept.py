"""Runs of one model that go on with what the one before has left: to the last bit as if alone."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model, Result, RunStopped
from planarc.core.options import Solver
from planarc.solve.kept import MOST, Kept
from planarc.solve.solvers.integrator import Counts, Settings

ROOT = Path(__file__).parents[2]
BOUNCE = """
model Bounce
  Real h(start=1, fixed=true); Real v(start=0, fixed=true); Real p(start=1, fixed=true);
  parameter Real top = 100; parameter Real g = 9.81;
equation
  der(h) = v; der(v) = -g; der(p) = -p^3;
  assert(h < top, "too high");
  when h < 0 then reinit(v, -0.8*pre(v)); end when;
end Bounce;
"""
SIGNAL = """
model Signal
  Real x(start=1, fixed=true); Real y;
equation
  y = delay(x, 0.1); der(x) = -y;
end Signal;
"""


def _told(result: Result) -> tuple[Any, ...]:
    rows = result.rows
    data = rows.time.tobytes(), np.ascontiguousarray(rows.data).tobytes(), rows.constants
    return *data, rows.statistics, rows.states, rows.held, rows.events, rows.warnings


def _at_rest(model: Model) -> list[Kept]:
    return model.shelf(model.compiled())._idle


@pytest.fixture
def bounce() -> Iterator[Model]:
    yield planarc.load(BOUNCE)


RUNS: tuple[dict[str, Any], ...] = (
    {},
    {"tolerance": 1e-9, "intervals": 20},
    {"stop_time": 0.3},
    {"stop_time": 1e3, "intervals": 10},
    {"stop_time": 1e-4},
    {"stop_time": 0.0},
    {"solver": "cvode-adams"},
    {"solver": "rk4", "fixed_step": 0.01},
    {"solver": "lsoda"},
    {"backend": "numpy"},
    {},
)


@pytest.mark.parametrize("what", ["four_bar.pmo", BOUNCE, SIGNAL], ids=["loop", "events", "delay"])
def test_a_run_after_others_is_as_if_alone(what: str) -> None:
    def load() -> Model:
        return planarc.load(what if what.startswith("\n") else ROOT / "examples" / what)

    model = load()
    for more in RUNS:
        if what == BOUNCE and more.get("stop_time", 0.0) > 100.0:
            continue  # bounces without end
        options = {"stop_time": 1.5} | more
        assert _told(model.simulate(**options)) == _told(load().simulate(**options)), more


def test_a_run_leaves_its_kernel_and_its_integrator(bounce: Model) -> None:
    bounce.simulate(1.0)
    (kept,) = _at_rest(bounce)
    kernel, integrator = kept.kernel, kept.integrator
    assert integrator is not None
    bounce.simulate(0.5)
    assert _at_rest(bounce)[0].kernel is kernel
    assert _at_rest(bounce)[0].integrator is integrator


def test_it_holds_no_rows(bounce: Model) -> None:
    result = bounce.simulate(1.0)
    data = result.rows.data
    held = [gc.get_referrers(a) for a in (data, data.base) if a is not None]
    kinds = {type(o).__name__ for owners in held for o in owners}
    assert not kinds & {"Recorder", "Driver"}


def test_a_run_that_fails_leaves_nothing(bounce: Model) -> None:
    alone = _told(bounce.simulate(1.0))
    with pytest.raises(RunStopped):
        bounce.simulate(1.0, parameters={"top": 0.5})
    assert not _at_rest(bounce)
    assert _told(bounce.simulate(1.0)) == alone
    with pytest.raises(planarc.UsageError):
        bounce.simulate(1.0, tolerance=-1.0)
    assert not _at_rest(bounce)
    assert _told(bounce.simulate(1.0)) == alone


@pytest.mark.parametrize("problem", [KeyboardInterrupt, ZeroDivisionError])
def test_a_run_that_is_broken_off_leaves_nothing(
    bounce: Model, problem: type[BaseException]
) -> None:
    alone = _told(bounce.simulate(1.0))

    def stop(t: float) -> None:
        if t > 0.5:
            raise problem

    with pytest.raises(RunStopped if problem is KeyboardInterrupt else problem):
        bounce.simulate(1.0, progress=stop)
    assert not _at_rest(bounce)
    assert _told(bounce.simulate(1.0)) == alone


def test_a_failure_tells_nothing_of_the_run_before(bounce: Model) -> None:
    """The errors of the last step, which a message names, are those of this run."""
    bounce.simulate(1.0)
    kept = bounce.shelf(bounce.compiled()).take(bounce.compiled().load)
    integrator = kept.integrator
    assert integrator is not None and integrator.last_step() > 0.0
    assert integrator.renew(Solver.AUTO, Settings(1e-6, 1.0, 1))
    assert integrator.last_step() == 0.0
    assert not integrator.errors()
    assert integrator.counts() == Counts()
    assert list(kept.kernel.w) == list(bounce.compiled().load().w)


def test_a_run_within_a_run_has_a_kernel_of_its_own(bounce: Model) -> None:
    alone, found = _told(bounce.simulate(1.0)), []

    def again(t: float) -> None:
        found.append(bounce.simulate(1.0))

    assert _told(bounce.simulate(1.0, progress=again)) == alone
    assert len(found) > 1
    assert all(_told(result) == alone for result in found)


def test_many_threads_do_not_meet(bounce: Model) -> None:
    speeds = [0.1 * i for i in range(50)]

    def run(speed: float) -> tuple[Any, ...]:
        return _told(bounce.simulate(1.0, start={"v": speed}))

    with ThreadPoolExecutor(50) as pool:
        together = [*pool.map(run, speeds), *pool.map(run, speeds)]
    assert len(_at_rest(bounce)) <= MOST
    assert together == [*map(run, speeds)] * 2


def test_what_was_kept_goes_with_the_model() -> None:
    model = planarc.load(BOUNCE)
    model.simulate(1.0)
    integrator: Any = _at_rest(model)[0].integrator
    session = integrator._session
    assert session.present
    del model
    gc.collect()
    assert not session.present
