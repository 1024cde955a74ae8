"""A whole library looked through: which of its classes parse, flatten and balance.

In:   Library, the name of a package (or of one class)
Out:  Survey   one line a class; models and blocks are flattened, the others only read

Each class is looked at by itself, in a process of its own pool, within a time limit,
so that one bad class takes nothing else with it.
"""

from __future__ import annotations

import os
import signal
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from enum import Enum

from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity
from planarc.request import MODELS, Request, Target, open_library

#: Seconds that one class may take.
LIMIT = 60
_CHUNK = 24  # classes a task: those of one package share what was read


class Verdict(Enum):
    GOOD = "good"
    BAD = "bad"
    READ = "read"  # not a complete model: only read


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found out about one class. `kind` is `model`, `partial model`, `type` ..."""

    name: str
    kind: str
    verdict: Verdict
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        return tuple(d for d in self.diagnostics if d.severity is Severity.ERROR)


@dataclass(frozen=True, slots=True)
class Survey:
    findings: tuple[Finding, ...]

    def counts(self, depth: int) -> dict[str, Counter[Verdict]]:
        """Verdicts of the models by the first `depth` parts of their names, in order."""
        found: dict[str, Counter[Verdict]] = {}
        for finding in self.findings:
            package = ".".join(finding.name.split(".")[:depth])
            found.setdefault(package, Counter())[finding.verdict] += 1
        return found


def survey(request: Request, package: str, workers: int | None = None) -> Survey:
    """Look through all classes of a package. Raises PlanarcError when there is none."""
    library, _, _ = open_library(request)
    if library.entry(package) is None:
        raise PlanarcError(Diagnostic("C103", f"there is no class `{package}`"))
    names = list(all_classes(library, package))
    chunks = [names[i : i + _CHUNK] for i in range(0, len(names), _CHUNK)]
    found: list[Finding] = []
    for chunk, findings in _in_parallel(request, chunks, workers or os.cpu_count() or 1):
        found.extend(findings if findings is not None else _one_by_one(request, chunk))
    order = {name: i for i, name in enumerate(names)}
    return Survey(tuple(sorted(found, key=lambda f: order[f.name])))


def all_classes(library: object, package: str) -> Iterator[str]:
    """A class and all classes in it, in the order of the library."""
    from planarc.flatten.library import Library

    assert isinstance(library, Library)
    stack = [package]
    while stack:
        name = stack.pop()
        yield name
        try:
            inner = library.class_names(name)
        except PlanarcError:
            continue  # its own line says what is wrong with it
        stack.extend(f"{name}.{n}" for n in reversed(inner))


def _in_parallel(
    request: Request, chunks: Sequence[list[str]], workers: int
) -> Iterator[tuple[list[str], list[Finding] | None]]:
    """The findings of each chunk, None where a process died on it."""
    if workers == 1 or len(chunks) < 2:
        for chunk in chunks:
            yield chunk, examine(request, chunk)
        return
    with ProcessPoolExecutor(workers) as pool:
        tasks = [pool.submit(examine, request, chunk) for chunk in chunks]
        for chunk, task in zip(chunks, tasks, strict=True):
            try:
                yield chunk, task.result()
            except BrokenProcessPool:
                yield chunk, None


def _one_by_one(request: Request, names: Sequence[str]) -> list[Finding]:
    """Each class in a process of its own, so that the one that kills it is known."""
    found: list[Finding] = []
    for name in names:
        with ProcessPoolExecutor(1) as pool:
            try:
                found.extend(pool.submit(examine, request, [name]).result())
            except BrokenProcessPool:
                died = Diagnostic("X002", f"planarc's process ended while it read `{name}`")
                found.append(Finding(name, "class", Verdict.BAD, (died,)))
    return found


def examine(request: Request, names: Sequence[str]) -> list[Finding]:
    """Findings of some classes, which share one library."""
    library, reader, _ = open_library(request)
    return [_examine(Target(library, name, reader)) for name in names]


class _TooLong(Exception):
    pass


def _examine(target: Target) -> Finding:
    kind = "class"
    try:
        with _Limit(LIMIT):
            definition = target.library.lookup(target.class_name)
            if definition is None:
                raise PlanarcError(Diagnostic("C103", f"there is no class `{target.class_name}`"))
            kind = ("partial " if definition.partial else "") + definition.kind.value
            if definition.partial or definition.kind not in MODELS:
                return Finding(target.class_name, kind, Verdict.READ)
            from planarc.compiler import flatten

            warnings = flatten(target).warnings
        return Finding(target.class_name, kind, Verdict.GOOD, warnings)
    except PlanarcError as error:
        return Finding(target.class_name, kind, Verdict.BAD, error.diagnostics)
    except _TooLong:
        slow = Diagnostic("X003", f"`{target.class_name}` takes more than {LIMIT} s")
        return Finding(target.class_name, kind, Verdict.BAD, (slow,))
    except Exception as error:  # a mistake of planarc's own: said, and the survey goes on
        bug = Diagnostic("X001", f"sorry, planarc made a mistake: {type(error).__name__}: {error}")
        return Finding(target.class_name, kind, Verdict.BAD, (bug,))


class _Limit:
    """Ends what runs too long, where the system has alarms."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds

    def __enter__(self) -> None:
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, self._stop)
            signal.setitimer(signal.ITIMER_REAL, self._seconds)

    def __exit__(self, *_: object) -> None:
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)

    @staticmethod
    def _stop(_signal: int, _frame: object) -> None:
        raise _TooLong
