"""Shared libraries for all platforms: read by others, and run where that is possible here."""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import cache
from hashlib import sha256
from pathlib import Path

import lief
import pytest

from planarc.codegen.native.assembly import INT, POINTER, REAL, Value
from planarc.codegen.native.formulas import declarations
from planarc.compiler import compile_model, run
from planarc.core.options import RunOptions
from planarc.export.fmi.three import functions
from planarc.export.fmu import PLATFORMS, make_library
from planarc.export.image import take_image
from planarc.export.module import write_whole
from planarc.export.objects import compile_for
from planarc.request.request import Request

COMPILED = cache(
    lambda: compile_model(Request(Path(__file__).parents[2] / "examples" / "four_bar.pmo"))
)
WINE = shutil.which("wine")


@cache
def library(platform: str) -> tuple[bytes, tuple[str, ...]]:
    program, kind = COMPILED().program, PLATFORMS[platform]
    entries = functions()
    code = compile_for(
        write_whole(program, take_image(COMPILED()), entries, "x", 1e-8), kind.triple
    )
    data = make_library(kind, code, f"FourBar.{kind.ending}", entries.names)
    return data, tuple(entries.names)


@pytest.mark.parametrize("platform", PLATFORMS)
def test_others_read_what_was_written(platform: str) -> None:
    data, public = library(platform)
    found = lief.parse(list(data))
    underscore = "_" if platform.endswith("darwin") else ""
    names = {f.name for f in found.exported_functions}
    assert names == {underscore + name for name in public}
    imported = {f.name.removeprefix(underscore) for f in found.imported_functions}
    assert {"calloc", "free", "pow"} <= imported
    assert not any(name.startswith(("px_", "pc_", "fmi")) for name in imported)
    own = {"linux": {"sincos"}, "darwin": {"__sincos"}}.get(platform.split("-")[1], set())
    known = re.findall(r"declare double @(\w+)\(", declarations())
    assert own <= imported <= {"calloc", "free", *known, *own}


@pytest.mark.parametrize("platform", [p for p in PLATFORMS if p.endswith("darwin")])
def test_layout_and_signature_for_macos(platform: str) -> None:
    data, _ = library(platform)
    found = lief.parse(list(data))
    assert lief.MachO.check_layout(found) == (True, "")
    if platform.startswith("x86_64"):  # which runs what is unsigned
        assert not found.has_code_signature
        return
    signature = found.code_signature
    at, size = signature.data_offset, signature.data_size
    assert at + size == len(data)
    blob = data[at:]
    directory = blob[int.from_bytes(blob[16:20], "big") :]
    first, count, limit = (int.from_bytes(directory[i : i + 4], "big") for i in (16, 28, 32))
    assert limit == at and count == -(-at // 4096)
    for page in range(count):
        hashed = directory[first + 32 * page :][:32]
        assert hashed == sha256(data[page * 4096 : min(at, page * 4096 + 4096)]).digest()


def test_layout_for_windows() -> None:
    assert lief.PE.check_layout(lief.parse(list(library("x86_64-windows")[0]))) == (True, "")


@pytest.mark.skipif(WINE is None, reason="there is no wine here")
def test_windows_runs_it(tmp_path: Path) -> None:
    """A function beside those of the interface drives the model with another crank, and ends the
    process with a number that says how far it came."""
    program, kind = COMPILED().program, PLATFORMS["x86_64-windows"]
    column = next(c for c in program.columns if c.name == "revC.w")
    crank = next(p for p in program.parameter_slots if p.name == "crank.r[1]")
    options = RunOptions(stop=1.0, tolerance=1e-11, values={crank.name: 0.3})
    wanted = run(COMPILED(), options)["revC.w"][-1]
    entries = functions()
    with entries.plain("drive", "ptr a, ptr b, ptr c, i32 d", "void") as (c, _):
        null, no = Value(c, POINTER, "null"), Value(c, "i8", "0")
        zero, none, one = c.constant(0.0, REAL), c.constant(0, INT), c.constant(1, INT)
        room, reference = c.place(REAL, 8), c.place(INT)
        token = Value(c, POINTER, "@px_token")
        m = c.call(POINTER, "fmi3InstantiateCoSimulation", null, token, null, no, no, no, no, null,
                   none, null, null, null)  # fmt: skip
        flags = [room.at(i) for i in range(1, 5)]
        reference.store(c.constant(8 * crank.slot, INT))
        room.store(0.3)
        calls = [
            lambda: ("SetFloat64", m, reference, one, room, one),
            lambda: ("EnterInitializationMode", m, no, zero, zero, no, zero),
            lambda: ("ExitInitializationMode", m),
            lambda: ("DoStep", m, zero, c.constant(1.0, REAL), no, *flags),
        ]
        for i, call in enumerate(calls):
            name, *given = call()
            status = c.call("i32", f"fmi3{name}", *given)
            with c.when(~status.equals(0)):
                c.run("exit", c.constant(10 + i, "i32"))
        reference.store(c.constant(8 * column.slot + (column.sign < 0), INT))
        c.call("i32", "fmi3GetFloat64", m, reference, one, room, one)
        near = c.absolute(room.load(REAL) - float(wanted)) < 1e-6
        with c.when(near):
            c.run("exit", c.constant(42, "i32"))
        c.run("exit", c.constant(7, "i32"))
        c.give()
    entries.also("declare void @exit(i32)\n")
    code = compile_for(
        write_whole(program, take_image(COMPILED()), entries, "x", 1e-8), kind.triple
    )
    (tmp_path / "a.dll").write_bytes(make_library(kind, code, "a.dll", entries.names))
    own = {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "PATH": "/usr/bin:/bin",
           "WINEDLLOVERRIDES": "mscoree,mshtml=", "HOME": str(tmp_path)}  # fmt: skip
    done = subprocess.run(
        [str(WINE), "rundll32.exe", "a.dll,drive"], cwd=tmp_path, env=own, timeout=120
    )
    assert done.returncode == 42
