"""Tables as comma-separated values (RFC 4180)."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING, BinaryIO

from planarc.ir.dae import Kind
from planarc.ir.program import Column
from planarc.ir.result import Result
from planarc.view.storage import shown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.view.table import Table

_END = "\r\n"
#: Rows formatted at a time, so that a long result needs little memory as text.
_CHUNK = 4096


def write(file: BinaryIO, result: Result) -> None:
    columns = [c for c in shown(result) if not c.constant]
    header = ",".join(_quoted(name) for name in ("time", *(c.name for c in columns)))
    file.write((header + _END).encode())
    for first in range(0, len(result.time), _CHUNK):
        file.write(_rows(result, columns, first, first + _CHUNK).encode())


def _quoted(name: str) -> str:
    """A name as a field; all are quoted, since many hold commas (`a[1,2]`)."""
    return '"' + name.replace('"', '""') + '"'


def _rows(result: Result, columns: list[Column], first: int, last: int) -> str:
    """The rows as text. Columns that share a slot, and a sign, share their texts."""
    texts: dict[tuple[int, int, bool], list[str]] = {}
    chosen: list[list[str]] = [_numbers(result.time[first:last])]
    for c in columns:
        key = (c.slot, c.sign, c.kind is Kind.REAL)
        if key not in texts:
            values = c.sign * result.data[first:last, result.stored[c.slot]]
            texts[key] = _numbers(values) if c.kind is Kind.REAL else _integers(values)
        chosen.append(texts[key])
    return _END.join([",".join(row) for row in zip(*chosen, strict=True)] + [""])


def _numbers(values: NDArray[np.float64]) -> list[str]:
    """The shortest texts that read back as the same numbers."""
    if len(values) and (values == values[0]).all():
        return [repr(values[0].item() + 0.0)] * len(values)
    # The text of a whole list is made in C, and so is splitting it. Adding 0 drops -0.
    return repr((values + 0.0).tolist())[1:-1].split(", ")


def _integers(values: NDArray[np.float64]) -> list[str]:
    return repr([round(v) for v in values.tolist()])[1:-1].split(", ")


def read(data: bytes) -> Table:
    """Raises ValueError with the reason."""
    import numpy as np

    from planarc.view.table import Table

    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("it is not UTF-8 text") from None
    lines = csv.reader(io.StringIO(text, newline=""))
    header = next(lines, None)
    if not header or header[0].strip() != "time":
        raise ValueError("its first column is not `time`")
    rows = []
    for row in lines:
        if not row:
            continue
        if len(row) != len(header):
            raise ValueError(f"line {lines.line_num} has {len(row)} fields, not {len(header)}")
        try:
            rows.append([float(field) for field in row])
        except ValueError:
            raise ValueError(f"line {lines.line_num} holds a field that is no number") from None
    values = np.array(rows, dtype=float).reshape(len(rows), len(header))
    columns = {name.strip(): values[:, i] for i, name in enumerate(header) if i}
    return Table(values[:, 0], columns, {})
