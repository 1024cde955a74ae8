"""Tables as comma-separated values (RFC 4180)."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, BinaryIO

from planarc.ir.dae import Kind
from planarc.ir.program import Column
from planarc.ir.result import Result

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.view.table import Table

_END = "\r\n"
#: Numbers formatted at a time, so that a long result needs little memory as text.
_CHUNK = 1 << 18


def write(file: BinaryIO, result: Result, columns: Sequence[Column], units: bool = False) -> None:
    """`units` puts them behind the names, in brackets."""
    names = ["time [s]" if units else "time"]
    names += [f"{c.name} [{c.unit}]" if units and c.unit else c.name for c in columns]
    header = ",".join(map(_quoted, names))
    file.write((header + _END).encode())
    rows = max(1, _CHUNK // len(names))
    for first in range(0, len(result.time), rows):
        file.write(_rows(result, columns, first, first + rows).encode())


def _quoted(name: str) -> str:
    """A name as a field; all are quoted, since many hold commas (`a[1,2]`)."""
    return '"' + name.replace('"', '""') + '"'


def _rows(result: Result, columns: Sequence[Column], first: int, last: int) -> str:
    """The rows as text. Columns that share a slot, and a sign, share their texts."""
    texts: dict[tuple[int, int, bool], list[str]] = {}
    chosen: list[list[str]] = [_numbers(result.time[first:last])]
    for c in columns:
        key = (c.slot, c.sign, c.kind is Kind.REAL)
        if key not in texts:
            values = c.sign * _values(result, c.slot, first, last)
            texts[key] = _numbers(values) if c.kind is Kind.REAL else _integers(values)
        chosen.append(texts[key])
    return _END.join([",".join(row) for row in zip(*chosen, strict=True)] + [""])


def _values(result: Result, slot: int, first: int, last: int) -> NDArray[np.float64]:
    import numpy as np

    if slot in result.stored:
        values: NDArray[np.float64] = result.data[first:last, result.stored[slot]]
        return values
    return np.full(len(result.time[first:last]), result.constants[slot])


def _numbers(values: NDArray[np.float64]) -> list[str]:
    """The shortest texts that read back as the same numbers."""
    if len(values) and (values == values[0]).all():
        return [repr(values[0].item() + 0.0)] * len(values)
    # The text of a whole list is made in C, and so is splitting it. Adding 0 drops -0.
    return repr((values + 0.0).tolist())[1:-1].split(", ")


def _integers(values: NDArray[np.float64]) -> list[str]:
    return repr([round(v) for v in values.tolist()])[1:-1].split(", ")


# Reading ---------------------------------------------------------------------------------------

#: Bytes read at a time.
_BLOCK = 1 << 22
_UNIT = re.compile(r"(.+) \[([^\[\]]+)\]")


def read(file: BinaryIO) -> Table:
    """Raises ValueError with the reason."""
    from planarc.view.table import Table

    names, first = _header(file)
    values = _body(file, len(names), first)
    units: dict[str, str] = {}
    columns: dict[str, NDArray[np.float64]] = {}
    for i, text in enumerate(names[1:], 1):
        found = _UNIT.fullmatch(text)
        name = found[1] if found else text
        if found:
            units[name] = found[2]
        columns[name] = values[:, i]
    return Table(values[:, 0], columns, units)


def _header(file: BinaryIO) -> tuple[list[str], int]:
    """The names, and the number of the first line behind them."""
    file.seek(0)
    try:
        lines = csv.reader(line.decode("utf-8-sig") for line in iter(file.readline, b""))
        names = [field.strip() for field in next(lines, [])]
    except UnicodeDecodeError:
        raise ValueError("it is not UTF-8 text") from None
    except csv.Error as problem:
        raise ValueError(str(problem)) from None
    if not names or names[0] not in {"time", "time [s]"}:
        raise ValueError("its first column is not `time`")
    return names, lines.line_num + 1


def _body(file: BinaryIO, width: int, line: int) -> NDArray[np.float64]:
    """The numbers of all rows, one below the other."""
    import numpy as np

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


def _fast(rows: Sequence[bytes], width: int) -> NDArray[np.float64] | None:
    """All numbers of some rows, made in C; None if they are not just numbers and commas."""
    import warnings

    import numpy as np

    if any(row.count(b",") != width - 1 for row in rows):
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            numbers = np.fromstring(b",".join(rows).decode("ascii"), sep=",")
    except (ValueError, DeprecationWarning):
        return None
    return numbers.reshape(len(rows), width) if numbers.size == len(rows) * width else None


def _careful(lines: Sequence[bytes], width: int, first: int) -> NDArray[np.float64]:
    """The same one by one, to allow quotes and to say where something is wrong."""
    import numpy as np

    rows = []
    reader = csv.reader(line.decode("utf-8", "replace") for line in lines)
    for row in reader:
        line = first + reader.line_num - 1
        if not row:
            continue
        if len(row) != width:
            raise ValueError(f"line {line} has {len(row)} fields, not {width}")
        try:
            rows.append([float(field) for field in row])
        except ValueError:
            raise ValueError(f"line {line} holds a field that is no number") from None
    return np.array(rows, dtype=float).reshape(len(rows), width)
