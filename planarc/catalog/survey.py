"""A whole library looked through: which of its classes parse, flatten and balance.

In:   Request, the name of a package or of a class; or a folder, or a file
Out:  Survey   one finding a class; models and blocks are flattened, the others only read

Each class is looked at by itself, in one of a few processes, within a time limit, so
that one bad class takes nothing else with it. A class tells which classes it holds, so
that the files of a large library are read by all processes, and only once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from enum import Enum
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError, Severity, usage_error
from planarc.core.processes import Crew, Lost, cores
from planarc.core.source import model_files
from planarc.flatten.library.library import Library
from planarc.flatten.library.order import check_order
from planarc.ir import syntax
from planarc.request.reader import Reader
from planarc.request.request import Request, Target, open_library

#: Wall seconds that one class may take.
LIMIT = 60.0

#: Called with the number of classes seen, of those known to come, and the last name.
Progress: TypeAlias = Callable[[int, int, str], None]

_COMPLETE = (syntax.ClassKind.MODEL, syntax.ClassKind.BLOCK)


class Verdict(Enum):
    GOOD = "good"
    BAD = "bad"
    READ = "read"  # no complete model: only read


class Finding(Data):
    """The finding about one class. `kind` is `model`, `partial model`, `type` ..."""

    name: str
    kind: str
    verdict: Verdict
    diagnostics: tuple[Diagnostic, ...] = ()
    inner: tuple[str, ...] = ()  # names of the classes declared in it

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        return tuple(d for d in self.diagnostics if d.severity is Severity.ERROR)


class Count(Data):
    """Models that are good and bad, and the other classes, of one package."""

    package: str
    good: int = 0
    bad: int = 0
    others: int = 0

    @property
    def percent(self) -> float | None:
        """Good ones of a hundred models, None without models."""
        models = self.good + self.bad
        return 100.0 * self.good / models if models else None

    def with_one(self, verdict: Verdict) -> Count:
        name = {Verdict.GOOD: "good", Verdict.BAD: "bad", Verdict.READ: "others"}[verdict]
        return replace(self, **{name: getattr(self, name) + 1})


class Cause(Data):
    """One error, and the classes that fail by it first."""

    diagnostic: Diagnostic
    names: tuple[str, ...]


class Survey(Data):
    """All findings, a package before what it holds, in the order of the library."""

    target: str
    findings: tuple[Finding, ...]

    @property
    def total(self) -> Count:
        count = Count(self.target)
        for finding in self.findings:
            count = count.with_one(finding.verdict)
        return count

    def packages(self) -> tuple[Count, ...]:
        """A count for each package directly in the target, after one for all that is in none."""
        counts = {self.target: Count(self.target)}
        packages = {f.name for f in self.findings if f.kind == "package"}
        names = {f.name for f in self.findings}
        start = self.target.count(".") + 2 if self.target in names else 1
        for finding in self.findings:
            package = ".".join(finding.name.split(".")[:start])
            place = package if package in packages else self.target
            counts[place] = counts.get(place, Count(place)).with_one(finding.verdict)
        return tuple(count for count in counts.values() if count.good + count.bad + count.others)

    def causes(self) -> tuple[Cause, ...]:
        """The first errors of the bad classes, the most frequent first."""
        found: dict[object, tuple[Diagnostic, list[str]]] = {}
        for finding in self.findings:
            if finding.verdict is Verdict.BAD:
                first = finding.errors[0]
                span = first.span
                place = (span.source.name, span.start, span.end) if span else first.message
                key = (first.code, place)
                found.setdefault(key, (first, []))[1].append(finding.name)
        causes = [Cause(first, tuple(names)) for first, names in found.values()]
        return tuple(sorted(causes, key=lambda cause: -len(cause.names)))


class _Job(Data):
    request: Request
    name: str


def survey(
    request: Request, workers: int | None = None, progress: Progress | None = None
) -> Survey:
    """Look through all classes of what is requested. Raises PlanarcError when it is not there.

    A request for a file or folder without a class name means all classes in it.
    """
    target, jobs, unread = _first_jobs(request)
    crew: Crew[_Job, Finding] = Crew(_examine, workers or cores(), LIMIT)
    crew.add(jobs)
    found: dict[_Job, Finding] = {}
    for job, result in crew:
        finding = found[job] = _lost(job, result) if isinstance(result, Lost) else result
        crew.add(_inner_jobs(job, finding))
        if progress is not None:
            progress(len(found), len(found) + crew.waiting, finding.name)
    ordered = _in_order(jobs, found)
    return Survey(target, (*ordered, *unread))


def _first_jobs(request: Request) -> tuple[str, list[_Job], list[Finding]]:
    """The target, its outermost classes, and files that cannot be read."""
    if request.file is None:
        library, _, _ = open_library(request)
        name = request.class_name or ""
        if library.entry(name) is None:
            hint = "name a package, a folder or a file; see `planarc list` for the names"
            raise usage_error("C103", f"there is no class `{name}`", hint=hint)
        return name, [_Job(replace(request, class_name=None), name)], []
    if not request.file.is_dir():
        _, _, names = open_library(request)
        return str(request.file), [_Job(request, name) for name in names], []
    return _jobs_of_folder(request, request.file)


def _jobs_of_folder(request: Request, folder: Path) -> tuple[str, list[_Job], list[Finding]]:
    """The packages in a folder and the folders in it (or the one that it is), and files that stand
    by themselves."""
    jobs: list[_Job] = []
    unread: list[Finding] = []
    folders = [folder]
    while folders:
        here = folders.pop()
        around = replace(request, file=None, libraries=(here, *request.libraries))
        library, _, _ = open_library(around)
        own = type(library)((here,), library.parse_file, library.parse_annotation)
        packages = [entry for entry in map(own.entry, own.top_names()) if entry and entry.folder]
        jobs += [_Job(around, entry.full_name) for entry in packages]
        known = {entry.folder for entry in packages}
        if here in known:
            continue
        for path in model_files(here):
            alone = replace(around, file=path)
            try:
                _, _, names = open_library(alone)
            except PlanarcError as problem:
                name = path.relative_to(folder).as_posix()
                unread.append(Finding(name, "file", Verdict.BAD, problem.diagnostics))
                continue
            jobs += [_Job(alone, name) for name in names]
        inner = (p for p in sorted(here.iterdir(), reverse=True) if p.is_dir() and p not in known)
        folders += [p for p in inner if not (p.name.startswith(".") or p.is_symlink())]
    if len(jobs) == 1 and not unread:
        return jobs[0].name, jobs, unread
    return str(folder), jobs, unread


def _inner_jobs(job: _Job, finding: Finding) -> list[_Job]:
    return [_Job(job.request, f"{job.name}.{inner}") for inner in finding.inner]


def _in_order(tops: Sequence[_Job], found: dict[_Job, Finding]) -> Iterator[Finding]:
    stack = list(reversed(tops))
    while stack:
        job = stack.pop()
        yield found[job]
        stack.extend(reversed(_inner_jobs(job, found[job])))


def _lost(job: _Job, why: Lost) -> Finding:
    if why is Lost.DIED:
        what = Diagnostic("X004", f"planarc's process ended while it read `{job.name}`")
    else:
        what = Diagnostic("X003", f"`{job.name}` takes more than {LIMIT:g} s")
    return Finding(job.name, "class", Verdict.BAD, (what,))


# In a process of the crew ---------------------------------------------------------------------


@lru_cache(maxsize=4)
def _library(request: Request) -> tuple[Library, Reader]:
    """One library for all classes that a process looks at: each file is read once."""
    library, reader, _ = open_library(request)
    return library, reader


def _examine(job: _Job) -> Finding:
    finding = Finding(job.name, "class", Verdict.READ)
    try:
        library, reader = _library(job.request)
        definition = library.lookup(job.name)
        if definition is None:
            raise PlanarcError(Diagnostic("C103", f"there is no class `{job.name}`"))
        partial = "partial " if definition.partial else ""
        finding = replace(
            finding, kind=partial + definition.kind.value, inner=library.class_names(job.name)
        )
        entry = library.entry(job.name)
        disorder = tuple(check_order(entry)) if entry is not None else ()
        if disorder:
            return replace(finding, verdict=Verdict.BAD, diagnostics=disorder)
        if definition.partial or definition.kind not in _COMPLETE:
            return finding
        from planarc.stages import flatten

        warnings = flatten(Target(library, job.name, reader, units=job.request.units)).warnings
        return replace(finding, verdict=Verdict.GOOD, diagnostics=warnings)
    except PlanarcError as error:
        return replace(finding, verdict=Verdict.BAD, diagnostics=error.diagnostics)
    except Exception as error:  # a mistake of planarc's own: said, and the survey goes on
        bug = Diagnostic("X001", f"sorry, planarc made a mistake: {type(error).__name__}: {error}")
        return replace(finding, verdict=Verdict.BAD, diagnostics=(bug,))
