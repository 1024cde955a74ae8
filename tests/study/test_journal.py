"""The journal of a study: damaged lines do not count, and another metric is another study."""

from __future__ import annotations

import functools
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import CancelledError
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import planarc
from planarc import Model, Result, UsageError
from planarc.study import workers
from planarc.study.identity import identity

POINTS = {"k": [1.0, 2.0]}


def first(result: Result) -> float:
    return float(result["x"][0])


def last(result: Result) -> float:
    return float(result["x"][-1])


def scaled(factor: float) -> Any:
    return lambda result: factor * last(result)


class Scale:
    def __init__(self, factor: float) -> None:
        self.factor = factor

    def __call__(self, result: Result) -> float:
        return self.factor * last(result)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"a": first}, {"a": last}),
        ({"a": "max(x)"}, {"a": "min(x)"}),
        (scaled(1.0), scaled(2.0)),
        ({"a": Scale(1.0)}, {"a": Scale(2.0)}),
        ({"a": functools.partial(last)}, {"a": functools.partial(first)}),
        ({"a": lambda r: last(r)}, {"a": lambda r: first(r)}),
    ],
)
def test_another_metric_of_the_same_name_is_another_study(
    one: Any, other: Any, decay: Model, tmp_path: Path
) -> None:
    journal = tmp_path / "study.jsonl"
    study = planarc.sweep(decay, POINTS, one, journal=journal, workers=1)
    again = planarc.sweep(decay, POINTS, one, journal=journal, workers=1)
    assert list(again) == list(study)
    with pytest.raises(UsageError, match="C235"):
        planarc.sweep(decay, POINTS, other, journal=journal, workers=1)


def test_a_metric_is_known_in_another_process() -> None:
    program = (
        "from planarc.study.identity import identity\n"
        "def f(r, names={'a', 'b', 'c'}): return r in {'x', 'y', 'z'}\n"
        "print(identity(f))"
    )
    told = {
        subprocess.run(
            [sys.executable, "-c", program], capture_output=True, text=True, check=True
        ).stdout
        for _ in range(3)
    }
    assert len(told) == 1
    assert told.pop().strip()


def test_a_function_that_calls_itself_has_an_identity() -> None:
    def again(n: int) -> int:
        return n and again(n - 1)

    assert identity(again) == identity(again)


@pytest.mark.parametrize(
    "line",
    [
        b"\xff\xfe\x00",
        b'{"point": 0, "values": [1, 2]}',
        b'{"point": 1, "values": {"x": "0.5"}}',
        b'{"point": true, "failed": "never"}',
        b'{"point": 1, "failed": {}}',
        b'{"point": 99, "values": {"other": 1.0}}',
        b'{"point": -1, "values": {"other": 1.0}}',
        b"[" * 100_000,
    ],
)
def test_a_damaged_line_does_not_count(line: bytes, decay: Model, tmp_path: Path) -> None:
    journal = tmp_path / "study.jsonl"
    study = planarc.sweep(decay, POINTS, "x", journal=journal, workers=1)
    with journal.open("ab") as file:
        file.write(line + b"\n")
    again = planarc.sweep(decay, POINTS, "x", journal=journal, workers=1)
    assert (list(again), again.metrics) == (list(study), ("x",))


@pytest.mark.parametrize("content", [b"\xff\xfe\x00bad", b'{"planarc study": "x"}\n\xff\n'])
def test_what_is_no_journal_belongs_to_others(content: bytes, decay: Model, tmp_path: Path) -> None:
    journal = tmp_path / "study.jsonl"
    journal.write_bytes(content)
    with pytest.raises(UsageError, match="C235"):
        planarc.sweep(decay, POINTS, "x", journal=journal)
    assert journal.read_bytes() == content


class Gone:
    """A client of Dask that is lost after the first result."""

    def ncores(self) -> dict[str, int]:
        return {"worker": 1}

    def scatter(self, payload: Any, **_: Any) -> Any:
        return payload

    def submit(self, function: Any, *arguments: Any, **_: Any) -> Any:
        return Finished(function, arguments)


class Finished:
    status = "finished"

    def __init__(self, function: Any, arguments: tuple[Any, ...]) -> None:
        self.result = lambda: function(*arguments)


@pytest.mark.parametrize("problem", [OSError("closed"), CancelledError()])
def test_points_that_a_lost_client_had_finished_are_kept(
    problem: BaseException, decay: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def first_only(futures: list[Any]) -> Iterator[Any]:
        yield futures[0]
        raise problem

    distributed = SimpleNamespace(as_completed=first_only)
    monkeypatch.setattr(workers, "import_module", lambda _: distributed)
    journal = tmp_path / "study.jsonl"
    points = {"k": [1.0, 2.0, 3.0]}
    study = planarc.sweep(decay, points, "x", client=Gone(), journal=journal)
    assert [f.index for f in study.failures] == [1, 2]
    assert "the cluster failed" in study.failures[0].reason
    again = planarc.sweep(decay, points, "x", workers=1, journal=journal)
    assert again.failures == ()
