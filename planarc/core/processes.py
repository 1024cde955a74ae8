"""A crew of processes: each does one job at a time, and none of them can stop the others.

A job that kills its process, or takes longer than the limit, is reported as lost;
a new process takes the place of the old one. Jobs may be added while others run.
However the first process ends, the others end with it.

Example:

    crew = Crew(work, workers=2, limit=60)
    crew.add(["a", "b"])
    for job, result in crew: ...        # result is what work(job) gave, or a Lost
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from enum import Enum
from itertools import islice
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from threading import active_count
from time import monotonic
from typing import Generic, TypeVar

from msgspec import Struct

Job = TypeVar("Job")
Result = TypeVar("Result")

#: Bytes that one process may take beyond those with which it begins.
MEMORY = 4 * 1024**3
#: True where processes are forked; elsewhere that cannot be done, or not safely.
_FORKS = sys.platform.startswith("linux")
_PR_SET_PDEATHSIG = 1  # of Linux's `prctl`


class Lost(Enum):
    """Why a job has no result."""

    DIED = "died"
    TOO_LONG = "too long"


class _Worker(Struct, Generic[Job]):
    process: BaseProcess
    connection: Connection
    job: Job
    deadline: float


class Crew(Generic[Job, Result]):
    """Iterate over it for the jobs and their results, in the order in which they end.

    `work` is a function of a module and must not raise; `limit` in wall seconds, `memory`
    in bytes, where the system can hold a process to that.
    """

    def __init__(
        self,
        work: Callable[[Job], Result],
        workers: int,
        limit: float,
        memory: int = MEMORY,
    ) -> None:
        self._work = work
        self._memory = memory
        self._count = max(1, workers)
        self._limit = limit
        self._jobs: deque[Job] = deque()
        self._busy: list[_Worker[Job]] = []
        self._idle: list[_Worker[Job]] = []
        self._start: Callable[..., BaseProcess] = multiprocessing.get_context("spawn").Process
        if _FORKS:
            self._start = multiprocessing.get_context("fork").Process

    def add(self, jobs: Iterable[Job]) -> None:
        """Add jobs before those that wait already."""
        self._jobs.extendleft(reversed(list(jobs)))

    @property
    def waiting(self) -> int:
        return len(self._jobs) + len(self._busy)

    def __iter__(self) -> Iterator[tuple[Job, Result | Lost]]:
        try:
            while self.waiting:
                self.begin()
                yield from self._collect()
        finally:
            self.end()

    def end(self) -> None:
        """End all processes, whatever they do."""
        for worker in (*self._busy, *self._idle):
            self._dismiss(worker)
        self._busy, self._idle = [], []

    def begin(self) -> None:
        """Begin as many jobs as there are workers."""
        while self._jobs and len(self._busy) < self._count:
            job = self._jobs.popleft()
            worker = self._idle.pop() if self._idle else self._hire(job)
            worker.job = job
            worker.deadline = monotonic() + self._limit
            self._busy.append(worker)
            try:
                worker.connection.send(job)
            except OSError:
                continue  # it died; `_collect` sees that

    def _collect(self) -> list[tuple[Job, Result | Lost]]:
        soonest = min(worker.deadline for worker in self._busy)
        ready = wait([worker.connection for worker in self._busy], max(0.0, soonest - monotonic()))
        results: list[tuple[Job, Result | Lost]] = []
        still: list[_Worker[Job]] = []
        for worker in self._busy:
            if worker.connection in ready:
                results.append((worker.job, self._receive(worker)))
            elif monotonic() > worker.deadline:
                self._dismiss(worker)
                results.append((worker.job, Lost.TOO_LONG))
            else:
                still.append(worker)
        self._busy = still
        return results

    def _receive(self, worker: _Worker[Job]) -> Result | Lost:
        try:
            result: Result = worker.connection.recv()
        except (EOFError, OSError):
            self._dismiss(worker)
            return Lost.DIED
        self._idle.append(worker)
        return result

    def _hire(self, job: Job) -> _Worker[Job]:
        ours, theirs = multiprocessing.Pipe()
        inherited = [w.connection for w in (*self._busy, *self._idle)] + [ours] if _FORKS else []
        arguments = (theirs, self._work, self._memory, os.getpid(), inherited)
        process = self._start(target=_serve, args=arguments, daemon=True)
        process.start()
        theirs.close()
        return _Worker(process, ours, job, 0.0)

    def _dismiss(self, worker: _Worker[Job]) -> None:
        worker.connection.close()
        worker.process.kill()
        worker.process.join()


class Aside(Generic[Result]):
    """What `work` yields, done meanwhile by a process of its own, where there is a core for it and
    nothing that a fork would hurt; else here, when it is asked for.

    with Aside(work) as aside: ...; first = next(aside); ...; last = next(aside)

    Where the process is lost, or `work` raises there, it is done again. What is not asked for yet
    waits in a pipe: results that are long hold the process up.
    """

    def __init__(self, work: Callable[[], Iterator[Result]], limit: float = 60.0) -> None:
        self._work = work
        self._given = 0
        self._here: Iterator[Result] | None = None
        self._process: BaseProcess | None = None
        self._deadline = monotonic() + limit
        if _FORKS and cores() > 1 and active_count() == 1:
            self._connection, theirs = multiprocessing.Pipe()
            arguments = (theirs, work, MEMORY, os.getpid(), [self._connection])
            begin = multiprocessing.get_context("fork").Process
            self._process = begin(target=_yield, args=arguments, daemon=True)
            self._process.start()
            theirs.close()

    def __next__(self) -> Result:
        if self._process is not None:
            try:
                if self._connection.poll(max(0.0, self._deadline - monotonic())):
                    found: Result = self._connection.recv()
                    self._given += 1
                    return found
            except (EOFError, OSError):
                pass
            self._end()
        if self._here is None:
            self._here = islice(self._work(), self._given, None)
        return next(self._here)

    def _end(self) -> None:
        if self._process is not None:
            self._connection.close()
            self._process.kill()
            self._process.join()
            self._process = None

    def __enter__(self) -> Aside[Result]:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()


def cores() -> int:
    """The number of processes that can run at once."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _serve(
    connection: Connection,
    work: Callable[[Job], Result],
    memory: int,
    parent: int,
    inherited: Iterable[Connection],
) -> None:
    """Do jobs in a process of the crew. `inherited`: ends of pipes of the first process."""
    _settle(memory, parent, inherited)
    while True:
        try:
            job: Job = connection.recv()
        except (EOFError, OSError):
            return
        connection.send(work(job))


