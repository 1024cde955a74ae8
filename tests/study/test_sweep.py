"""Studies: many runs of one model, on all cores, that nothing stops."""

from __future__ import annotations

import json
import math
import os
import resource
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import planarc
from planarc import Model, Result, UsageError
from planarc.core.options import RunOptions, Solver
from planarc.study.bundle import Outcome
from planarc.study.sweep import StudyInterrupted

KS = [0.5, 1.0, 1.5, 2.0]


@pytest.mark.parametrize("workers", [1, 2])
def test_a_grid_gives_a_row_for_each_combination(decay: Model, workers: int) -> None:
    points = {"k": KS, "x.start": [1.0, 2.0]}
    study = planarc.sweep(decay, points, "x", workers=workers)
    assert study.columns == ("k", "x.start", "x")
    assert list(study["k"]) == [k for k in KS for _ in range(2)]
    exact = study["x.start"] * np.exp(-study["k"])
    assert np.max(np.abs(study["x"] - exact)) < 1e-6
    assert study.failures == ()


def test_values_beyond_their_bounds_are_told_once(tmp_path: Path) -> None:
    file = tmp_path / "m.mo"
    file.write_text("model M parameter Real d(min=0, max=2) = 1; Real x = d*time; end M;")
    model = planarc.load(file)
    told = planarc.sweep(model, {"d": [1.0, -0.5, -3.0, -1.0, 5.0]}, "x", workers=1).warnings
    assert [(d.code, d.message) for d in told] == [
        ("R409", "`d` = -3 lies below its minimum 0"),
        ("R409", "`d` = 5 lies above its maximum 2"),
    ]
    assert not planarc.sweep(model, {"d": [0.0, 2.0]}, "x", workers=1).warnings


WARNING = """model Warns
  parameter Real d = 1;
  Real x = d*time;
equation
  assert(x < 2, "x[1] grew to " + String(d), AssertionLevel.warning);
  assert(x > -2, "it fell", AssertionLevel.warning);
end Warns;"""


@pytest.mark.parametrize("workers", [1, 2])
def test_what_runs_warn_of_is_told_once_with_their_number(workers: int) -> None:
    model = planarc.load(WARNING)
    study = planarc.sweep(model, {"d": [1.0, 3.0, 5.0, -4.0]}, "x", workers=workers)
    grew, fell = (d.message for d in study.warnings)
    assert "grew to 3" in grew
    assert grew.endswith(" (in 2 runs, first at point 2)")
    assert fell.endswith(" (in 1 run, point 4)")
    assert not planarc.sweep(model, {"d": [1.0]}, "x", workers=workers).warnings


def test_metrics_are_texts_functions_and_mappings(decay: Model) -> None:
    def both(result: Result) -> dict[str, float]:
        return {"first": result["x"][0], "last": result["x"][-1]}

    metric = {"mean": "mean(x)", "top": "max(x)", "f": lambda r: len(r), "g": both}
    study = planarc.sweep(decay, {"k": [2.0]}, metric, intervals=2000)
    (row,) = study
    assert row["mean"] == pytest.approx((1 - math.exp(-2)) / 2, abs=1e-6)
    assert (row["top"], row["f"], row["first"]) == (1.0, 2001, 1.0)
    assert row["last"] == pytest.approx(math.exp(-2), abs=1e-6)
    assert planarc.sweep(decay, {"k": KS}).metrics == ("x",)
    rms = planarc.sweep(decay, {"k": [1.0]}, ["rms(x)", "range(x)", "min(x)", "maxabs(x)"])
    assert rms["rms(x)"][0] == pytest.approx(math.sqrt((1 - math.exp(-2)) / 2), abs=1e-5)


