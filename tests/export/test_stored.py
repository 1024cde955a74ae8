"""Numbers of large models in a file: found by any way to tell its folder, and refused elsewhere."""

from __future__ import annotations

import ctypes
import platform
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import fmpy
import pytest

from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.export.fmu import make_fmu
from planarc.export.wishes import Wishes
from planarc.instance.stored import FILE
from planarc.request.request import Request
from tests.export.fmus import EXAMPLES, HERE, WAYS, runs_here, written

LARGE = "cam_lift_off"


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(EXAMPLES / f"{name}.pmo"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("stored")


def archive(folder: Path, version: int) -> Path:
    if version == 2 and platform.machine() != "x86_64":
        pytest.skip("not of FMI 2")
    return written(folder / f"{LARGE}{version}.fmu", compiled(LARGE), version)


class Library:
    """That of an unpacked archive, which makes instances."""

    def __init__(self, path: Path, unpacked: Path, version: int) -> None:
        fmpy.extract(path, unpacked)
        own = "linux64" if version == 2 else f"{platform.machine()}-linux"
        self.lib = ctypes.CDLL(str(next((unpacked / "binaries" / own).glob("*.so"))))
        self.token = fmpy.read_model_description(path).guid.encode()
        self.version, self.told = version, list[bytes]()
        log3 = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, *(ctypes.c_char_p,) * 2)
        log2 = ctypes.CFUNCTYPE(None, *(ctypes.c_char_p,) * 2, ctypes.c_int,
                                *(ctypes.c_char_p,) * 2)  # fmt: skip
        self._log = (log2 if version == 2 else log3)(lambda *given: self.told.append(given[-1]))
        self._host = (ctypes.c_void_p * 5)(ctypes.cast(self._log, ctypes.c_void_p))

    @contextmanager
    def made(self, resources: bytes | None) -> Iterator[int | None]:
        if self.version == 2:
            make = self.lib.fmi2Instantiate
            given: tuple[object, ...] = (b"x", 1, self.token, resources, self._host, 0, 0)
        else:
            make, no = self.lib.fmi3InstantiateModelExchange, ctypes.c_bool(False)
            given = (b"x", self.token, resources, no, no, None, self._log)
        make.restype = ctypes.c_void_p
        found = make(*given)
        yield found
        if found is not None:
            getattr(self.lib, f"fmi{self.version}FreeInstance")(ctypes.c_void_p(found))


@runs_here
@pytest.mark.parametrize("end", ("", "/"))
def test_a_path_with_any_letters_leads_there(folder: Path, tmp_path: Path, end: str) -> None:
    unpacked = tmp_path / "ä 100%41 b"
    library = Library(archive(folder, 3), unpacked, 3)
    with library.made(f"{unpacked}/resources{end}".encode()) as found:
        assert found is not None
    assert not library.told


@runs_here
@pytest.mark.parametrize("scheme", ("file://", "file:", ""))
def test_a_uri_leads_there(folder: Path, tmp_path: Path, scheme: str) -> None:
    unpacked = tmp_path / "ä 100% b"
    library = Library(archive(folder, 2), unpacked, 2)
    quoted = (unpacked / "resources").as_uri().removeprefix("file://")
    assert "%C3%A4%20100%25" in quoted
    for way in (quoted, quoted.replace("%C3%A4", "%c3%a4") + "/"):
        with library.made(f"{scheme}{way}".encode()) as found:
            assert found is not None


@runs_here
@pytest.mark.parametrize("version", (2, 3))
def test_what_is_no_file_of_the_model_is_told(folder: Path, tmp_path: Path, version: int) -> None:
    library = Library(archive(folder, version), tmp_path, version)
    there = tmp_path / "resources"
    known = (there / FILE).read_bytes()
    scheme = "file://" if version == 2 else ""
    for content in (known[:-8], bytes([known[0] ^ 1]) + known[1:], b""):
        (there / FILE).write_bytes(content)
        with library.made(f"{scheme}{there}/".encode()) as found:
            assert found is None
    for place in (None, b"", b"/", f"{scheme}{tmp_path}/nowhere".encode(), b"file:", b"%"):
        with library.made(place) as found:
            assert found is None
    assert len(library.told) == 9
    assert all(text.startswith(b"resources/numbers.bin of this FMU cannot be read: unpack")
               for text in library.told)  # fmt: skip
    (there / FILE).write_bytes(known)
    with library.made(f"{scheme}{there}".encode()) as found:
        assert found is not None


@runs_here
def test_a_model_runs_the_same_with_its_numbers_in_a_file(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the last bit."""
    apart = archive(folder, 3)
    monkeypatch.setattr("planarc.export.module._MANY", 1 << 40)
    inside = written(tmp_path / "inside.fmu", compiled(LARGE), 3)
    assert f"resources/{FILE}" in zipfile.ZipFile(apart).namelist()
    assert f"resources/{FILE}" not in zipfile.ZipFile(inside).namelist()
    for way in WAYS:
        rows = [fmpy.simulate_fmu(path, fmi_type=way, stop_time=2.0) for path in (apart, inside)]
        assert rows[0].tobytes() == rows[1].tobytes()


@pytest.mark.parametrize(("name", "apart"), [("four_bar", False), (LARGE, True)])
def test_small_models_need_no_file(name: str, apart: bool) -> None:
    platforms = (f"{platform.machine()}-linux",) if HERE else ("x86_64-linux",)
    for source in (False, True):  # a source FMU holds all in its sources
        made = make_fmu(compiled(name), Wishes(3, platforms=platforms, source=source))
        assert (f"resources/{FILE}".encode() in made.data) == (apart and not source)
