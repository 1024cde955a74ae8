"""A crew of processes: it survives its workers, and none of them outlives the first process."""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from planarc.core import processes
from planarc.core.processes import Aside, Crew, Lost

FORKED = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="the processes are no copies of this one"
)

PROGRAM = """
import os, signal, sys
from planarc.core.processes import Crew

def work(job):
    if job == "hang":
        os.write(int(sys.argv[1]), b"h")
        while True:
            signal.pause()
    return job

crew = Crew(work, workers=3, limit=1e6)
crew.add(["quick", "hang", "hang"])
for job, result in crew:
    os.write(int(sys.argv[1]), b"q")
"""


@pytest.fixture
def misbehave(hang: Callable[[], None]) -> Callable[[str], str]:
    def work(job: str) -> str:
        if job == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        if job == "hang":
            hang()
        return job.upper()

    return work


@FORKED
@pytest.mark.parametrize("workers", [1, 2])
def test_a_crew_survives_its_workers(misbehave: Callable[[str], str], workers: int) -> None:
    jobs = ["a", "die", "b", "hang", "c", "die", "d"]
    working: Crew[str, str] = Crew(misbehave, workers, limit=1.0)
    working.add(jobs)
    found = sorted((job, result) for job, result in working if not isinstance(result, Lost))
    assert found == [("a", "A"), ("b", "B"), ("c", "C"), ("d", "D")]


@FORKED
def test_a_crew_says_why_a_job_is_lost(misbehave: Callable[[str], str]) -> None:
    working: Crew[str, str] = Crew(misbehave, 2, limit=1.0)
    working.add(["die", "hang"])
    assert dict(working) == {"die": Lost.DIED, "hang": Lost.TOO_LONG}


@FORKED
@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGTERM])
def test_the_others_end_when_the_first_process_is_killed(kind: signal.Signals) -> None:
    """One of them waits for a job, two never end theirs. All hold the end of a pipe, which is
    closed by the last of them."""
    ours, theirs = os.pipe()
    command = [sys.executable, "-c", PROGRAM, str(theirs)]
    with subprocess.Popen(command, pass_fds=[theirs]) as process:
        os.close(theirs)
        begun = b""
        while len(begun) < 3:
            begun += os.read(ours, 1)
        assert sorted(begun) == sorted(b"qhh")
        process.send_signal(kind)
    ready, _, _ = select.select([ours], [], [], 300)
    assert ready and os.read(ours, 1) == b""
    os.close(ours)


@FORKED
def test_what_a_process_begins_with_does_not_count() -> None:
    import mmap

    def work(size: int) -> bool:
        try:
            with mmap.mmap(-1, size):
                return True
        except (OSError, MemoryError):
            return False

    with mmap.mmap(-1, 2**30):  # what a long session has taken before
        working: Crew[int, bool] = Crew(work, 1, limit=60.0, memory=2**28)
        working.add([2**27, 2**29])
        assert dict(working) == {2**27: True, 2**29: False}


@FORKED
@pytest.mark.parametrize(
    ("cores", "threads", "beside"), [(2, 1, True), (1, 1, False), (2, 3, False)]
)
def test_work_aside(
    cores: int, threads: int, beside: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "cores", lambda: cores)
    monkeypatch.setattr(processes, "active_count", lambda: threads)

    def work() -> Iterator[int]:
        yield os.getpid()
        yield 2

    with Aside(work) as aside:
        assert (next(aside) != os.getpid()) == beside
        assert next(aside) == 2
        with pytest.raises(StopIteration):
            next(aside)


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "cores", lambda: 2)
    monkeypatch.setattr(processes, "active_count", lambda: 1)


@FORKED
@pytest.mark.usefixtures("two_cores")
@pytest.mark.parametrize("before", [0, 1, 2])
def test_work_that_fails_aside_is_done_again(
    before: int, capfd: pytest.CaptureFixture[str]
) -> None:
    """What it yielded before comes once, from there."""
    here = os.getpid()

    def fails(how: Callable[[], None]) -> Iterator[tuple[int, bool]]:
        for i in range(before):
            yield i, os.getpid() == here
        if os.getpid() != here:
            how()
        yield before, True

    def raises() -> None:
        raise ValueError

    def dies() -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    for how in (raises, dies):
        with Aside(lambda how=how: fails(how)) as aside:
            found = [next(aside) for _ in range(before + 1)]
        assert found == [*((i, False) for i in range(before)), (before, True)]
    assert capfd.readouterr().err == ""


@FORKED
@pytest.mark.usefixtures("two_cores")
def test_work_that_fails_here_as_well_says_so() -> None:
    def fails() -> Iterator[int]:
        yield 1
        raise ZeroDivisionError

    with Aside(fails) as aside:
        assert next(aside) == 1
        with pytest.raises(ZeroDivisionError):
            next(aside)


@FORKED
@pytest.mark.usefixtures("two_cores")
def test_work_aside_that_takes_too_long_is_done_here(hang: Callable[[], None]) -> None:
    here = os.getpid()

    def work() -> Iterator[int]:
        if os.getpid() != here:
            hang()
        yield 1

    with Aside(work, limit=0.2) as aside:
        assert next(aside) == 1


@FORKED
@pytest.mark.usefixtures("two_cores")
@pytest.mark.parametrize("length", [1, 10**6])
def test_nothing_is_left_of_work_that_nobody_asks_for(
    length: int, hang: Callable[[], None]
) -> None:
    """Whether it hangs, or waits until its result is read."""
    before = set(multiprocessing.active_children())

    def work() -> Iterator[bytes]:
        yield bytes(length)
        hang()

    with pytest.raises(KeyboardInterrupt), Aside(work):
        assert set(multiprocessing.active_children()) != before
        raise KeyboardInterrupt
    assert set(multiprocessing.active_children()) == before
