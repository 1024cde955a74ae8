"""Pickles of data: records come back, anything that could run code is refused."""

from __future__ import annotations

import os
import pickle
import subprocess
from array import array
from pathlib import Path, PosixPath, WindowsPath
from typing import Any

import pytest

from planarc.core import plain
from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.core.source import Source, Span


def test_data_comes_back() -> None:
    span = Span(Source("m.pmo", "model M end M;"), 0, 5)
    told = Diagnostic("F210", "a", span, Severity.WARNING, "b", (Related("c"),))
    data: Any = {"a": [1, 2.5, None, b"x"], "b": (told, array("I", [1, 2]), Path("m.pmo"))}
    back = plain.loads(pickle.dumps(data, pickle.HIGHEST_PROTOCOL))
    assert back["a"] == data["a"]
    assert back["b"][0].message == "a"
    assert back["b"][0].severity is Severity.WARNING
    assert back["b"][0].span.text == "model"
    assert back["b"][1:] == data["b"][1:]


def test_paths_are_read_as_this_python_writes_them() -> None:
    """Compiled models hold them: a reader that refuses them compiles every model anew."""
    for kind in (PosixPath, WindowsPath):
        assert (kind.__module__, kind.__name__) in plain._OTHERS
    assert plain.loads(pickle.dumps(Path("a/m.pmo"))) == Path("a/m.pmo")


class Calls:
    """Something whose reading calls a function."""

    def __init__(self, function: Any, *arguments: Any) -> None:
        self.made = function, arguments

    def __reduce__(self) -> tuple[Any, ...]:
        return self.made


@pytest.mark.parametrize("function", [os.mkdir, eval, subprocess.Popen, Path.touch, getattr])
def test_nothing_is_called(function: Any, tmp_path: Path) -> None:
    data = pickle.dumps(Calls(function, str(tmp_path / "made")))
    with pytest.raises(pickle.UnpicklingError, match="is no data"):
        plain.loads(data)
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize(
    "named",
    [b"cplanarc.core.cache\nclear\n.", b"\x80\x04\x8c\x12planarc.core.cache\x8c\x09os.system\x93."],
)
def test_functions_of_ours_and_names_through_them_are_refused(named: bytes) -> None:
    with pytest.raises(pickle.UnpicklingError):
        plain.loads(named)
