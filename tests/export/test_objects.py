"""The objects of exported models: made once for all systems that share them, and of small code."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from functools import cache
from types import ModuleType

import llvmlite.binding as llvm
import pytest

from planarc.codegen.native import options
from planarc.codegen.native.machine import emit_object
from planarc.codegen.native.runtime import runtime_text
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core import processes
from planarc.export import emission
from planarc.export.fmi import three, two
from planarc.export.fmu import make_fmu
from planarc.export.wishes import Wishes
from planarc.request.request import Request
from planarc.runtime.link.objects import Object, read_object
from tests.export.fmus import EXAMPLES


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(EXAMPLES / f"{name}.pmo"))


def test_systems_that_call_alike_share_objects(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []

    def counted(text: str, machine: llvm.TargetMachine, *more: object) -> bytes:
        if "define i32 @pc_slopes_all" in text:
            made.append(machine.triple)
        return emit_object(text, machine, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(emission, "emit_object", counted)
    monkeypatch.setattr(processes, "cores", lambda: 1)  # another one counts for itself
    make_fmu(compiled("pendulum"), Wishes())
    assert sorted(made) == ["aarch64-unknown-linux-gnu", "x86_64-unknown-linux-gnu"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="nothing is made beside there")
def test_what_a_process_makes_beside_this_one_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    here = os.getpid()
    made: list[int] = []

    def counted(text: str, machine: llvm.TargetMachine, *more: object) -> bytes:
        made.append(os.getpid())
        return emit_object(text, machine, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(emission, "emit_object", counted)
    monkeypatch.setattr(processes, "cores", lambda: 1)
    alone = make_fmu(compiled("pendulum"), Wishes()).data
    count = len(made)
    monkeypatch.setattr(processes, "cores", lambda: 2)
    monkeypatch.setattr(processes, "active_count", lambda: 1)
    assert make_fmu(compiled("pendulum"), Wishes()).data == alone
    assert set(made) == {here}
    assert len(made) < 2 * count, "the other process has made some"


@pytest.mark.parametrize("version", (two, three))
def test_what_arm_gets_on_the_stack_has_eight_bytes(version: ModuleType) -> None:
    """Linux gives each argument eight bytes there, macOS as many as it has."""
    entries = version.functions()
    found = re.findall(r"^define \w+ @(fmi\w+)\((.*?)\)", entries.text(), re.MULTILINE)
    assert {name for name, _ in found} == set(entries.names)
    for name, listed in found:
        whole = [a.split()[0] for a in listed.split(", ") if a and not a.startswith("double")]
        assert set(whole[8:]) <= {"i64", "ptr"}, name
    assert version is two or any(a.count(",") > 8 for _, a in found)


def emitted(thrifty: bool) -> Object:
    triple = "aarch64-unknown-linux-gnu"
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    arm = llvm.Target.from_triple(triple).create_target_machine(opt=1, reloc="pic")
    with options.options(*(emission._OPTIONS if thrifty else ())):
        return read_object(emit_object(runtime_text(), arm, ()))


def test_other_code_of_the_process_is_made_as_before() -> None:
    before = emitted(False)
    assert emitted(True) != before == emitted(False)
    emission.finished(runtime_text(), "x86_64-unknown-linux-gnu", small=True)
    assert emitted(False) == before


#: LLVM keeps one of the options that an export sets: what it is without one shows in a new process.
QUICKLY = """
from planarc.codegen.native import machine
from planarc.codegen.native.runtime import runtime_text
from planarc.export import emission
before = machine._compiled(runtime_text(), 0)
emission.finished(runtime_text(), "x86_64-unknown-linux-gnu", small=True)
print(machine._compiled(runtime_text(), 0) == before)
"""


def test_what_a_run_makes_in_the_quickest_way_is_made_as_before() -> None:
    done = subprocess.run([sys.executable, "-c", QUICKLY], capture_output=True, text=True)
    assert done.stdout == "True\n", done.stderr