@pytest.mark.parametrize("intervals", [3, 10, 100])
def test_means_of_states_are_those_of_the_motion(decay: Model, intervals: int) -> None:
    study = planarc.sweep(decay, {"k": [1.0]}, ["mean(x)", "rms(x)"], intervals=intervals)
    error = 1e-6 + 0.02 * intervals**-4.0  # as of cubics; trapezia err by 1e-2 at 3
    assert study["mean(x)"][0] == pytest.approx(1 - math.exp(-1), abs=error)
    assert study["rms(x)"][0] == pytest.approx(math.sqrt((1 - math.exp(-2)) / 2), abs=error)


def test_a_metric_that_is_varied_is_one_column(decay: Model, tmp_path: Path) -> None:
    study = planarc.sweep(decay, {"k": KS}, ["k", "x"], workers=1)
    assert study.columns == ("k", "x")
    head, *rows = study.to_csv(tmp_path / "k.csv").read_text().splitlines()
    assert head == "k,x"
    assert [float(row.split(",")[0]) for row in rows] == KS
    assert planarc.sweep(decay, {"k": KS}, "k", workers=1).columns == ("k",)


def test_another_metric_may_not_bear_the_name_of_what_is_varied(decay: Model) -> None:
    with pytest.raises(UsageError, match="`k` is varied"):
        planarc.sweep(decay, {"k": KS}, {"k": "max(x)"})
    study = planarc.sweep(decay, {"k": KS}, lambda r: {"k": r["x"][-1]}, workers=1)
    assert all("`k` is varied" in f.reason for f in study.failures)
    assert len(study.failures) == len(KS)


@pytest.mark.parametrize("workers", [1, 2])
def test_failed_points_say_why_and_the_others_go_on(decay: Model, workers: int) -> None:
    def metric(result: Result) -> Any:
        if result.parameters["k"] == 1.0:
            raise ValueError("no good")
        return "text" if result.parameters["k"] == 1.5 else result["x"][-1]

    ks = [0.5, 1.0, 1.5, 60.0, float("nan"), 2.0]
    study = planarc.sweep(decay, {"k": ks}, metric, workers=workers)
    reasons = {f.index: f.reason for f in study.failures}
    assert sorted(reasons) == [1, 2, 3, 4]
    assert "ValueError: no good" in reasons[1]
    assert "metric" in reasons[2]
    assert "k is too large" in reasons[3]
    assert "finite" in reasons[4]
    assert list(np.isfinite(study["metric"])) == [True, False, False, False, False, True]


def test_a_worker_that_dies_takes_one_point_with_it(decay: Model) -> None:
    def metric(result: Result) -> float:
        if result.parameters["k"] == KS[2]:
            os._exit(1)
        return float(result["x"][-1])

    study = planarc.sweep(decay, {"k": KS * 20}, metric, workers=2)
    assert [f.index % 4 for f in study.failures] == [2] * 20
    assert all("died" in f.reason for f in study.failures)
    assert np.sum(np.isfinite(study["metric"])) == 60


def test_a_point_that_takes_too_long_is_given_up(decay: Model, hang: Callable[[], None]) -> None:
    def metric(result: Result) -> float:
        if result.parameters["k"] == KS[1]:
            hang()
        return 1.0

    study = planarc.sweep(decay, {"k": KS}, metric, workers=2, limit=1.0)
    assert [f.index for f in study.failures] == [1]
    assert "longer than 1 s" in study.failures[0].reason


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("solver", ["auto", "exported"])
def test_ctrl_c_in_a_run_of_this_process_ends_the_study(
    decay: Model, monkeypatch: pytest.MonkeyPatch, solver: str
) -> None:
    begun, simulate, sent = [], Model.run, []

    def ctrl_c(t: float) -> None:
        if t > 0.5 and not sent:
            sent.append(t)
            os.kill(os.getpid(), signal.SIGINT)

    def run(self: Model, options: RunOptions) -> Result:
        begun.append(options)
        own = replace(options, solver=Solver(solver))
        return simulate(self, own, progress=ctrl_c if len(begun) == 20 else None)

    monkeypatch.setattr(Model, "run", run)
    points = {"k": [0.001 * i for i in range(1, 301)]}
    with pytest.raises(StudyInterrupted) as caught:
        planarc.sweep(decay, points, "x", workers=1)
    study = caught.value.study
    assert len(begun) == 20
    assert [row["x"] == row["x"] for row in study] == [True] * 19 + [False] * 281
    assert {f.reason for f in study.failures} == {"it was not run"}


