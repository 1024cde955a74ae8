"""The line of progress is for terminals, and only for runs that take long."""

from __future__ import annotations

import io
import sys

import pytest

from planarc.cli import console, progress
from planarc.core import progress as drawn


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def use_terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    found = Terminal()
    monkeypatch.setattr(sys, "stderr", found)
    monkeypatch.setenv("TERM", "xterm")
    return found


def test_there_is_none_without_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress.progress_line() as line:
        assert line is None


def test_there_is_none_where_nothing_is_to_be_said(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = use_terminal(monkeypatch)
    monkeypatch.setattr(console, "_volume", console.Volume.QUIET)
    with progress.progress_line() as line, progress.counting_line() as count:
        assert line is None and count is None
    assert terminal.getvalue() == ""


def test_a_short_run_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = use_terminal(monkeypatch)
    monkeypatch.setattr(drawn, "monotonic", lambda: 0.0)
    with progress.progress_line() as line:
        assert line is not None
        line(0.5)
    assert terminal.getvalue() == ""


def test_a_long_run_says_where_it_is_and_cleans_up(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = use_terminal(monkeypatch)
    times = iter([0.0, drawn.PATIENCE, drawn.PATIENCE + drawn.PERIOD / 2])
    monkeypatch.setattr(drawn, "monotonic", times.__next__)
    with progress.progress_line() as line:
        assert line is not None
        line(12.5)
        line(12.6)  # too soon after the first
    shown = terminal.getvalue()
    assert "t = 12.5 s" in shown
    assert "12.6" not in shown
    assert shown.endswith("\x1b[2K")  # the line is empty again


def test_many_classes_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = use_terminal(monkeypatch)
    monkeypatch.setattr(drawn, "PATIENCE", 0.0)
    with progress.counting_line() as count:
        assert count is not None
        count(3, 10, "Ship.Mast")
    shown = terminal.getvalue()
    assert " 3/10" in shown
    assert "classes, Ship.Mast" in shown
    assert shown.endswith("\x1b[2K")
