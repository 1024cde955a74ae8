"""The shipped settings in a real Helix, which runs in a terminal of the test: keys in, screen out.

`PLANARC_HELIX` names the program, and `HELIX_RUNTIME` its folder where it does not find that by
itself; where it is missing, the tests are skipped.
"""

from __future__ import annotations

import os
import re
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "examples" / "four_bar.pmo").read_text("utf-8")
PROGRAM = os.environ.get("PLANARC_HELIX", "")
PATIENCE = 30.0
_SEQUENCE = re.compile(r"\x1b(\[[0-9;?:>]*[ -/]*[@-~]|[PX^_\]].*?(\x1b\\|\x07)|[()].|.)", re.DOTALL)

pytestmark = pytest.mark.skipif(not PROGRAM, reason="PLANARC_HELIX names no Helix")


class Helix:
    """A window of 160 columns with a copy of the four-bar."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / "four_bar.pmo"
        self.file.write_text(TEXT, "utf-8")
        settings = folder / "config" / "helix"
        settings.mkdir(parents=True)
        shipped = (ROOT / "editors" / "helix" / "languages.toml").read_text("utf-8")
        (settings / "languages.toml").write_text(shipped, "utf-8")
        self._program("planarc", f'exec "{sys.executable}" -m planarc "$@"')
        for name in ("xdg-open", "open", "gio"):
            self._program(name, f'echo "$@" >> "{folder}/opened"')
        self._shown = ""
        self._terminal = self._start()

    def _program(self, name: str, script: str) -> None:
        path = self.folder / name
        path.write_text(f"#!/bin/sh\n{script}\n", "utf-8")
        path.chmod(0o755)

    def _start(self) -> int:
        import fcntl
        import pty
        import struct
        import termios

        own = {
            "PATH": f"{self.folder}{os.pathsep}{os.environ['PATH']}",
            "XDG_CONFIG_HOME": str(self.folder / "config"),
            "HOME": str(self.folder),
            "TERM": "xterm-256color",
        }
        log = str(self.folder / "log")
        self._process, terminal = pty.fork()
        if self._process == 0:
            os.chdir(self.folder)
            os.execve(PROGRAM, [PROGRAM, "-vv", "--log", log, self.file.name], os.environ | own)
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 50, 160, 0, 0))
        return terminal

    def _listen(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if select.select([self._terminal], [], [], 0.02)[0]:
                got = os.read(self._terminal, 65536)
                if b"\x1b[c" in got:  # what kind of terminal is this?
                    os.write(self._terminal, b"\x1b[?62;22c")
                self._shown += got.decode("utf-8", "replace")

    def keys(self, text: str, pause: float = 0.3) -> None:
        self._shown = ""
        for part in re.split("(\x1b)", text):
            os.write(self._terminal, part.encode())
            self._listen(0.15 if part == "\x1b" else 0)  # else it would be Alt with the next key
        self._listen(pause)

    def until(self, what: str, condition: Callable[[], object]) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, f"{what} did not come; shown: {self.screen[-2000:]}"
            self._listen(0.1)

    @property
    def screen(self) -> str:
        """What was written since the last keys."""
        return _SEQUENCE.sub("", self._shown)

    @property
    def log(self) -> str:
        """The messages of the protocol, and more."""
        return (self.folder / "log").read_text("utf-8", "replace")

    def saved(self) -> str:
        self.keys("\x1b:w!\r", 0.6)
        return self.file.read_text("utf-8")

    def stop(self) -> None:
        os.kill(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        os.close(self._terminal)


@pytest.fixture
def helix(tmp_path: Path) -> Iterator[Helix]:
    opened = Helix(tmp_path)
    (tmp_path / "log").touch()
    opened.until("the server", lambda: "planarc/checked" in opened.log)
    yield opened
    opened.stop()


def test_a_name_tells_what_it_is_and_where_it_is_declared(helix: Helix) -> None:
    helix.keys("/FixedTranslation crank\r")
    helix.keys(" k")
    helix.until("the description", lambda: "Rigid rod without mass" in helix.screen)
    helix.keys("\x1b/Parts.FixedTranslation\r")
    helix.keys("gd")
    helix.until("the declaration", lambda: "model FixedTranslation" in helix.screen)


def test_names_are_completed(helix: Helix) -> None:
    helix.keys("/equation\r")
    helix.keys("oconnect(cra", 1.0)
    helix.until("the list", lambda: "crankBody.frame_a" in helix.screen)
    helix.keys("\t", 0.5)
    assert "connect(crank" in helix.saved()


def test_a_component_is_renamed(helix: Helix) -> None:
    helix.keys("/FixedTranslation crank\r")
    helix.keys("w r", 1.0)
    helix.keys("\x15kurbel\r", 1.0)
    helix.until("the new name", lambda: "connect(kurbel.frame_b" in helix.saved())
    assert "crank." not in helix.saved()


def test_a_mistake_is_told_and_mended(helix: Helix) -> None:
    helix.keys("/Fixed groundA\r")
    helix.keys("wOFixd other;\x1b", 1.0)
    helix.keys("gh]d", 0.5)
    helix.until("the mistake", lambda: "Fixd" in helix.screen)
    helix.keys(" a")
    helix.until("the cure", lambda: "Fixed" in helix.screen)
    helix.keys("\r", 1.0)
    assert "Fixed other;" in helix.saved()


def test_a_text_is_formatted(helix: Helix) -> None:
    helix.keys("/Fixed groundA\r")
    helix.keys("O   Real   x =1 ;\x1b")
    helix.keys(":format\r", 1.0)
    helix.until("the form", lambda: "\n  Real x = 1;\n" in helix.saved())


def test_the_mechanism_is_shown_and_checked_from_the_command_line(helix: Helix) -> None:
    helix.keys(":lsp-workspace-command planarc.view\r", 0.5)
    opened = helix.folder / "opened"
    helix.until("the page", opened.is_file)
    assert opened.read_text("utf-8").startswith("http://127.0.0.1:")
    helix.keys(':lsp-workspace-command planarc.check "FourBar"\r', 0.5)
    helix.until("the check", lambda: "FourBar is complete" in helix.log)
    helix.keys(':lsp-workspace-command planarc.handbook "PlanarMultiBody.Joints.Revolute"\r', 0.5)
    page = "handbook.html#PlanarMultiBody.Joints.Revolute"
    helix.until("the page of a class", lambda: page in opened.read_text("utf-8"))
