"""Many runs of one model: a sweep over parameters and start values.

In:   Model, points (a grid, or a list of them), metric
Out:  Study    a tidy table: a row for each point, with its values and its metrics

Points go in small bundles to processes that each load the compiled model once; only
metrics come back, so that memory stays as it is. A point that fails, or that takes its
process with it, is told with its reason, and the others go on. With a `journal`, an
interrupted study is taken up where it was.
"""

from __future__ import annotations

import hashlib
import math
import pickle
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeAlias

from planarc.core.diagnostic import Diagnostic, PlanarcError, UsageError
from planarc.core.options import RunOptions
from planarc.design import Point, grid
from planarc.metric import Metric, Metrics, read_metric
from planarc.table import Failure, Study
from planarc.values import Value, parameter_values, start_values

if TYPE_CHECKING:
    from planarc.journal import Journal
    from planarc.model import Model

__all__ = ["Failure", "Study", "StudyInterrupted", "sweep"]

#: Called with the numbers of finished, of all, and of failed points.
Progress: TypeAlias = "Callable[[int, int, int], None]"

#: Points in one bundle, at most, and seconds after which it is handed back unfinished.
BUNDLE, PATIENCE = 32, 1.0
#: Bytes for a process of a study: a notebook may hold much that a fork takes over.
NO_BOUND = 1 << 62
_START = ".start"


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C; `study` holds the points that were finished."""

    def __init__(self, study: Study) -> None:
        super().__init__("the study was interrupted")
        self.study = study


@dataclass(frozen=True, slots=True)
class Outcome:
    """Of one point: its metrics, or why it has none."""

    index: int
    values: dict[str, float] | None
    failed: str | None = None
    lost: bool = False  # its process died or took too long: worth another try


@dataclass(frozen=True, slots=True)
class Task:
    """One point as numbers; `wrong` says why it cannot be run at all."""

    index: int
    values: dict[str, float]
    starts: dict[str, float]
    wrong: str | None = None


@dataclass(frozen=True, slots=True)
class Payload:
    """What all runs share."""

    model: Model
    options: RunOptions
    metrics: Metrics


def sweep(
    model: Model,
    points: Mapping[str, Sequence[Any]] | Iterable[Point],
    metric: Metric | None = None,
    *,
    stop_time: float | None = None,
    tolerance: float | None = None,
    intervals: int | None = None,
    parameters: Mapping[str, Value] | None = None,
    start: Mapping[str, Value] | None = None,
    workers: int | None = None,
    client: Any = None,
    journal: str | Path | None = None,
    limit: float = 60.0,
    progress: bool | Progress = False,
) -> Study:
    """Run the model at every point and keep the metrics.

    `points`: values by name, of which every combination is run, or a list of points, as
    `planarc.random` and `planarc.latin_hypercube` give. A name is that of a parameter, or
    of a start value (`crank.phi.start`). `metric`: see `planarc.metric`; by default the
    states at the end. `workers`: processes, by default one a core. `client`: a Dask client,
    whose workers do it instead. `limit`: seconds that one run may take.
    Raises UsageError for names that are not there and for structural parameters.
    """
    table = _points(points)
    options = RunOptions(
        stop=stop_time,
        tolerance=tolerance,
        intervals=intervals,
        backend=model.backend,
        values=parameter_values(model.program, parameters),
        starts=start_values(model.program, start),
    )
    payload = Payload(model, options, read_metric(metric, model.program))
    tasks = _tasks(model, table)
    book = _journal(journal, payload, table)
    done = dict(book.done) if book else {}
    watch = _watcher(progress, len(tasks))
    try:
        for outcomes in _outcomes(payload, tasks, done, workers, client, limit):
            done.update((o.index, o) for o in outcomes)
            if book:
                book.add(o for o in outcomes if not o.lost)
            watch(len(done), len(tasks), sum(o.values is None for o in done.values()))
    except KeyboardInterrupt:
        raise StudyInterrupted(_study(table, done, payload)) from None
    finally:
        if book:
            book.close()
    return _study(table, done, payload)


def _points(points: Any) -> list[dict[str, Any]]:
    if isinstance(points, Mapping):
        return grid(points)
    if hasattr(points, "to_dict"):  # a DataFrame
        points = points.to_dict("records")
    try:
        table = [dict(p) for p in points]
    except (TypeError, ValueError):
        raise UsageError(
            Diagnostic(
                "C230",
                f"the points of a study are values by name, not {type(points).__name__}",
                hint='write them as {"rod.L": [0.5, 0.6]}',
            )
        ) from None
    if not table:
        raise UsageError(Diagnostic("C230", "the study has no points"))
    return table


def _tasks(model: Model, table: Sequence[Mapping[str, Any]]) -> list[Task]:
    """Points as numbers. Names are checked for all, before anything runs."""
    program = model.program
    parameters = {p.name: p for p in program.parameter_slots}
    plain = {n for n, p in parameters.items() if p.settable and not p.structural}
    checked: set[tuple[str, ...]] = set()
    tasks = []
    for i, point in enumerate(table):
        values: dict[str, Any] = {}
        starts: dict[str, Any] = {}
        for name, value in point.items():
            is_start = isinstance(name, str) and name.endswith(_START) and name not in parameters
            (starts if is_start else values)[name] = value
        fast = not starts and all(type(v) is float and v - v == 0.0 for v in values.values())
        if not (fast and plain.issuperset(values)):
            try:
                values = parameter_values(program, values)
                starts = start_values(program, starts)
            except UsageError as problem:
                if problem.diagnostics[0].code == "C201":
                    raise
                tasks.append(Task(i, {}, {}, str(problem)))
                continue
        names = (*values, *starts)
        if names not in checked:
            _check(model, values, starts)
            checked.add(names)
        tasks.append(Task(i, values, starts))
    return tasks


def _check(model: Model, values: Mapping[str, float], starts: Mapping[str, float]) -> None:
    from planarc.solve.request import resolve

    resolve(model.program, RunOptions(values=values, starts=starts))


def _study(
    table: Sequence[Mapping[str, Any]], done: Mapping[int, Outcome], payload: Payload
) -> Study:
    names: dict[str, None] = dict.fromkeys(n for p in table for n in p)
    metrics: dict[str, None] = {}
    for i in sorted(done):
        metrics |= dict.fromkeys(done[i].values or ())
    if not metrics:
        metrics = dict.fromkeys(payload.metrics.names)
    failures = []
    rows = []
    for i, point in enumerate(table):
        outcome = done.get(i)
        values = outcome.values if outcome else None
        rows.append((point, values))
        if values is None:
            reason = (outcome.failed if outcome else None) or "it was not run"
            failures.append(Failure(i, dict(point), reason))
    return Study(payload.model.name, tuple(names), tuple(metrics), tuple(rows), tuple(failures))


def _journal(
    path: str | Path | None, payload: Payload, table: Sequence[Mapping[str, Any]]
) -> Journal | None:
    if path is None:
        return None
    from planarc.journal import Journal

    program = payload.model.program
    defaults = [(p.name, p.default) for p in program.parameter_slots]
    options = replace(payload.options, values={}, starts={})
    given = sorted(payload.options.values.items()), sorted(payload.options.starts.items())
    digest = hashlib.sha256()
    for part in (program.name, defaults, options, given, table, payload.metrics.names):
        digest.update(repr(part).encode())
    code = payload.model.compiled().code
    digest.update(code.encode() if isinstance(code, str) else code)
    return Journal(Path(path), digest.hexdigest())


def _watcher(progress: bool | Progress, count: int) -> Progress:
    if callable(progress):
        return progress
    if not progress:
        return lambda done, total, failed: None
    from planarc.bar import Bar

    return Bar()


# Who does the work --------------------------------------------------------------------------


def _outcomes(
    payload: Payload,
    tasks: Sequence[Task],
    done: Mapping[int, Outcome],
    workers: int | None,
    client: Any,
    limit: float,
) -> Iterator[list[Outcome]]:
    from planarc.crew import cores

    wrong = [Outcome(t.index, None, t.wrong) for t in tasks if t.wrong]
    if wrong:
        yield wrong
    left = [t for t in tasks if t.wrong is None and t.index not in done]
    count = cores() if workers is None else workers
    if not isinstance(count, int) or count < 1:
        raise UsageError(
            Diagnostic("C232", f"the number of workers is an integer above 0, not {count}")
        )
    if client is not None:
        from planarc.cluster import on_cluster

        yield from on_cluster(client, payload, _bundles(left, 4 * len(client.ncores() or [0])))
    elif min(count, len(left)) <= 1:
        for bundle in _bundles(left, 1):
            yield run_bundle(payload, bundle)
    else:
        yield from _in_processes(payload, left, count, limit)


def _bundles(tasks: Sequence[Task], workers: int) -> list[tuple[Task, ...]]:
    size = max(1, min(BUNDLE, len(tasks) // max(1, 8 * workers)))
    return [tuple(tasks[i : i + size]) for i in range(0, len(tasks), size)]


def run_bundle(
    payload: Payload, bundle: Sequence[Task], patience: float = math.inf
) -> list[Outcome]:
    """The outcomes of the first points, as many as fit into some seconds (at least one)."""
    end = monotonic() + patience
    outcomes: list[Outcome] = []
    for task in bundle:
        outcomes.append(_run(payload, task))
        if monotonic() > end:
            break
    return outcomes


def _run(payload: Payload, task: Task) -> Outcome:
    options = payload.options
    options = replace(
        options, values={**options.values, **task.values}, starts={**options.starts, **task.starts}
    )
    try:
        result = payload.model.run(options)
    except PlanarcError as problem:
        return Outcome(task.index, None, problem.diagnostics[0].message)
    try:
        return Outcome(task.index, payload.metrics(result))
    except (Exception, SystemExit) as problem:
        reason = f"the metric fails: {type(problem).__name__}: {problem}"
        return Outcome(task.index, None, reason)


def _in_processes(
    payload: Payload, tasks: Sequence[Task], workers: int, limit: float
) -> Iterator[list[Outcome]]:
    from planarc.crew import Crew, Lost

    with tempfile.TemporaryDirectory(prefix="planarc-") as folder:
        place = _hand_over(payload, Path(folder))
        crew: Crew[_Job, list[Outcome]] = Crew(_work, workers, limit, NO_BOUND)
        crew.add(_Job(place, bundle) for bundle in _bundles(tasks, workers))
        try:
            for job, result in crew:
                if not isinstance(result, Lost):
                    if rest := job.bundle[len(result) :]:
                        crew.add([_Job(place, rest)])
                    yield result
                elif len(job.bundle) == 1:
                    why = "died" if result is Lost.DIED else f"took longer than {limit:g} s"
                    reason = f"the process that ran it {why}"
                    yield [Outcome(job.bundle[0].index, None, reason, lost=True)]
                else:  # which point was it?
                    crew.add(_Job(place, (task,)) for task in job.bundle)
        finally:
            _SHARED.pop(place, None)


@dataclass(frozen=True, slots=True)
class _Job:
    place: str  # of the payload
    bundle: tuple[Task, ...]


#: Payloads that forked processes find here; others read them from their file.
_SHARED: dict[str, Payload] = {}


def _hand_over(payload: Payload, folder: Path) -> str:
    place = str(folder / "payload")
    if sys.platform.startswith("linux"):
        _SHARED[place] = payload
        payload.model.compiled().load()  # before the fork: the code is in memory once
        return place
    try:
        Path(place).write_bytes(pickle.dumps(payload))
    except (pickle.PicklingError, AttributeError, TypeError) as problem:
        raise UsageError(
            Diagnostic(
                "C236",
                f"the metric cannot be sent to other processes: {problem}",
                hint="make it a function of a module, or use workers=1",
            )
        ) from None
    return place


def _work(job: _Job) -> list[Outcome]:
    """In a process of the crew."""
    payload = _SHARED.get(job.place) or _read(job.place)
    return run_bundle(payload, job.bundle, PATIENCE)


@lru_cache(maxsize=2)
def _read(place: str) -> Payload:
    payload: Payload = pickle.loads(Path(place).read_bytes())
    return payload
