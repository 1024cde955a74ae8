"""Results as tables in files, and back: `.csv`, and `.mat` as Modelica tools share it.

    .csv   RFC 4180: `time`, then every variable that is no parameter; numbers with as
           many digits as reading them back exactly needs; on request with units, `"x [m]"`
    .mat   MATLAB level 4, variables and parameters; what is equal or opposite is stored once

What the numbers do not say, such as the model that made them, stands beside; see `origin`.

With a regular expression only what it matches is written, and then parameters also as .csv.
Both are read back as a `Table`, also those that other tools wrote; of a .mat only the
columns that are asked for.
"""

from __future__ import annotations

import mmap
import re
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from msgspec.structs import replace

from planarc.core.diagnostic import refused, usage_error
from planarc.core.files import open_plain
from planarc.ir.result import Result
from planarc.view.storage import known_ending, refuse_no_match, replacing, shown
from planarc.view.table.origin import UNKNOWN, Origin, as_text, from_text, read_beside, write_beside

if TYPE_CHECKING:
    from planarc.view.table.table import Table

SUFFIXES = (".csv", ".mat")


def write_table(
    path: Path,
    result: Result,
    only: re.Pattern[str] | None = None,
    units: bool = False,
    origin: Origin = UNKNOWN,
) -> None:
    """Write a result by the ending of the name; `only` matches names somewhere, `units` go into
    the head of a .csv, `origin` says where the model stands.

    Raises UsageError V501 (cannot write), V502 (unknown ending), V505 (nothing matches).
    """
    suffix = _suffix(path)
    refuse_no_match(result.program, only)
    columns = shown(result.program, only)
    if suffix == ".csv":
        from planarc.view.table import csv as table_csv

        chosen = [c for c in columns if only is not None or not c.constant]
        with replacing(path) as file:
            table_csv.write(file, result, chosen, units)
        write_beside(path, result, chosen, origin)
    else:
        from planarc.view.table import mat as table_mat

        with replacing(path) as file:
            table_mat.write(file, result, columns, as_text(path, result, origin))


def read_table(path: Path) -> Table:
    """Read a table. Raises UsageError V502 (unknown ending), V503 (cannot read), V504 (not such
    a table)."""
    from planarc.view.table import csv as table_csv
    from planarc.view.table import mat as table_mat

    suffix = _suffix(path)
    try:
        with open_plain(path) as file:
            if suffix == ".csv":
                return _with_origin(table_csv.read(file), path)
            table, told = table_mat.read(_mapped(file))
            return replace(table, origin=from_text(path, told))
    except OSError as problem:
        raise refused("V503", f"cannot read `{path}`", problem) from None
    except ValueError as problem:
        hint = _UNFINISHED if _is_cut(path, suffix, str(problem)) else None
        raise usage_error("V504", f"`{path}` is no result table: {problem}", hint=hint) from None


def _with_origin(table: Table, path: Path) -> Table:
    """A table with what stands beside its file."""
    origin, units = read_beside(path)
    model = table.model if origin is None else origin.model
    return replace(table, units={**units, **table.units}, model=model, origin=origin)


_UNFINISHED = "the file ends early: wait until it is written, or write it again"


def _is_cut(path: Path, suffix: str, problem: str) -> bool:
    if suffix != ".csv":
        return "cut off" in problem
    with suppress(OSError), path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - 1))
        return size > 0 and file.read(1) not in b"\r\n"
    return False


def _mapped(file: BinaryIO) -> bytes | mmap.mmap:
    """The bytes of a file; the system reads them when they are looked at."""
    if file.seek(0, 2) == 0:
        return b""
    return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def _suffix(path: Path) -> str:
    return known_ending(path, SUFFIXES, "V502", "that says how to store a table")
