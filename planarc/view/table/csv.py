"""Tables as comma-separated values (RFC 4180)."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, BinaryIO

import numpy as np
from msgspec import MsgspecError, json

from planarc.ir.dae import Kind
from planarc.ir.program import Column
from planarc.ir.result import Result

if TYPE_CHECKING:
    import csv

    from planarc.core.arrays import Vector
    from planarc.view.table.table import Table

_END = b"\r\n"
#: The count of numbers formatted at a time: they and their text stay in the processor's cache, and
#: in memory that the process has already. Of a wide table it is some rows at least.
_CHUNK, _ROWS = 1 << 12, 8
_JSON = json.Encoder()


def write(file: BinaryIO, result: Result, columns: Sequence[Column], units: bool = False) -> None:
    """Write columns over time; with `units` in brackets behind the names."""
    names = ["time [s]" if units else "time"]
    names += [f"{c.name} [{c.unit}]" if units and c.unit else c.name for c in columns]
    header = ",".join(map(_quoted, names))
    file.write(header.encode() + _END)
    whole = [i for i, c in enumerate(columns, 1) if c.kind is not Kind.REAL]
    for numbers in _numbers(result, columns):
        file.write(_text(numbers, whole))


def _quoted(name: str) -> str:
    """A name as a field; all are quoted, since many hold commas (`a[1,2]`)."""
    return '"' + name.replace('"', '""') + '"'


def _numbers(result: Result, columns: Sequence[Column]) -> Iterator[Vector]:
    """Time and the columns, side by side, some rows at a time."""
    signs = np.array([1, *(c.sign for c in columns)], float)
    kept = [i for i, c in enumerate(columns, 1) if c.slot in result.stored]
    fixed = [i for i, c in enumerate(columns, 1) if c.slot not in result.stored]
    sources = np.array([result.stored[columns[i - 1].slot] for i in kept], np.intp)
    values = [result.constants[columns[i - 1].slot] for i in fixed]
    count = max(_ROWS, _CHUNK // len(signs))
    for first in range(0, len(result.time), count):
        rows = slice(first, first + count)
        numbers = np.empty((len(result.time[rows]), len(signs)))
        numbers[:, 0] = result.time[rows]
        numbers[:, kept] = result.data[rows].take(sources, axis=1)
        numbers[:, fixed] = values
        numbers *= signs
        numbers += 0.0  # drops -0
        yield numbers


def _text(numbers: Vector, whole: Sequence[int]) -> bytes | memoryview:
    """Rows with the shortest texts that read back as the same numbers; `whole` are the
    columns of whole numbers."""
    rows: list[list[float]] = numbers.tolist()
    for row in rows:
        for i in whole:
            row[i] = round(row[i]) if math.isfinite(row[i]) else row[i]
    if not np.isfinite(numbers).all():
        return b"".join(",".join(map(repr, row)).encode() + _END for row in rows)
    text = bytearray()  # lists of JSON, made in C; their brackets become ends of lines
    for row in rows:
        behind = len(text)
        _JSON.encode_into(row, text, behind)
        if behind:
            text[behind - 1 : behind + 1] = _END
    text[-1:] = _END
    return memoryview(text)[1:]


# Reading ---------------------------------------------------------------------------------------

#: The count of bytes read at a time.
_BLOCK = 1 << 22
#: Numbers as JSON has them, which most files hold.
_LIST = json.Decoder(list[float])
_UNIT = r"(.+) \[([^\[\]]+)\]"


def read(file: BinaryIO) -> Table:
    """Read a table. Raises ValueError with the reason."""
    from planarc.view.table.table import Table

    names, first = _header(file)
    values = _body(file, len(names), first)
    units: dict[str, str] = {}
    columns: dict[str, Vector] = {}
    for i, text in enumerate(names[1:], 1):
        found = re.fullmatch(_UNIT, text)
        name = found[1] if found else text
        if found:
            units[name] = found[2]
        columns[name] = values[:, i]
    return Table(values[:, 0], columns, units)


def _header(file: BinaryIO) -> tuple[list[str], int]:
    """The names, and the number of the first line behind them."""
    import csv

    file.seek(0)
    try:
        lines = csv.reader(line.decode("utf-8-sig") for line in iter(file.readline, b""))
        names = [field.strip() for field in next(lines, [])]
    except UnicodeDecodeError:
        raise ValueError("it is not UTF-8 text") from None
    except csv.Error as problem:
        raise _unreadable(1, problem) from None
    if not names or names[0].lower() not in {"time", "time [s]"}:
        raise ValueError("its first column is not `time`")
    return names, lines.line_num + 1


def _body(file: BinaryIO, width: int, line: int) -> Vector:
    """The numbers of all rows, one below the other."""
    begin = file.tell()
    most = sum(block.count(b"\n") for block in iter(lambda: file.read(_BLOCK), b"")) + 1
    file.seek(begin)
    values = np.empty((most, width))
    count = 0
    while block := file.read(_BLOCK) + file.readline():
        lines = block.split(b"\n")
        rows = [row for row in lines if row.strip()]
        numbers = _fast(rows, width)
        if numbers is None:
            numbers = _careful(lines, width, line)
        values[count : count + len(numbers)] = numbers
        count += len(numbers)
        line += block.count(b"\n")
    return values[:count]


def _fast(rows: Sequence[bytes], width: int) -> Vector | None:
    """All numbers of some rows, made in C; None if they are not just numbers and commas."""
    if any(row.count(b",") != width - 1 for row in rows):
        return None
    text = b",".join(rows)
    try:
        numbers = np.array(_LIST.decode(b"[%b]" % text))
    except MsgspecError:  # JSON knows no infinity and no `.5`
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                numbers = np.fromstring(text.decode("ascii"), sep=",")
        except (ValueError, DeprecationWarning):
            return None
    return numbers.reshape(len(rows), width) if numbers.size == len(rows) * width else None


def _careful(lines: Sequence[bytes], width: int, first: int) -> Vector:
    """The numbers read one by one, to allow quotes and to say where something is wrong."""
    rows = []
    for line, row in _fields(lines, first):
        if len(row) != width:
            raise ValueError(f"line {line} has {len(row)} fields, not {width}")
        try:
            rows.append([float(field) for field in row])
        except ValueError:
            raise ValueError(f"line {line} holds a field that is no number") from None
    return np.array(rows, dtype=float).reshape(len(rows), width)


def _fields(lines: Sequence[bytes], first: int) -> Iterator[tuple[int, list[str]]]:
    """The fields of each row that has some, with the number of its line."""
    import csv

    reader = csv.reader(line.decode("utf-8", "replace") for line in lines)
    try:
        for row in reader:
            if row:
                yield first + reader.line_num - 1, row
    except csv.Error as problem:
        raise _unreadable(first + reader.line_num - 1, problem) from None


def _unreadable(line: int, problem: csv.Error) -> ValueError:
    """A carriage return within a row, or a field without an end."""
    return ValueError(f"line {line}: {str(problem).partition(' - ')[0]}")
