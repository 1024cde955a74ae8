"""Tables as MATLAB level 4 files, in the layout that Modelica tools share.

    Aclass       "Atrajectory", "1.1", a remark (planarc's: the class of the model), "binTrans"
    name         names of the variables, a column each
    description  theirs, with the unit in brackets
    dataInfo     for each: matrix (1 or 2; 0 for time), column (negative: opposite), 0, -1
    data_1       what is constant: two points, at the start and at the end
    data_2       what varies: all points
    origin       planarc's own: the model that made it; see `origin.py`

The text of a matrix is stored by columns of one name each ("trans"), and so are the
data, a column for each point. Files stored the other way round ("binNormal") are read.
"""

from __future__ import annotations

import mmap
import re
import struct
from collections.abc import Sequence
from typing import BinaryIO

import numpy as np

from planarc.core.arrays import Array, Vector
from planarc.ir.program import Column
from planarc.ir.result import Result
from planarc.view.table.origin import MATRIX
from planarc.view.table.table import Columns, Table

_DOUBLE, _INTEGER, _TEXT = 0, 20, 51


#: The count of numbers written at a time: a long result is not copied as a whole.
_CHUNK = 1 << 20


def write(file: BinaryIO, result: Result, columns: Sequence[Column], origin: bytes = b"") -> None:
    names = ["time", *(c.name for c in columns)]
    descriptions = ["Simulation time [s]", *(_description(c) for c in columns)]
    constants = list(dict.fromkeys(c.slot for c in columns if _constant(result, c)))
    varying = list(dict.fromkeys(c.slot for c in columns if not _constant(result, c)))
    constant_at = {slot: i + 2 for i, slot in enumerate(constants)}
    varying_at = {slot: i + 2 for i, slot in enumerate(varying)}

    info = np.empty((4, len(names)), dtype="<i4")
    info[:, 0] = 0, 1, 0, -1
    for i, c in enumerate(columns, 1):
        matrix, places = (1, constant_at) if _constant(result, c) else (2, varying_at)
        info[:, i] = matrix, c.sign * places[c.slot], 0, -1

    ends = result.time[[0, -1]] if len(result.time) else np.zeros(2)
    first = np.empty((1 + len(constants), 2))
    first[0] = ends
    for slot, i in constant_at.items():
        first[i - 1] = result.constants[slot]

    kind = ("Atrajectory", "1.1", result.program.name, "binTrans")
    _matrix(file, "Aclass", _TEXT, _texts(kind))
    _matrix(file, "name", _TEXT, _texts(names).T)
    _matrix(file, "description", _TEXT, _texts(descriptions).T)
    _matrix(file, "dataInfo", _INTEGER, info)
    _matrix(file, "data_1", _DOUBLE, first)
    _head(file, "data_2", _DOUBLE, 1 + len(varying), len(result.time))
    stored = [result.stored[slot] for slot in varying]
    most = max(1, _CHUNK // (1 + len(stored)))
    for at in range(0, len(result.time), most):
        rows = slice(at, at + most)
        points = np.column_stack([result.time[rows], result.data[rows, stored]])
        file.write(points.astype("<f8", copy=False).tobytes())
    if origin:
        _matrix(file, MATRIX, _TEXT, np.frombuffer(origin, dtype=np.uint8).reshape(1, -1))


def _constant(result: Result, column: Column) -> bool:
    return column.constant or column.slot not in result.stored


def _description(column: Column) -> str:
    unit = column.unit
    if column.display_unit and column.display_unit != unit:
        unit += f"|{column.display_unit}"
    return f"{column.description} [{unit}]".lstrip() if unit else column.description


def _texts(lines: Sequence[str]) -> Array:
    """A row of bytes for each text, filled up with blanks."""
    encoded = [line.encode() for line in lines]
    width = max(1, max(map(len, encoded)))
    joined = b"".join(e.ljust(width) for e in encoded)
    return np.frombuffer(joined, dtype=np.uint8).reshape(len(lines), width)


def _matrix(file: BinaryIO, name: str, kind: int, values: Array) -> None:
    _head(file, name, kind, *values.shape)
    forms = {_DOUBLE: "<f8", _INTEGER: "<i4", _TEXT: "u1"}
    file.write(values.astype(forms[kind], copy=False).tobytes(order="F"))


def _head(file: BinaryIO, name: str, kind: int, rows: int, columns: int) -> None:
    title = name.encode() + b"\0"
    file.write(struct.pack("<5i", kind, rows, columns, 0, len(title)) + title)


# Reading ---------------------------------------------------------------------------------------

#: The unit at the end of a description; a display unit may follow it.
_UNIT = re.compile(r"(?:^| )\[([^\[\]|]+)(?:\|[^\[\]]*)?\]$")
_FORMS = ("f8", "f4", "i4", "i2", "u2", "u1")


def _column(place: tuple[Array, int, bool], rows: int) -> Vector:
    """The values of a matrix's column with its sign; `place` also says whether it is constant."""
    points, at, constant = place
    values = points[:, abs(at) - 1]
    if constant:
        return np.full(rows, float(values[0]) * (1 if at > 0 else -1))
    own = values.astype(float)
    return own if at > 0 else -own


def read(data: bytes | mmap.mmap) -> tuple[Table, bytes]:
    """Read a table, and the text of its origin. Raises ValueError with the reason."""

    matrices = _matrices(data)
    missing = [n for n in ("Aclass", "name", "dataInfo", "data_2") if n not in matrices]
    if missing:
        raise ValueError(f"it holds no matrix `{missing[0]}`")
    kind = _lines(matrices["Aclass"])
    turned = "binTrans" in kind

    def by_row(name: str) -> Array:
        return matrices[name].T if turned else matrices[name]

    names = _lines(by_row("name"))
    descriptions = _lines(by_row("description")) if "description" in matrices else []
    info = by_row("dataInfo").astype(int)
    points = {k: by_row(f"data_{k}") for k in (1, 2) if f"data_{k}" in matrices}
    if len(info) != len(names) or info.shape[1] < 2:
        raise ValueError("its `dataInfo` does not belong to its names")
    time = points[2][:, 0].astype(float)
    places: dict[str, tuple[Array, int, bool]] = {}
    units: dict[str, str] = {}
    for i, name in enumerate(names):
        matrix, place = int(info[i, 0]), int(info[i, 1])
        if i < len(descriptions):
            unit = _UNIT.search(descriptions[i])
            if unit:
                units[name] = unit[1]
        if matrix == 0 or name.lower() == "time":
            continue
        if matrix not in points or not 0 < abs(place) <= points[matrix].shape[1]:
            raise ValueError(f"`{name}` refers to data that is not there")
        places[name] = points[matrix], place, matrix == 1
    remark = kind[2] if len(kind) == 4 else ""
    columns = Columns(places, lambda place: _column(place, len(time)))
    told = matrices[MATRIX].astype("u1").tobytes() if MATRIX in matrices else b""
    return Table(time, columns, units, remark), told


def _lines(matrix: Array) -> list[str]:
    lines = (row.astype("u1").tobytes() for row in matrix)
    return [line.decode("utf-8", "replace").rstrip(" \0") for line in lines]


def _matrices(data: bytes | mmap.mmap) -> dict[str, Array]:
    """All matrices of a level 4 file, by name."""
    found: dict[str, Array] = {}
    at = 0
    while at < len(data):
        if len(data) - at < 20:
            raise ValueError("it ends in the middle of a matrix")
        order = "<" if 0 <= struct.unpack_from("<i", data, at)[0] < 5000 else ">"
        kind, rows, columns, imaginary, length = struct.unpack_from(f"{order}5i", data, at)
        form = kind // 10 % 10
        if not 0 <= kind < 5000 or form >= len(_FORMS) or imaginary or min(rows, columns) < 0:
            raise ValueError("it is no MATLAB file of level 4")
        name = data[at + 20 : at + 20 + length].split(b"\0")[0].decode("latin-1")
        at += 20 + length
        dtype = np.dtype(order + _FORMS[form])
        size = rows * columns * dtype.itemsize
        if len(data) - at < size:
            raise ValueError(f"its matrix `{name}` is cut off")
        values = np.frombuffer(data, dtype, rows * columns, at)
        found[name] = values.reshape((columns, rows)).T
        at += size
    return found
