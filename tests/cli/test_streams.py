"""Standard streams that are full or closed: a message and an exit code, never a traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(not Path("/dev/full").exists(), reason="a full device of Linux")

MODEL = "model M Real x(start=1, fixed=true); equation der(x) = -x; end M;"


def planarc(words: str, redirected: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = f'"{sys.executable}" -m planarc {words} {redirected}'
    return subprocess.run(
        command, shell=True, cwd=folder, capture_output=True, text=True, check=False,
        env={**os.environ, "PLANARC_DEBUG": ""},
    )  # fmt: skip


@pytest.mark.parametrize("words", ["--help", "--version", "flatten m.pmo", "check m.pmo --json"])
@pytest.mark.parametrize(
    ("redirected", "reason"),
    [(">/dev/full", "no space left on device"), (">&-", "bad file descriptor")],
)
def test_output_that_cannot_be_written_is_told(
    words: str, redirected: str, reason: str, tmp_path: Path
) -> None:
    (tmp_path / "m.pmo").write_text(MODEL, "utf-8")
    done = planarc(words, redirected, tmp_path)
    assert (done.returncode, done.stderr) == (2, f"error[C123]: cannot print: {reason}\n")


@pytest.mark.parametrize("redirected", ["2>/dev/full", "2>&-", "2>&- >&- <&-"])
def test_where_nothing_can_be_told_the_exit_code_tells(redirected: str, tmp_path: Path) -> None:
    done = planarc("check nothing.pmo", redirected, tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "")


def test_no_file_takes_the_place_of_a_closed_stream(tmp_path: Path) -> None:
    """What C's libraries print would go into the results."""
    (tmp_path / "m.pmo").write_text(MODEL, "utf-8")
    done = planarc("simulate m.pmo --output m.csv", ">&- 2>&- <&-", tmp_path)
    assert done.returncode == 2
    assert (tmp_path / "m.csv").read_bytes().startswith(b'"time"')


def test_a_reader_that_goes_away_is_no_mistake(tmp_path: Path) -> None:
    done = planarc("doc PlanarMultiBody --output /dev/stdout.html", "| true", tmp_path)
    assert "Traceback" not in done.stderr
