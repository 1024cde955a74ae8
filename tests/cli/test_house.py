"""The commands beside modelling: cache, doctor, new, completion; quiet and verbose."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from planarc.cli.app import run

DECAY = "model Decay Real x(start=1, fixed=true); equation der(x) = -x; end Decay;"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "decay.pmo").write_text(DECAY, "utf-8")
    return tmp_path


def test_the_doctor_finds_this_installation_healthy(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["doctor", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["ok"]
    assert report["packages"]["numpy"]
    assert {t["backend"] for t in report["self_test"]} >= {"numpy"}
    assert all(t["ok"] for t in report["self_test"])


def test_the_doctor_tells_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from planarc.cli import doctor

    monkeypatch.setattr(doctor, "CHOSEN", {"no-such-package": "nothing in particular"})
    monkeypatch.setattr(doctor, "NEEDED", ("numpy", "another-missing-one"))
    assert run(["doctor"]) == 3
    shown = capsys.readouterr().out
    assert "not installed (nothing in particular)" in shown
    assert "MISSING" in shown


def test_the_cache_is_shown_and_cleared(tmp_path: Path) -> None:
    """In a process of its own, since the folder is looked up once."""
    env = {**os.environ, "PLANARC_CACHE_DIR": str(tmp_path / "kept")}

    def planarc(*arguments: str) -> str:
        command = [sys.executable, "-m", "planarc", *arguments]
        return subprocess.run(command, env=env, check=True, capture_output=True, text=True).stdout

    planarc("check", "decay.pmo")
    assert list((tmp_path / "kept" / "planarc").glob("*/*"))
    assert str(tmp_path / "kept") in planarc("cache")
    assert planarc("cache", "--clear").startswith("removed ")
    assert not list((tmp_path / "kept" / "planarc").glob("*/*"))


def test_a_cache_folder_of_another_program_is_told(tmp_path: Path) -> None:
    (tmp_path / "planarc").mkdir()
    (tmp_path / "planarc" / "notes").write_text("mine", "utf-8")
    env = {**os.environ, "PLANARC_CACHE_DIR": str(tmp_path)}
    for arguments in (["check", "decay.pmo"], ["cache", "--clear"]):
        command = [sys.executable, "-m", "planarc", *arguments]
        done = subprocess.run(command, env=env, capture_output=True, text=True)
        assert done.returncode == 0
        assert "warning[C131]: nothing is kept between runs" in done.stderr
        assert "holds files that planarc did not write" in done.stderr
    assert (tmp_path / "planarc" / "notes").read_text("utf-8") == "mine"


def test_what_new_writes_runs_and_is_formatted(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "Swing"]) == 0
    assert run(["fmt", "--check", "Swing.pmo"]) == 0
    assert run(["simulate", "Swing.pmo", "--no-report", "--no-output"]) == 0


def test_quiet_says_nothing_and_verbose_more(capsys: pytest.CaptureFixture[str]) -> None:
    said = []
    for option in ("--quiet", "--no-report", "--verbose"):
        assert run(["simulate", "decay.pmo", "--no-report", option]) == 0
        shown = capsys.readouterr()
        assert shown.err == ""
        said.append(len(shown.out.splitlines()))
    quiet, normal, verbose = said
    assert quiet == 0 < normal < verbose


def test_quiet_may_stand_before_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["-q", "simulate", "decay.pmo", "--no-report"]) == 0
    assert capsys.readouterr().out == ""


def test_the_shell_completes_commands() -> None:
    env = {
        **os.environ,
        "_PLANARC_COMPLETE": "complete_bash",
        "COMP_WORDS": "planarc si",
        "COMP_CWORD": "1",
    }
    command = [sys.executable, "-c", "from planarc.cli import main; main()"]
    done = subprocess.run(command, env=env, capture_output=True, text=True)
    assert done.stdout.split() == ["simulate"]


def test_what_was_promised_for_the_end_is_done() -> None:
    promise = "import atexit; atexit.register(print, 'done', end='')"
    program = f"{promise}; from planarc.cli import main; main()"
    command = [sys.executable, "-c", program, "check", "decay.pmo", "nothing.pmo"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout[-4:]) == (2, "done")


def test_a_folder_that_may_not_be_written_is_told_before_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if not hasattr(os, "geteuid") or os.geteuid() == 0:
        pytest.skip("nothing is forbidden to this user")
    (tmp_path / "locked").mkdir(mode=0o500)
    assert run(["simulate", "decay.pmo", "--output", "locked/x.csv", "--no-report"]) == 2
    assert "permission denied" in capsys.readouterr().err


def test_fmt_reads_standard_input(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import io

    monkeypatch.setattr(sys, "stdin", io.StringIO("model  M\nReal x=1;\nend M;\n"))
    assert run(["fmt", "-"]) == 0
    assert capsys.readouterr().out == "model M\n  Real x=1;\nend M;\n"


def test_fmt_goes_through_folders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "lib" / "sub").mkdir(parents=True)
    (tmp_path / "lib" / "sub" / "a.mo").write_text("model A\nReal x=1;\nend A;\n", "utf-8")
    (tmp_path / "lib" / ".hidden").mkdir()
    (tmp_path / "lib" / ".hidden" / "b.mo").write_text("model", "utf-8")
    assert run(["fmt", "--check", "lib"]) == 1
    assert run(["fmt", "lib"]) == 0
    assert run(["fmt", "--check", "lib"]) == 0
    assert (tmp_path / "lib/sub/a.mo").read_text("utf-8") == "model A\n  Real x=1;\nend A;\n"
