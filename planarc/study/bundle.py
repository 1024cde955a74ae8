"""Some points of a study, run one after the other: what each process does.

In:   Payload (model, options, metrics), tasks
Out:  outcomes

A point that fails is told with its reason; nothing is raised but KeyboardInterrupt at Ctrl-C.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from time import monotonic

from msgspec.structs import replace

from planarc.api.model import Model
from planarc.api.result import Result
from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, mistake, unexplained
from planarc.core.options import RunOptions
from planarc.ir.result import Interrupted
from planarc.solve.doubts import doubts
from planarc.study.metric import Metrics


class Outcome(Data):
    """The metrics of one point, or why it has none."""

    index: int
    values: dict[str, float] | None
    failed: str | None = None
    lost: bool = False  # its process died or took too long: worth another try
    warnings: tuple[Diagnostic, ...] = ()  # of the run, but those of the request alone


class Task(Data):
    """One point as numbers; `wrong` says why it cannot be run at all."""

    index: int
    values: dict[str, float]
    starts: dict[str, float]
    wrong: str | None = None


class Payload(Data):
    """The model, options and metrics that all runs share."""

    model: Model
    options: RunOptions
    metrics: Metrics


def run_bundle(
    payload: Payload, bundle: Sequence[Task], patience: float = math.inf
) -> list[Outcome]:
    """The outcomes of some points, as many as fit into some seconds (at least one)."""
    end = monotonic() + patience
    outcomes: list[Outcome] = []
    for task in bundle:
        outcomes.append(run_point(payload, task))
        if monotonic() > end:
            break
    return outcomes


def _options(options: RunOptions, task: Task) -> RunOptions:
    return replace(
        options, values={**options.values, **task.values}, starts={**options.starts, **task.starts}
    )


def run_point(payload: Payload, task: Task) -> Outcome:
    options = _options(payload.options, task)
    try:
        result = payload.model.run(options)
    except PlanarcError as problem:
        if isinstance(problem.diagnostics[0], Interrupted):  # the whole study is meant
            raise KeyboardInterrupt from None
        return Outcome(task.index, None, problem.diagnostics[0].message)
    except Exception as bug:
        return Outcome(task.index, None, mistake(bug).message)
    try:
        values = payload.metrics(result)
    except (Exception, SystemExit) as problem:
        return Outcome(task.index, None, f"the metric fails: {_what(problem)}")
    return Outcome(task.index, values, warnings=_warnings(payload.model, options, result))


def _warnings(model: Model, options: RunOptions, result: Result) -> tuple[Diagnostic, ...]:
    """What a run warns of, but what its request shows: the study tells of that before."""
    if not result.warnings:
        return ()
    asked = doubts(model.program, options)
    found = unexplained(model.warnings, result.warnings)
    return tuple(w for w in found if w.severity is Severity.WARNING and w not in asked)


def _what(problem: BaseException) -> str:
    """An error of a user's function in one line, with its place there."""
    from traceback import extract_tb

    own = Path(__file__).parent.parent
    frames = [f for f in extract_tb(problem.__traceback__) if own not in Path(f.filename).parents]
    place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})" if frames else ""
    if isinstance(problem, PlanarcError):
        return f"{problem.diagnostics[0].message}{place}"
    return f"{type(problem).__name__}: {problem}{place}"
