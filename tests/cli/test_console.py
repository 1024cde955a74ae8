"""Text for pipes is plain; text for terminals has colours and the same words."""

from __future__ import annotations

import io
import re
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import pytest

from planarc.cli import console
from planarc.cli.app import run
from planarc.core.diagnostic import Diagnostic

PROBLEM = Diagnostic("C999", "something is `wrong` \x1b[31mhere", hint="do better")
ROWS = (("model", "Pendulum: a rod"), ("written", "Pendulum.csv\nPendulum.html"))


class Terminal(io.StringIO):
    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def terminal_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.setenv("COLUMNS", "100")


def test_a_diagnostic_for_a_pipe_is_plain(capsys: pytest.CaptureFixture[str]) -> None:
    console.complain((PROBLEM,))
    assert "\x1b" not in capsys.readouterr().err


def test_a_diagnostic_for_a_terminal_is_the_same_in_colour() -> None:
    with redirect_stderr(Terminal()) as terminal:
        console.complain((PROBLEM,))
    shown = terminal.getvalue()
    assert "\x1b[1;31m" in shown
    words = re.sub(r"\x1b\[[\d;]*m", "", shown)
    assert words == "error[C999]: something is `wrong` ·[31mhere\n  hint: do better\n"


def test_nothing_is_said_of_no_diagnostics(capsys: pytest.CaptureFixture[str]) -> None:
    console.complain(())
    assert capsys.readouterr().err == ""


def test_rows_stand_below_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    console.say_rows(ROWS)
    assert capsys.readouterr().out == (
        "model    Pendulum: a rod\nwritten  Pendulum.csv\n         Pendulum.html\n"
    )


def test_rows_on_a_terminal_have_the_same_words() -> None:
    with redirect_stdout(Terminal()) as terminal:
        console.say_rows(ROWS)
    words = re.sub(r"\x1b\[[\d;]*m", "", terminal.getvalue())
    assert [line.rstrip() for line in words.splitlines()] == [
        "model    Pendulum: a rod",
        "written  Pendulum.csv",
        "         Pendulum.html",
    ]


def test_texts_of_a_model_stay_on_their_line_and_cannot_steer_the_terminal() -> None:
    assert console.plain("a\nb\t c\x1b[2J\u202e") == "a b c·[2J·"


def test_names_cannot_steer_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    console.say("'a\x1b[2Jb'\t= 1\nsecond \u202e line\n")
    assert capsys.readouterr().out == "'a·[2Jb'\t= 1\nsecond · line\n"


@pytest.mark.parametrize("command", ["flatten", "equations", "linearize", "list"])
def test_no_command_prints_what_steers_the_terminal(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = "model M Real 'a\x1b[2J'(start=1, fixed=true); equation der('a\x1b[2J') = -1; end M;"
    path = tmp_path / "m.pmo"
    path.write_text(model, "utf-8")
    assert run([command, str(path)]) == 0
    assert "\x1b" not in capsys.readouterr().out
