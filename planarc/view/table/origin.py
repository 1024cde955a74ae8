"""The origin of a result: the model that made it, where that stands, and what was set.

A .csv has it in a file beside it, `FourBar.csv-metadata.json`, as the W3C lays down for tables,
so that nothing stands in the table itself that a spreadsheet would take for numbers; a .mat has
the same text in a matrix of its own. Paths are relative to the folder of the result, so that
both can be moved together. `size` is the length of the .csv in bytes: another table of that name
has another one, and nothing is told of it.

Reference: W3C Recommendation, Metadata Vocabulary for Tabular Data, 2015, section 5.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Any

import msgspec

from planarc.core.data import Data
from planarc.core.files import read_plain
from planarc.ir.program import Column, Program
from planarc.ir.result import Result

#: The matrix of a .mat.
MATRIX = "origin"
#: The longest text that is read: of a model with some hundred thousand variables.
_MOST = 1 << 26


class Origin(Data):
    """The class, its file (none for a library's), and parameters that are not as it says."""

    model: str = ""
    file: Path | None = None
    libraries: tuple[Path, ...] = ()
    parameters: Mapping[str, float] = {}


#: Of a model that is no file, such as a text.
UNKNOWN = Origin()


class _Told(msgspec.Struct):
    """An origin as text: paths with `/`, relative where they can be."""

    model: str
    file: str = ""
    libraries: tuple[str, ...] = ()
    parameters: dict[str, float] = {}
    size: int = -1


class _Schema(msgspec.Struct):
    columns: list[dict[str, str]] = []


class _Beside(msgspec.Struct):
    """The file beside a .csv."""

    planarc: _Told
    schema: _Schema = msgspec.field(default_factory=_Schema, name="tableSchema")


def changed_parameters(result: Result) -> dict[str, float]:
    """The parameters whose values are not the model's, and all structural ones."""
    found = {}
    for p in result.program.parameter_slots:
        value = result.constants.get(p.slot)
        if value is None or p.final or not isfinite(value):
            continue
        if p.structural or (p.default is not None and value != p.default):
            found[p.name] = float(value)
    return found


def as_text(path: Path, result: Result, origin: Origin) -> bytes:
    """The origin of the result that stands at `path`."""
    return msgspec.json.encode(_told(path, result, origin))


def _told(path: Path, result: Result, origin: Origin, size: int = -1) -> _Told:
    file = "" if origin.file is None else _relative(origin.file, path.parent)
    libraries = tuple(_relative(folder, path.parent) for folder in origin.libraries)
    return _Told(result.program.name, file, libraries, changed_parameters(result), size)


def from_text(path: Path, text: bytes) -> Origin | None:
    """The origin of the result that stands at `path`; None for a text that tells none."""
    with suppress(msgspec.MsgspecError, ValueError):
        return _origin(path, msgspec.json.decode(text, type=_Told))
    return None


def _origin(path: Path, told: _Told) -> Origin:
    libraries = tuple(path.parent / folder for folder in told.libraries)
    file = path.parent / told.file if told.file else None
    return Origin(told.model, file, libraries, told.parameters)


def beside(path: Path) -> Path:
    """The file that tells of a .csv."""
    return path.with_name(f"{path.name}-metadata.json")


def write_beside(path: Path, result: Result, columns: Sequence[Column], origin: Origin) -> None:
    """Write what the .csv at `path` cannot say; nothing for a device or a pipe, nor where the
    longer name has no room."""
    from planarc.view.storage import CannotWrite, write_text

    if not path.is_file():
        return
    names = [("time", "s"), *((c.name, c.unit) for c in columns)]
    told: dict[str, Any] = {
        "@context": "http://www.w3.org/ns/csvw",
        "url": path.name,
        "dc:title": _title(result.program),
        "planarc": _told(path, result, origin, path.stat().st_size),
        "tableSchema": {"columns": [_column(*column) for column in names]},
    }
    with suppress(CannotWrite):
        write_text(beside(path), msgspec.json.encode(told).decode() + "\n")


def _title(program: Program) -> str:
    return f"{program.name}: {program.description}" if program.description else program.name


def _column(name: str, unit: str) -> dict[str, str]:
    return {"titles": name, "schema:unitText": unit} if unit else {"titles": name}


def read_beside(path: Path) -> tuple[Origin | None, dict[str, str]]:
    """The origin of the .csv at `path`, and units; nothing where they are of another table."""
    with suppress(OSError, ValueError, msgspec.MsgspecError):
        file = beside(path)
        if file.stat().st_size <= _MOST:
            found = msgspec.json.decode(read_plain(file), type=_Beside)
            if found.planarc.size == path.stat().st_size:
                return _origin(path, found.planarc), _units(found.schema.columns)
    return None, {}


def _units(columns: Sequence[Mapping[str, str]]) -> dict[str, str]:
    told = ((c.get("titles"), c.get("schema:unitText")) for c in columns)
    return {name: unit for name, unit in told if name and unit and name != "time"}


def _relative(path: Path, folder: Path) -> str:
    with suppress(ValueError):  # on another drive
        return Path(os.path.relpath(path, folder)).as_posix()
    return path.absolute().as_posix()
