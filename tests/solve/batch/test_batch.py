"""Many runs at once are the runs one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

import planarc
from planarc.api.model import Model
from planarc.codegen.numpy.printer import source
from planarc.core.options import Backend, RunOptions
from planarc.ir.result import Result
from planarc.solve.batch import may_batch, simulate_batch
from planarc.solve.settings import resolve


def run(
    model: Model, starts: Sequence[Mapping[str, float]], **options: float
) -> list[Result | None]:
    requests = [
        resolve(
            model.program,
            RunOptions(
                backend=Backend.NUMPY,
                starts={n: v for n, v in s.items() if n not in model.parameters},
                values={n: v for n, v in s.items() if n in model.parameters},
                **options,  # type: ignore[arg-type]
            ),
        )
        for s in starts
    ]
    kernels = [model.compiled().load() for _ in requests]
    return simulate_batch(model.program, source(model.program, arrays=True), kernels, requests)


def difference(batch: Result, alone: planarc.Result) -> float:
    """The greatest, of all variables, each relative to its size."""
    names = [c.name for c in batch.program.columns if not c.constant]
    return max(
        float(np.max(np.abs(batch[n] - alone[n])) / (1 + np.max(np.abs(alone[n])))) for n in names
    )


@pytest.mark.parametrize(
    ("file", "state", "values", "stop"),
    [
        ("examples/pendulum.pmo", "hinge.phi", (0.5, 1.0, 1.5, 3.0), 3.0),
        ("examples/four_bar.pmo", "revA.phi", (0.7, 1.0, 1.3, 1.6), 2.0),
        # The slider turns over, so the runs exchange their states, each at its own time.
        ("examples/crank_slider.pmo", "main.w", (-15.0, 0.0, 9.0, 20.0), 2.0),
    ],
)
def test_each_run_is_that_of_the_model_by_itself(
    file: str, state: str, values: Sequence[float], stop: float
) -> None:
    model = planarc.load(file, backend="numpy")
    results = run(model, [{state: v} for v in values], stop=stop, tolerance=1e-9)
    for value, result in zip(values, results, strict=True):
        alone = model.simulate(stop, start={state: value}, tolerance=1e-11)
        assert result is not None
        assert np.array_equal(result.time, alone.time)
        assert difference(result, alone) < 2e-6


def test_the_error_falls_with_the_tolerance() -> None:
    model = planarc.load("examples/four_bar.pmo", backend="numpy")
    exact = model.simulate(2.0, tolerance=1e-12)
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        (result,) = run(model, [{}], stop=2.0, tolerance=tolerance)
        assert result is not None
        errors.append(difference(result, exact))
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_a_run_does_not_depend_on_those_beside_it() -> None:
    model = planarc.load("examples/crank_slider.pmo", backend="numpy")
    starts = [{"main.w": w} for w in (0.0, 5.0, 9.0)]
    together = run(model, starts, stop=1.0)
    for start, result in zip(starts, together, strict=True):
        (alone,) = run(model, [start], stop=1.0)
        assert result is not None
        assert alone is not None
        size = np.max(np.abs(alone.data), axis=0)
        assert np.all(np.abs(result.data - alone.data) < 1e-9 * (1 + size))  # rounding alone


def test_what_cannot_be_done_falls_out_and_the_others_go_on() -> None:
    model = planarc.load(
        """model Spring
          parameter Real m(min=0) = 1;
          Real x(start=1, fixed=true);
          Real v(start=0, fixed=true);
        equation
          der(x) = v;
          m*der(v) = -x;
          assert(x > -1.5, "x went out of bounds");
        end Spring;""",
        backend="numpy",
    )
    results = run(model, [{"x": 1.0}, {"x": 2.0}, {"m": 0.0}, {"m": 1e-13}, {"m": 4.0}], stop=10.0)
    assert [r is None for r in results] == [False, True, True, True, False]
    good = results[4]
    assert good is not None
    assert np.allclose(good["x"], np.cos(good.time / 2), atol=1e-5)


@pytest.mark.parametrize(
    "text",
    [
        "model M Real x(start=1, fixed=true); equation der(x) = if x > 0.5 then -1 else -x; end M;",
        "model M Real x; discrete Real d(start=0, fixed=true); equation der(x) = d;"
        " when time > 1 then d = 1; end when; end M;",
        "model M Real x; equation x = time; end M;",
    ],
)
def test_models_with_events_are_not_for_batches(text: str) -> None:
    assert not may_batch(planarc.load(text, backend="numpy").program)


def test_a_study_gives_the_same_table_with_either_back_end() -> None:
    points = {"revA.phi.start": list(np.linspace(0.8, 1.2, 85)), "couplerBody.m": [2.5]}
    metric = ["max(revA.w)", "revA.phi", "rms(revD.w)"]
    tables = []
    for backend in ("native", "numpy"):
        model = planarc.load("examples/four_bar.pmo", backend=backend)
        study = planarc.sweep(model, points, metric, stop_time=1.0, tolerance=1e-9, workers=1)
        assert not study.failures
        tables.append(study)
    first, second = (
        np.array([[values[m] for m in metric] for _, values in t.rows if values]) for t in tables
    )
    assert first.shape == second.shape == (85, 3)
    assert np.allclose(first, second, rtol=1e-5, atol=1e-5)
