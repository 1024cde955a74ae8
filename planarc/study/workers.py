"""The workers that do the runs of a study: this process, some processes of a crew, or a cluster.

In:   Payload (model, options, metrics), tasks
Out:  outcomes, in bundles, as they come

Each process finds the payload once: by fork, or in a file. A bundle whose process is lost is
tried again point by point, so that one bad point takes nothing else with it.
"""

from __future__ import annotations

import pickle
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from planarc.core.data import Data
from planarc.core.diagnostic import usage_error
from planarc.core.processes import Crew, Lost, cores
from planarc.study.bundle import Outcome, Payload, Task, run_bundle, run_point

#: Points in one bundle, at most, and seconds after which it is handed back unfinished.
BUNDLE, PATIENCE = 32, 1.0
#: Bytes for a process of a study: a notebook may hold much that a fork takes over.
NO_BOUND = 1 << 62


def outcomes_of(
    payload: Payload,
    tasks: Sequence[Task],
    done: Mapping[int, Outcome],
    workers: int | None,
    client: Any,
    limit: float,
) -> Iterator[list[Outcome]]:
    wrong = [Outcome(t.index, None, t.wrong) for t in tasks if t.wrong]
    if wrong:
        yield wrong
    left = [t for t in tasks if t.wrong is None and t.index not in done]
    count = cores() if workers is None else workers
    if not isinstance(count, int) or count < 1:
        raise usage_error("C232", f"the number of workers is an integer above 0, not {count}")
    if client is not None:
        workers = 4 * len(client.ncores() or [0])
        yield from _on_cluster(client, payload, _bundles(left, workers))
    elif min(count, len(left)) <= 1:
        for bundle in _bundles(left, 1):
            yield from _here(payload, bundle)
    else:
        yield from _in_processes(payload, left, count, limit)


def _bundles(tasks: Sequence[Task], workers: int) -> list[tuple[Task, ...]]:
    size = max(1, min(BUNDLE, len(tasks) // max(1, 8 * workers)))
    return [tuple(tasks[i : i + size]) for i in range(0, len(tasks), size)]


def _here(payload: Payload, bundle: Sequence[Task]) -> Iterator[list[Outcome]]:
    """A bundle in this process, or as much of it as was done at Ctrl-C."""
    outcomes: list[Outcome] = []
    try:
        for task in bundle:
            outcomes.append(run_point(payload, task))
    except KeyboardInterrupt:
        yield outcomes
        raise
    yield outcomes


def _on_cluster(
    client: Any, payload: Payload, bundles: Sequence[tuple[Task, ...]]
) -> Iterator[list[Outcome]]:
    """Outcomes as they come. `client` is a `distributed.Client`.

    The compiled model is sent to each worker once. A bundle whose worker died is tried again
    by Dask; if it keeps failing, its points are tried one by one. Where the client itself is
    lost, so are the points that are left, and no others.
    """
    try:
        completed: Any = import_module("distributed").as_completed
    except ImportError:
        raise usage_error(
            "C221",
            "this needs `distributed`, which is not installed",
            hint="install it with `pip install 'dask[distributed]'`",
        ) from None
    left = {task.index for bundle in bundles for task in bundle}
    try:
        for outcomes in _completed(client, completed, payload, bundles):
            left -= {o.index for o in outcomes}
            yield outcomes
    except Exception as problem:  # the client is gone: keep what came before
        reason = f"the cluster failed: {type(problem).__name__} {problem}".rstrip()
        yield [Outcome(i, None, reason, lost=True) for i in sorted(left)]


def _completed(
    client: Any, completed: Any, payload: Payload, bundles: Sequence[tuple[Task, ...]]
) -> Iterator[list[Outcome]]:
    shared = client.scatter(payload, broadcast=True, hash=False)
    waiting = list(bundles)
    while waiting:
        sent = {client.submit(run_bundle, shared, b, pure=False): b for b in waiting}
        waiting = []
        for future in completed(list(sent)):
            bundle = sent.pop(future)
            if future.status == "finished":
                yield future.result()
            elif len(bundle) > 1:
                waiting += [(task,) for task in bundle]
            else:
                reason = f"the worker failed: {future.exception()}"
                yield [Outcome(bundle[0].index, None, reason, lost=True)]


def _in_processes(
    payload: Payload, tasks: Sequence[Task], workers: int, limit: float
) -> Iterator[list[Outcome]]:
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


class _Job(Data):
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
        raise usage_error(
            "C236",
            f"the metric cannot be sent to other processes: {problem}",
            hint="make it a function of a module, or use workers=1",
        ) from None
    return place


def _work(job: _Job) -> list[Outcome]:
    """Run a bundle in a process of the crew."""
    payload = _SHARED.get(job.place) or _read(job.place)
    return run_bundle(payload, job.bundle, PATIENCE)


@lru_cache(maxsize=2)
def _read(place: str) -> Payload:
    payload: Payload = pickle.loads(Path(place).read_bytes())
    return payload
