"""Ctrl-C at any moment of a command: it is told, and what was computed is saved."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from planarc.cli import check
from planarc.cli.app import run
from planarc.study.table import Study
from planarc.view.page import report as page
from planarc.view.table import files

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

DECAY = "model Decay parameter Real k = 1; Real x(start=1, fixed=true);" + (
    " equation der(x) = -k*x; end Decay;"
)

#: Sends Ctrl-C when `main` has imported so many modules.
PROGRAM = """
import os, signal, sys
from planarc.cli import main
left = int(sys.argv.pop(1))
def count(event, arguments):
    global left
    if event == "import":
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGINT)
sys.addaudithook(count)
main()
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("decay.pmo").write_text(DECAY, "utf-8")


def interrupting(function: Callable[..., Any], times: int = 1) -> Callable[..., Any]:
    """Ctrl-C comes just before the function is called."""

    def called(*arguments: Any, **options: Any) -> Any:
        for _ in range(times):
            os.kill(os.getpid(), signal.SIGINT)
        return function(*arguments, **options)

    return called


def test_next_to_nothing_is_imported_before_ctrl_c_is_caught() -> None:
    program = (
        "import sys; before = {*sys.modules}; import planarc.cli; print({*sys.modules} - before)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert eval(done.stdout) <= {"planarc", "planarc.cli", "__future__"}


@pytest.mark.parametrize("imported", [1, 20, 150])
def test_ctrl_c_while_a_command_is_loaded(imported: int) -> None:
    command = [sys.executable, "-c", PROGRAM, str(imported), "check", "decay.pmo"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode in (130, -signal.SIGINT)
    assert (done.stdout, done.stderr) == ("", "error[C130]: interrupted\n")


def test_ctrl_c_in_a_command_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(check, "make_request", interrupting(check.make_request))
    assert run(["check", "decay.pmo"]) == 130
    assert capsys.readouterr().err == "error[C130]: interrupted\n"


@pytest.mark.parametrize("written", ["table", "page"])
def test_ctrl_c_while_results_are_written_leaves_them_whole(
    written: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["simulate", "decay.pmo"]) == 0
    whole = {p.name: p.read_bytes() for p in Path().iterdir()}
    for name in ("Decay.csv", "Decay.html"):
        Path(name).unlink()
    module, name = (files, "write_table") if written == "table" else (page, "write_report")
    monkeypatch.setattr(module, name, interrupting(getattr(module, name)))
    capsys.readouterr()
    assert run(["simulate", "decay.pmo"]) == 130
    out, err = capsys.readouterr()
    assert "Decay.csv" in out
    assert err == "error[C130]: interrupted after the run, whose results are saved\n"
    assert {p.name: p.read_bytes() for p in Path().iterdir()} == whole


def test_a_second_ctrl_c_drops_what_is_not_yet_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(files, "write_table", interrupting(files.write_table, 2))
    assert run(["simulate", "decay.pmo"]) == 130
    assert capsys.readouterr().err == "error[C130]: interrupted\n"
    assert {p.name for p in Path().iterdir()} == {"decay.pmo"}


def test_ctrl_c_while_the_table_of_a_study_is_written_leaves_it_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Study, "to_csv", interrupting(Study.to_csv))
    arguments = ["sweep", "decay.pmo", "--vary", "k=1,2,3", "--metric", "x", "--workers", "1"]
    assert run([*arguments, "--output", "table.csv"]) == 130
    assert len(Path("table.csv").read_text("utf-8").splitlines()) == 4