def test_an_interrupted_study_is_taken_up_again(decay: Model, tmp_path: Path) -> None:
    journal, counted = tmp_path / "study.jsonl", []

    def interrupt(done: int, total: int, failed: int) -> None:
        if done >= 5:
            raise KeyboardInterrupt

    def metric(result: Result) -> float:
        counted.append(result)
        return float(result["x"][-1])

    points = {"k": [0.1 * i for i in range(1, 21)]}

    def study(progress: Any = False) -> planarc.Study:
        return planarc.sweep(decay, points, metric, workers=1, journal=journal, progress=progress)

    with pytest.raises(StudyInterrupted) as caught:
        study(interrupt)
    finished = len(counted)
    assert 5 <= finished < 20
    assert len(caught.value.study.failures) == 20 - finished
    whole = journal.read_text("utf-8")
    journal.write_text(whole + '{"point": 19, "val', "utf-8")  # a line that was cut off
    found = study()
    assert len(counted) == 20
    assert np.allclose(found["metric"], np.exp(-found["k"]), atol=1e-6)
    again = study()
    assert len(counted) == 20
    assert list(again) == list(found)
    lines = [json.loads(line) for line in whole.splitlines()]
    assert len(lines) == finished + 1


def test_a_journal_of_another_study_is_refused(decay: Model, tmp_path: Path) -> None:
    journal = tmp_path / "study.jsonl"
    planarc.sweep(decay, {"k": [1.0]}, "x", journal=journal)
    for points, metric in (({"k": [2.0]}, "x"), ({"k": [1.0]}, "max(x)")):
        with pytest.raises(UsageError, match="another study"):
            planarc.sweep(decay, points, metric, journal=journal)
    with pytest.raises(UsageError, match="cannot write"):
        planarc.sweep(decay, {"k": [1.0]}, "x", journal=tmp_path)


WRONG: list[tuple[str, Callable[[Model], Any], str]] = [
    ("name", lambda m: planarc.sweep(m, {"kk": [1.0]}), "no parameter `kk`"),
    ("structural", lambda m: planarc.sweep(m, {"linear": [True, False]}), "is structural"),
    ("metric", lambda m: planarc.sweep(m, {"k": [1.0]}, "max(z)"), "no variable `z`"),
    ("reduction", lambda m: planarc.sweep(m, {"k": [1.0]}, "maximum(x)"), "did you mean `max"),
    ("no metric", lambda m: planarc.sweep(m, {"k": [1.0]}, 3), "not int"),  # type: ignore[arg-type]
    ("no points", lambda m: planarc.sweep(m, []), "no points"),
    ("no list", lambda m: planarc.sweep(m, {"k": 3}), "sequence"),  # type: ignore[dict-item]
    ("nothing", lambda m: planarc.sweep(m, 3), "not int"),  # type: ignore[arg-type]
    ("workers", lambda m: planarc.sweep(m, {"k": KS}, workers=0), "above 0"),
    ("model", lambda m: planarc.sweep("m.pmo", {"k": [1.0]}), "not str"),  # type: ignore[arg-type]
    ("client", lambda m: planarc.sweep(m, {"k": [1.0]}, client="tcp://a"), "not str"),
    ("limit", lambda m: planarc.sweep(m, {"k": [1.0]}, limit="1 h"), "takes a number"),  # type: ignore[arg-type]
    ("no limit", lambda m: planarc.sweep(m, {"k": [1.0]}, limit=0), "above 0"),
    ("stop", lambda m: planarc.sweep(m, {"k": [1.0]}, stop_time="1"), "takes a number"),  # type: ignore[arg-type]
    ("tolerance", lambda m: planarc.sweep(m, {"k": [1.0]}, tolerance=2.0), "between"),
    ("range", lambda m: planarc.random({"k": (2, 1)}, 3), "low and high"),
    ("units", lambda m: planarc.random({"k": ("1cm", "2m")}, 3), "several units"),
    ("half a unit", lambda m: planarc.random({"k": (1, "2m")}, 3), "several units"),
    ("no text", lambda m: planarc.random({"k": ("a", "b")}, 3), "two finite numbers"),
    ("count", lambda m: planarc.latin_hypercube({"k": (1, 2)}, 0), "above 0"),
]


