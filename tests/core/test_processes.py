"""A crew of processes: nothing of it outlives the process that hired it."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys

import pytest

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


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="how Linux ends processes")
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
