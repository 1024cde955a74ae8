"""The line of progress is for terminals, and only for runs that take long."""

from __future__ import annotations

import io
import sys

import pytest

from planarc.cli import progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_there_is_none_without_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with progress.progress_line() as line:
        assert line is None


def test_a_short_run_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with progress.progress_line() as line:
        assert line is not None
        line(0.5)
    assert terminal.getvalue() == ""


def test_a_long_run_says_where_it_is_and_cleans_up(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    with progress.progress_line() as line:
        assert line is not None
        line(12.5)
        line(12.6)  # too soon after the first
    shown = terminal.getvalue()
    assert "t = 12.5 s" in shown
    assert "12.6" not in shown
    assert shown.endswith("\r\x1b[K")


def test_many_classes_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    with progress.counting_line() as count:
        assert count is not None
        count(3, 10, "Ship.Mast")
    assert terminal.getvalue() == "\r\x1b[K3 of 10 classes, Ship.Mast\r\x1b[K"
