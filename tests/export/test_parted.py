"""Shared code in two parts, of which the inner one is the same on Windows as on Linux."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import llvmlite.binding as llvm
import pytest

from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core import processes
from planarc.export import objects
from planarc.export.emission import finished, shared_text
from planarc.export.fmu import make_fmu
from planarc.export.parted import divide
from planarc.export.wishes import Wishes
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES

TEXT = """
declare ptr @calloc(i64, i64)
@px_both = constant [2 x i8] c"a\\00"
@px_inside = constant [1 x i64] [i64 3]
@px_plan = external constant [0 x i64]
; Told to the host.
define void @px_log(ptr %m, i32 %status) nounwind {
  %f = load ptr, ptr %m
  call void %f(ptr @px_both)
  ret void
}
define double @px_step(ptr %m, double %t) nounwind {
  call void @px_log(ptr @px_both, i32 3)
  %a = load double, ptr @px_inside
  %b = load double, ptr @px_plan
  %c = fadd double %a, %b
  ret double %c
}
define i32 @fmi3DoStep(ptr %m) {
  %a = call double @px_step(ptr %m, double 0.0)
  ret i32 0
}
"""


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(EXAMPLES / f"{name}.pmo"))


def defined(text: str) -> set[str]:
    return set(re.findall(r"^(?:define [^@]*)?@(\w+)(?:\(| = constant)", text, re.MULTILINE))


def test_each_part_declares_what_the_other_one_has() -> None:
    inner, outer = divide(TEXT)
    assert defined(inner) == {"px_step", "px_inside"}
    assert defined(outer) == {"px_log", "fmi3DoStep", "px_both"}
    assert "declare void @px_log(ptr, i32)" in inner.splitlines()
    assert "@px_both = external constant [2 x i8]" in inner.splitlines()
    assert "declare double @px_step(ptr, double)" in outer.splitlines()
    for text in (inner, outer):
        llvm.parse_assembly(text).verify()


def test_windows_and_linux_share_what_is_inside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path))  # nothing is known
    monkeypatch.setattr(processes, "cores", lambda: 1)  # another one notes for itself
    made: list[tuple[str, str]] = []

    def noted(text: str, triple: str, small: bool) -> bytes:
        system = triple.split("-")[2]
        made.extend((system, name) for name in re.findall(r"^define [^@]*@(\w+)\(", text, re.M))
        return finished(text, triple, small)

    monkeypatch.setattr(objects, "finished", noted)
    platforms = ("x86_64-linux", "x86_64-windows", "x86_64-darwin")
    make_fmu(compiled("pendulum"), Wishes(platforms=platforms))
    assert [system for system, name in made if name == "px_step"] == ["linux"]
    assert sorted(system for system, name in made if name == "fmi3DoStep") == ["linux", "windows"]
    assert len(made) == len(set(made))


def test_shared_texts_pass_through_the_optimiser_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(processes, "cores", lambda: 1)
    texts: list[set[str]] = []

    def noted(text: str, called: set[str]) -> str:
        texts.append(defined(text))
        return shared_text(text, called)

    monkeypatch.setattr(objects, "shared_text", noted)
    make_fmu(compiled("pendulum"), Wishes())
    assert sum("px_step" in names for names in texts) == 1
    assert sum("fmi3DoStep" in names for names in texts) == 2  # as called on Windows, and elsewhere


def test_what_calls_the_host_calls_it_as_the_system_does() -> None:
    inner, outer = divide(TEXT)
    assert "call void %f" not in inner and "call void %f" in outer