@pytest.mark.parametrize("wrong", [w[1:] for w in WRONG], ids=[w[0] for w in WRONG])
def test_a_wrong_study_says_what_is_wrong(decay: Model, wrong: Any) -> None:
    request, words = wrong
    with pytest.raises(UsageError) as caught:
        request(decay)
    assert words in " ".join(f"{d.message} {d.hint}" for d in caught.value.diagnostics)


def test_samples_are_repeated_by_their_seed_and_fill_the_ranges() -> None:
    ranges = {"a": (0.0, 1.0), "b": (-2.0, 2.0)}
    for sample in (planarc.random, planarc.latin_hypercube):
        points = sample(ranges, 50, seed=3)
        assert points == sample(ranges, 50, seed=3) != sample(ranges, 50, seed=4)
        assert all(-2 <= p["b"] <= 2 and 0 <= p["a"] <= 1 for p in points)
    slices = sorted(int(50 * p["a"]) for p in planarc.latin_hypercube(ranges, 50))
    assert slices == list(range(50))


@pytest.mark.parametrize("sample", [planarc.random, planarc.latin_hypercube])
def test_ranges_with_units_are_those_of_the_command_line(sample: Any) -> None:
    model = planarc.load(
        'model M parameter Real L(unit="m") = 1; parameter Real w(unit="1/s") = 1;'
        " Real x(start=L*w, fixed=true); equation der(x) = 0; end M;"
    )
    told = sample({"L": ("5cm", "9cm"), "w": ("2 1/min", "3 1/min")}, 4, seed=1)
    plain = sample({"L": (0.05, 0.09), "w": (2 / 60, 3 / 60)}, 4, seed=1)
    studies = [planarc.sweep(model, points, "x", workers=1) for points in (told, plain)]
    assert np.allclose(studies[0]["x"], studies[1]["x"], rtol=1e-14)
    assert np.allclose(studies[0]["L"], [p["L"] for p in plain], rtol=1e-14)


def test_the_table_goes_to_files_and_to_pandas(decay: Model, tmp_path: Path) -> None:
    study = planarc.sweep(decay, {"k": KS, "c": [[1.0, 3.0]]}, "x")
    pandas = pytest.importorskip("pandas")
    assert np.array_equal(study.to_pandas()["x"], study["x"])
    read = pandas.read_csv(study.to_csv(tmp_path / "a.csv"))
    assert np.array_equal(read["x"], study["x"])
    assert study._repr_html_().count("<tr>") == 5
    with pytest.raises(UsageError, match="no column"):
        study["z"]


def test_memory_does_not_grow_with_the_number_of_points(decay: Model) -> None:
    planarc.sweep(decay, {"k": KS * 25}, "x", workers=1)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    planarc.sweep(decay, {"k": KS * 150}, "x", workers=1)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000  # kB


def test_a_cluster_gives_the_same_table(decay: Model) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        found = planarc.sweep(decay, {"k": KS}, {"x": lambda r: r["x"][-1]}, client=client)
    here = planarc.sweep(decay, {"k": KS}, "x", workers=1)
    assert list(found) == list(here)


def test_an_outcome_can_be_pickled() -> None:
    import pickle

    outcome = Outcome(1, {"x": 1.0})
    assert pickle.loads(pickle.dumps(outcome)) == outcome


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
