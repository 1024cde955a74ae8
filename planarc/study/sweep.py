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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

from msgspec.structs import replace

from planarc.api.model import Model
from planarc.api.values import Value, finite, parameter_values, plain_value, start_values
from planarc.core import progress as drawn
from planarc.core.diagnostic import Diagnostic, UsageError, usage_error
from planarc.core.options import RunOptions
from planarc.core.unknown import UnknownName, telling_keywords
from planarc.solve.doubts import doubts
from planarc.solve.settings import resolve
from planarc.study.bundle import Outcome, Payload, Task
from planarc.study.identity import identity
from planarc.study.journal import Journal
from planarc.study.metric import Metric, judge_metrics, read_metric
from planarc.study.points import Point, grid
from planarc.study.table import Failure, Study
from planarc.study.told import Told
from planarc.study.workers import outcomes_of

__all__ = ["Failure", "Study", "StudyInterrupted", "sweep"]

#: Called with the numbers of finished, of all, and of failed points.
Progress: TypeAlias = "Callable[[int, int, int], None]"

_START = ".start"


class StudyInterrupted(KeyboardInterrupt):
    """Ctrl-C; `study` holds the points that were finished."""

    def __init__(self, study: Study) -> None:
        super().__init__("the study was interrupted")
        self.study = study


