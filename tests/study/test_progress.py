"""The bar of a study: kept on a terminal and in a file, changing in a notebook."""

from __future__ import annotations

import builtins
import io
import sys
from types import ModuleType
from typing import Any

import pytest

import planarc
from planarc import Model
from planarc.core.progress import Progress

KS = [0.5, 1.0, 1.5]


def study(decay: Model) -> None:
    def metric(result: planarc.Result) -> float:
        if result.parameters["k"] == 1.0:
            raise ValueError
        return 1.0

    planarc.sweep(decay, {"k": KS}, metric, workers=1, progress=True)


def test_a_file_gets_the_last_state_alone(decay: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    written = io.StringIO()
    monkeypatch.setattr(sys, "stderr", written)
    study(decay)
    assert written.getvalue().count("3/3") == 1
    assert "1 failed" in written.getvalue()
    assert "\x1b" not in written.getvalue()


def test_a_notebook_needs_no_widgets(decay: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []

    class ZMQInteractiveShell:
        pass

    class Shown:
        def update(self, data: dict[str, str], raw: bool) -> None:
            assert raw
            shown.append(data["text/plain"])

    def display(data: dict[str, str], raw: bool, display_id: bool) -> Any:
        assert raw and display_id
        return Shown()

    module = ModuleType("IPython.display")
    module.display = display  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setattr(builtins, "get_ipython", ZMQInteractiveShell, raising=False)
    written = io.StringIO()
    monkeypatch.setattr(sys, "stderr", written)
    study(decay)
    assert "3/3" in shown[-1] and "1 failed" in shown[-1]
    with Progress() as passing:
        passing._due = 0.0
        passing.show("on the way")
        assert shown[-1] == "on the way"
    assert shown[-1] == ""
    assert written.getvalue() == ""
