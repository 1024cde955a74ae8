"""Compiled modules are kept in the cache, but only where Python keeps none itself."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

#: What was compiled, apart from what was imported before bytecode was looked for.
PROGRAM = """
import importlib.machinery as machinery, sys
compiled = []
real = machinery.SourceFileLoader.source_to_code
def spy(self, data, path, **more):
    compiled.append(path)
    return real(self, data, path, **more)
from planarc.core.bytecode import keep_bytecode
keep_bytecode()
machinery.SourceFileLoader.source_to_code = spy
import planarc.ir.syntax
assert planarc.ir.syntax.Integer.__module__ == "planarc.ir.syntax"
print([c for c in compiled if "planarc" in c] and "compiled")
"""


def run(folder: Path, **more: str) -> str:
    environment = {**os.environ, "PLANARC_CACHE_DIR": str(folder / "cache"), **more}
    environment["PYTHONPYCACHEPREFIX"] = str(folder / "python")
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return done.stdout.strip()


def test_modules_are_compiled_once(tmp_path: Path) -> None:
    first, second = (run(tmp_path, PYTHONDONTWRITEBYTECODE="1") for _ in range(2))
    assert (first, second) == ("compiled", "[]")
    assert len(list((tmp_path / "cache" / "bytecode").iterdir())) == 1


def test_what_python_keeps_is_not_kept_twice(tmp_path: Path) -> None:
    assert run(tmp_path, PYTHONDONTWRITEBYTECODE="") == "compiled"
    assert run(tmp_path, PYTHONDONTWRITEBYTECODE="") == "[]"
    assert not (tmp_path / "cache" / "bytecode").exists()


@pytest.mark.parametrize("damage", [b"", b"no bytecode"])
def test_a_damaged_entry_is_made_anew(tmp_path: Path, damage: bytes) -> None:
    run(tmp_path, PYTHONDONTWRITEBYTECODE="1")
    (entry,) = (tmp_path / "cache" / "bytecode").iterdir()
    entry.write_bytes(damage)
    assert run(tmp_path, PYTHONDONTWRITEBYTECODE="1") == "compiled"
    assert run(tmp_path, PYTHONDONTWRITEBYTECODE="1") == "[]"