@telling_keywords
def sweep(
    model: Model,
    points: Mapping[str, Sequence[Any]] | Iterable[Point],
    metric: Metric | None = None,
    *,
    start_time: float | None = None,
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
    of a start value (`crank.phi.start`). `metric`: a text (`crank.w` for its value at the end,
    `max(crank.w)`, also `min`, `mean`, `rms`, `range`, `maxabs`), a function of the Result that
    gives a number or numbers by name, a list of texts, or texts and functions by name, which are
    not those of what is varied; by default the states at the end. `workers`: processes, by default
    one a core. `client`: a Dask client, whose workers do it instead. `limit`: seconds that one run
    may take in a process of its own (with `workers=1` there is none). `journal`: a file that keeps
    finished points. `progress`: True draws a bar; a function is called with the numbers of
    finished, of all and of failed points. Times are in s, all values in SI units.

    Raises UnknownName and UsageError before anything runs: for names that are not there and for
    structural parameters. A point that fails is a row of `failures`. Raises StudyInterrupted at
    Ctrl-C, with the study so far.
    """
    limit = _asked(model, client, limit)
    table = _points(points)
    times = start_time, stop_time, tolerance, intervals
    model, options = model.asked(parameters, start, *times)
    table = [_plain(model, point) for point in table]
    metrics = read_metric(metric, model.program).beside(n for point in table for n in point)
    tasks = _tasks(model, table, options)
    payload = Payload(model, options, metrics)
    warnings = (*_doubts(model, tasks, options), *judge_metrics(metrics, model.program))
    told = Told()
    book = _journal(journal, payload, table)
    done = {i: o for i, o in book.done.items() if 0 <= i < len(tasks)} if book else {}
    try:
        with _watcher(progress) as watch:
            for outcomes in outcomes_of(payload, tasks, done, workers, client, limit):
                done.update((o.index, o) for o in told.take(outcomes))
                if book:
                    book.add(o for o in outcomes if not o.lost)
                watch(len(done), len(tasks), sum(o.values is None for o in done.values()))
    except KeyboardInterrupt:
        warnings += told.warnings()
        raise StudyInterrupted(_study(table, done, payload, warnings)) from None
    finally:
        if book:
            book.close()
    return _study(table, done, payload, warnings + told.warnings())


def _asked(model: Model, client: Any, limit: Any) -> float:
    """The limit in seconds. Raises UsageError for arguments of a wrong kind."""
    if not isinstance(model, Model):
        raise usage_error(
            "C227",
            f"a study needs a model, not {type(model).__name__}",
            hint="load it: planarc.load(...)",
        )
    if client is not None and not (hasattr(client, "submit") and hasattr(client, "scatter")):
        raise usage_error(
            "C228",
            f"`client` is a client of Dask, not {type(client).__name__}",
            hint="write client=distributed.Client(...)",
        )
    seconds = finite("limit", limit)
    if seconds <= 0:
        raise usage_error("C229", f"the limit is above 0 s, not {seconds:g} s")
    return seconds


def _points(points: Any) -> list[dict[str, Any]]:
    if isinstance(points, Mapping):
        return grid(points)
    if hasattr(points, "to_dict"):  # a DataFrame
        points = points.to_dict("records")
    try:
        table = [dict(p) for p in points]
    except (TypeError, ValueError):
        raise usage_error(
            "C230",
            f"the points of a study are values by name, not {type(points).__name__}",
            hint='write them as {"rod.L": [0.5, 0.6]}',
        ) from None
    if not table:
        raise usage_error("C239", "the study has no points")
    return table


def _plain(model: Model, point: dict[str, Any]) -> dict[str, Any]:
    """The point with numbers in the place of values with units."""
    if all(type(v) is float for v in point.values()):
        return point
    return {n: plain_value(model.program, n, v) for n, v in point.items()}


def _tasks(model: Model, table: Sequence[Mapping[str, Any]], options: RunOptions) -> list[Task]:
    """Points as numbers. Raises UsageError for a wrong name, before anything runs."""
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
            except UnknownName:
                raise
            except UsageError as problem:
                tasks.append(Task(i, {}, {}, problem.diagnostics[0].message))
                continue
        names = (*values, *starts)
        if names not in checked:
            given = {**options.values, **values}, {**options.starts, **starts}
            resolve(model.program, replace(options, values=given[0], starts=given[1]))
            checked.add(names)
        tasks.append(Task(i, values, starts))
    return tasks


def _doubts(model: Model, tasks: Sequence[Task], options: RunOptions) -> tuple[Diagnostic, ...]:
    """Warnings of the lowest and the highest value of each name, where it was hardly meant."""
    found: dict[str, Diagnostic] = {}
    for outer in (min, max):
        values = {**options.values, **_outermost(outer, (t.values for t in tasks))}
        starts = {**options.starts, **_outermost(outer, (t.starts for t in tasks))}
        asked = replace(options, values=values, starts=starts)
        found |= {d.message: d for d in doubts(model.program, asked)}
    return tuple(found.values())


def _outermost(
    outer: Callable[[float, float], float], points: Iterable[Mapping[str, float]]
) -> dict[str, float]:
    found: dict[str, float] = {}
    for point in points:
        for name, value in point.items():
            found[name] = outer(value, found.get(name, value))
    return found


def _study(
    table: Sequence[Mapping[str, Any]],
    done: Mapping[int, Outcome],
    payload: Payload,
    warnings: tuple[Diagnostic, ...],
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
    return Study(
        payload.model.name,
        tuple(names),
        tuple(metrics),
        tuple(rows),
        tuple(failures),
        _units(payload, names, metrics),
        warnings,
    )


def _units(payload: Payload, names: Iterable[str], metrics: Iterable[str]) -> dict[str, str]:
    """The units of columns that have one: of a parameter or start value, and of what a metric
    takes from one variable."""
    known = {c.name: c.unit for c in payload.model.program.columns}
    parts = dict(payload.metrics.parts)
    found = {n: known.get(str(n), known.get(str(n).removesuffix(_START), "")) for n in names}
    found |= {n: known.get(getattr(parts.get(n), "variable", ""), "") for n in metrics}
    return {n: unit for n, unit in found.items() if unit}


def _journal(
    path: str | Path | None, payload: Payload, table: Sequence[Mapping[str, Any]]
) -> Journal | None:
    if path is None:
        return None
    program = payload.model.program
    defaults = [(p.name, p.default) for p in program.parameter_slots]
    options = replace(payload.options, values={}, starts={})
    given = sorted(payload.options.values.items()), sorted(payload.options.starts.items())
    digest = hashlib.sha256()
    metrics = identity(payload.metrics.parts)
    for part in (program.name, defaults, options, given, table, metrics):
        digest.update(repr(part).encode())
    code = payload.model.compiled().code
    digest.update(code.encode() if isinstance(code, str) else code)
    return Journal(Path(path), digest.hexdigest())


@contextmanager
def _watcher(progress: bool | Progress) -> Iterator[Progress]:
    if callable(progress):
        yield progress
    elif not progress:
        yield lambda done, total, failed: None
    else:
        with drawn.Progress(keep=True) as bar:
            yield lambda done, total, failed: bar.show(
                f"{failed} failed" if failed else "", done, total
            )