def _yield(
    connection: Connection,
    work: Callable[[], Iterator[Result]],
    memory: int,
    parent: int,
    inherited: Iterable[Connection],
) -> None:
    """Send what it yields. The other end looks itself for why it ends too early."""
    _settle(memory, parent, inherited)
    with suppress(Exception):
        for found in work():
            connection.send(found)


def _settle(memory: int, parent: int, inherited: Iterable[Connection]) -> None:
    """Begin as a process that the first one ends, and that may take so much memory."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the first process ends the others
    _end_with(parent)
    for other in inherited:
        other.close()  # else nobody would notice that its owner is gone
    _bound_memory(memory)


def _end_with(parent: int) -> None:
    """End this process when its parent ends, even if it is killed."""
    if _FORKS:
        import ctypes

        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
        return
    from threading import Thread

    def watch() -> None:
        if first := multiprocessing.parent_process():
            first.join()
            os._exit(1)

    Thread(target=watch, daemon=True).start()


def _bound_memory(memory: int) -> None:
    try:
        import resource
    except ImportError:  # Windows
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    try:  # a forked process begins with all that its parent has
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
    except OSError:
        pages = 0
    memory += pages * resource.getpagesize()
    limit = memory if hard == resource.RLIM_INFINITY else min(memory, hard)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    except (ValueError, OSError):
        return
