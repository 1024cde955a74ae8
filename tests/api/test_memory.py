"""Remembered models: an entry that does not belong to what is there now is made again."""

from __future__ import annotations

import os
import pickle
from pathlib import Path
from typing import Any

import pytest

from planarc import compiler
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core import cache
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Backend, RunOptions
from planarc.request.request import Request

DECAY = """model Decay
  Real x(start=1, fixed=true);
equation
  der(x) = -{rate}*x;
end Decay;
"""
PART = """within Lib;
model Part
  Real x(start=1, fixed=true);
equation
  der(x) = -{rate}*x;
end Part;
"""
USER = "model User\n  Lib.Part part;\nend User;\n"


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Backend:
    if request.param is Backend.NATIVE:
        pytest.importorskip("llvmlite")
    return Backend(request.param)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "cache"
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(path))
    return path / "planarc"


def end(compiled: Compiled, name: str = "x") -> float:
    return float(compiler.run(compiled, RunOptions(stop=1.0, tolerance=1e-9))[name][-1])


def rewrite(path: Path, text: str) -> None:
    """Another content of the same length, and with the same time."""
    state = path.stat()
    assert len(text) == state.st_size
    path.write_text(text, encoding="utf-8")
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))


def test_a_changed_model_is_compiled_again(tmp_path: Path, backend: Backend) -> None:
    file = tmp_path / "decay.mo"
    file.write_text(DECAY.format(rate=1), encoding="utf-8")
    assert not compile_model(Request(file), backend).remembered
    assert compile_model(Request(file), backend).remembered
    rewrite(file, DECAY.format(rate=2))
    changed = compile_model(Request(file), backend)
    assert not changed.remembered
    assert end(changed) == pytest.approx(0.1353352832, abs=1e-7)  # exp(-2)
    assert end(compile_model(Request(file), backend)) == end(changed)
    rewrite(file, DECAY.format(rate=1))
    assert end(compile_model(Request(file), backend)) == pytest.approx(0.3678794412, abs=1e-7)


def test_a_changed_library_is_compiled_again(tmp_path: Path, backend: Backend) -> None:
    library = tmp_path / "root" / "Lib"
    library.mkdir(parents=True)
    (library / "package.mo").write_text("package Lib\nend Lib;\n", encoding="utf-8")
    part, user = library / "Part.mo", tmp_path / "User.mo"
    part.write_text(PART.format(rate=1), encoding="utf-8")
    user.write_text(USER, encoding="utf-8")
    request = Request(user, libraries=(tmp_path / "root",))
    compile_model(request, backend)
    assert compile_model(request, backend).remembered
    rewrite(part, PART.format(rate=2))
    changed = compile_model(request, backend)
    assert not changed.remembered
    assert end(changed, "part.x") == pytest.approx(0.1353352832, abs=1e-7)
    part.unlink()
    with pytest.raises(PlanarcError):
        compile_model(request, backend)


def test_a_class_that_hides_another_is_seen(tmp_path: Path, backend: Backend) -> None:
    """Added to a package in which the name was looked for in vain."""
    inner = tmp_path / "Lib" / "Inner"
    inner.mkdir(parents=True)
    (tmp_path / "Lib" / "package.mo").write_text("package Lib\nend Lib;\n", "utf-8")
    (tmp_path / "Lib" / "Part.mo").write_text(PART.format(rate=1), "utf-8")
    (inner / "package.mo").write_text("within Lib;\npackage Inner\nend Inner;\n", "utf-8")
    user = "within Lib.Inner;\nmodel User\n  Part part;\nend User;\n"
    (inner / "User.mo").write_text(user, "utf-8")
    request = Request(None, "Lib.Inner.User", (tmp_path,))
    assert end(compile_model(request, backend), "part.x") == pytest.approx(0.36787944, abs=1e-6)
    (inner / "notes.txt").write_text("no class", "utf-8")
    assert compile_model(request, backend).remembered
    hiding = PART.format(rate=2).replace("within Lib;", "within Lib.Inner;")
    (inner / "Part.mo").write_text(hiding, "utf-8")
    changed = compile_model(request, backend)
    assert not changed.remembered
    assert end(changed, "part.x") == pytest.approx(0.13533528, abs=1e-6)
    assert compile_model(request, backend).remembered


ASKING = """model Asking
  function kind
    input String name;
    output Integer result;
    external "C" result = ModelicaInternal_stat(name);
  end kind;
  {asked}
end Asking;
"""
#: While classes are flattened, and while equations are made: such a model is not remembered.
ASKED = {
    'Real v[kind("data.txt")] = fill(1, size(v, 1)); Real x = sum(v);': True,
    'parameter Integer k = kind("data.txt"); Real x = k;': False,
}


@pytest.mark.parametrize(("asked", "kept"), ASKED.items())
def test_files_that_a_model_asks_for_are_looked_for_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, backend: Backend, asked: str, kept: bool
) -> None:
    request = Request(text=ASKING.replace("{asked}", asked))

    def kind() -> tuple[bool, float]:
        compiled = compile_model(request, backend)
        return compiled.remembered, end(compiled)

    for place in ("here", "there"):
        (tmp_path / place).mkdir()
    (tmp_path / "there" / "data.txt").write_text("", "utf-8")
    monkeypatch.chdir(tmp_path / "here")
    assert [kind(), kind()] == [(False, 1), (kept, 1)]
    monkeypatch.chdir(tmp_path / "there")
    assert [kind(), kind()] == [(False, 2), (kept, 2)]
    (tmp_path / "there" / "data.txt").unlink()
    assert kind() == (False, 1)


def test_another_version_compiles_again(monkeypatch: pytest.MonkeyPatch, backend: Backend) -> None:
    request = Request(text=DECAY.format(rate=1))
    compile_model(request, backend)
    assert compile_model(request, backend).remembered
    with monkeypatch.context() as other:
        other.setattr(cache, "_versions", lambda: ("another planarc", "", ""))
        assert not compile_model(request, backend).remembered
        assert compile_model(request, backend).remembered
    assert compile_model(request, backend).remembered


def test_code_of_another_processor_is_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("llvmlite")
    from planarc.codegen.native import processor

    request = Request(text=DECAY.format(rate=1))
    compile_model(request, Backend.NATIVE)
    assert compile_model(request, Backend.NATIVE).remembered
    monkeypatch.setattr(processor, "key", lambda: "another processor")
    assert not compile_model(request, Backend.NATIVE).remembered


@pytest.mark.parametrize(
    "entry",
    [
        (),
        ([],),
        ([], b"an older layout", "", ()),
        ([("no such file", "key")], b"", "", ()),
        "no tuple",
    ],
)
def test_an_entry_of_another_layout_is_made_again(
    folder: Path, backend: Backend, entry: Any
) -> None:
    """Whole, but not what this planarc would have written."""
    request = Request(text=DECAY.format(rate=1))
    compile_model(request, backend)
    (path,) = (folder / "models").iterdir()
    cache.store("models", path.name, pickle.dumps(entry))
    again = compile_model(request, backend)
    assert not again.remembered
    assert end(again) == pytest.approx(0.3678794412, abs=1e-7)
    assert compile_model(request, backend).remembered
