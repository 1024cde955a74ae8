"""A crew of processes: it survives its workers, and none of them outlives the first process."""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable

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
    with Aside(os.getpid) as aside:
        assert (aside.result() != os.getpid()) == beside


@FORKED
def test_work_that_fails_aside_is_done_again(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(processes, "cores", lambda: 2)
    monkeypatch.setattr(processes, "active_count", lambda: 1)
    here = os.getpid()

    def raises() -> int:
        if os.getpid() != here:
            raise ValueError
        return 1

    def dies() -> int:
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return 2

    def fails() -> int:
        raise ZeroDivisionError

    for work, found in ((raises, 1), (dies, 2)):
        with Aside(work) as aside:
            assert aside.result() == found
    with Aside(fails) as aside, pytest.raises(ZeroDivisionError):
        aside.result()
    assert capfd.readouterr().err == ""


@FORKED
def test_nothing_is_left_of_work_that_nobody_asks_for(
    monkeypatch: pytest.MonkeyPatch, hang: Callable[[], None]
) -> None:
    monkeypatch.setattr(processes, "cores", lambda: 2)
    monkeypatch.setattr(processes, "active_count", lambda: 1)
    before = set(multiprocessing.active_children())
    with pytest.raises(KeyboardInterrupt), Aside(hang):
        assert set(multiprocessing.active_children()) != before
        raise KeyboardInterrupt
    assert set(multiprocessing.active_children()) == before
