"""`planarc serve` as a person runs it: in a process of its own, ended by Ctrl-C."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from planarc.cli.app import run
from planarc.live.server import LiveServer

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def served() -> Iterator[tuple[Any, str]]:
    """The process and the address that it printed."""
    command = [
        sys.executable,
        "-m",
        "planarc",
        "serve",
        str(EXAMPLES / "pendulum.pmo"),
        "--no-open",
    ]
    # A group of its own, so that Ctrl-C reaches it alone.
    group = {} if os.name == "nt" else {"start_new_session": True}
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **group
    )
    assert process.stdout is not None
    yield process, process.stdout.readline().strip()
    if process.poll() is None:
        process.kill()
    process.communicate()


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C cannot be sent to one process there")
def test_it_serves_until_ctrl_c(served: tuple[Any, str]) -> None:
    process, address = served
    assert address.startswith("http://127.0.0.1:")
    with urllib.request.urlopen(address, timeout=300) as page:
        assert b"Pendulum" in page.read()
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0
    assert out == ""
    assert err.splitlines() == ["Pendulum is served here until Ctrl-C", "stopped"]


def test_a_port_in_use_is_named(served: tuple[Any, str]) -> None:
    port = served[1].split(":")[2].split("/")[0]
    command = [sys.executable, "-m", "planarc", "serve", str(EXAMPLES / "pendulum.pmo")]
    second = subprocess.run(
        [*command, "--no-open", "--port", port], capture_output=True, text=True, check=False
    )
    assert second.returncode == 2
    assert f"error[C280]: cannot listen on port {port}: " in second.stderr
    assert "choose another one with `--port`" in second.stderr


def test_cycles_that_requests_leave_are_looked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that ends soon looks seldom; a server would grow with each request."""
    before, seen = gc.get_threshold(), []
    monkeypatch.setattr(LiveServer, "serve", lambda _: seen.append(gc.get_threshold()))
    gc.set_threshold(1_000_000, 10, 10)
    try:
        assert run(["serve", str(EXAMPLES / "pendulum.pmo"), "--no-open"]) == 0
    finally:
        gc.unfreeze()
        gc.set_threshold(*before)
    assert seen[0][0] < 10_000
