"""FMUs with sources: what a C compiler makes of them runs as the library that planarc wrote."""

from __future__ import annotations

import platform
import re
import shutil
import subprocess
import zipfile
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as Xml

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import planarc
from tests.export.fmus import EXAMPLES, HERE, WAYS, simulate
from tests.export.test_c import COMPILER, SAMPLED, needs_compiler
from tests.export.test_description import TURNING
from tests.export.test_events import BALL, STICK_SLIP

BOTH = (2, 3)
PEDANTIC = ("-std=c99", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror")
runs_here = pytest.mark.skipif(
    not HERE or platform.machine() != "x86_64", reason="no library of both versions"
)


def exported(folder: Path, text: str, version: int, **options: object) -> Path:
    model = planarc.load(text)
    path = folder / f"{version}.fmu"
    return model.export_fmu(path, fmi=version, source=True, platforms=["x86_64-linux"], **options)


def listed(folder: Path, version: int) -> list[list[str]]:
    """The files that an unpacked FMU asks a compiler for, each time that it does."""
    if version == 2:
        told = Xml.parse(folder / "modelDescription.xml").iter("SourceFiles")
    else:
        told = Xml.parse(folder / "sources" / "buildDescription.xml").iter("SourceFileSet")
    return [[str(file.get("name")) for file in files] for files in told]


def compiled_again(path: Path, version: int, options: Sequence[str] = PEDANTIC) -> Path:
    """An FMU whose library is the one that a compiler makes of its sources."""
    folder = path.with_suffix("")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    (library,) = (folder / "binaries").rglob("*.so")
    library.unlink()
    sources = [folder / "sources" / name for name in listed(folder, version)[0]]
    assert COMPILER is not None
    told = subprocess.run(
        [COMPILER, *options, "-shared", "-fPIC", *sources, "-lm", "-o", library],
        capture_output=True, text=True,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr
    made = path.with_name(f"{path.stem}_again.fmu")
    shutil.make_archive(str(made), "zip", folder)
    made.with_name(f"{made.name}.zip").rename(made)
    return made


@needs_compiler
@runs_here
@pytest.mark.parametrize("version", BOTH)
@pytest.mark.parametrize(
    "text", ("crank_slider", "cam_lift_off", BALL, STICK_SLIP, SAMPLED, TURNING)
)
def test_a_compiler_makes_the_same_fmu(tmp_path: Path, text: str, version: int) -> None:
    source = text if "\n" in text else str(EXAMPLES / f"{text}.pmo")
    own = exported(tmp_path, source, version)
    again = compiled_again(own, version)
    assert validate_fmu(str(own)) == [] and validate_fmu(str(again)) == []
    for way in WAYS:
        one, other = (simulate(path, way, 1.0) for path in (own, again))
        assert one.dtype.names == other.dtype.names and len(one) == len(other) > 100
        for name in one.dtype.names:
            mine, its = one[name].astype(float), other[name].astype(float)
            assert np.abs(mine - its).max() <= 1e-9 * max(np.ptp(mine), 1e-9), (way, name)


@needs_compiler
@runs_here
@pytest.mark.parametrize("version", BOTH)
def test_a_message_comes_through_the_logger(tmp_path: Path, version: int) -> None:
    """FMI 2.0's logger takes a format and any number of arguments."""
    text = """
    model Late
      output Real x(start=0, fixed=true);
    equation
      der(x) = 1;
      assert(x < 0.5, "too \\"late\\"??/ 100 %d");
    end Late;
    """
    again = compiled_again(exported(tmp_path, text, version), version)
    told: list[str] = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(again, "CoSimulation", 1.0, logger=lambda *given: told.append(given[-1].decode()))
    assert 'too "late"??/ 100 %d' in told[0]


@needs_compiler
@runs_here
@pytest.mark.parametrize("version", BOTH)
def test_names_have_a_prefix(tmp_path: Path, version: int) -> None:
    prefixed = (*PEDANTIC, f"-DFMI{version}_FUNCTION_PREFIX=Fly_")
    path = exported(tmp_path, str(EXAMPLES / "pendulum.pmo"), version)
    compiled_again(path, version, prefixed)
    (library,) = (path.with_suffix("") / "binaries").rglob("*.so")
    names = re.findall(rb"(?<=\0)\w*(?:fmi[23][A-Z]|px_|pc_)\w*(?=\0)", library.read_bytes())
    assert {f"Fly_fmi{version}DoStep".encode(), b"Fly_px_plan"} < {*names}
    assert [n for n in names if not n.startswith(b"Fly_")] == []


@pytest.mark.parametrize("version", BOTH)
def test_sources_are_told_and_are_there(tmp_path: Path, version: int) -> None:
    path = exported(tmp_path, str(EXAMPLES / "pendulum.pmo"), version)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "made")
    told = listed(tmp_path / "made", version)
    assert told == [["model.c", "runtime.c"]] * (2 if version == 2 else 1)
    if version == 3:
        (build,) = fmpy.read_model_description(str(path)).buildConfigurations
        assert build.modelIdentifier == "Pendulum"
        assert build.sourceFileSets[0].sourceFiles == told[0]
    there = {p.name for p in (tmp_path / "made" / "sources").iterdir()}
    assert there == {*told[0], "model.h", "runtime.h"} | (
        {"buildDescription.xml"} if version == 3 else set()
    )


def test_without_the_wish_there_are_no_sources(tmp_path: Path) -> None:
    model = planarc.load(str(EXAMPLES / "pendulum.pmo"))
    path = model.export_fmu(tmp_path / "plain.fmu", platforms=["x86_64-linux"])
    with zipfile.ZipFile(path) as archive:
        assert not [n for n in archive.namelist() if n.startswith("sources/")]
