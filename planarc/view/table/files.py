"""Results as tables in files, and back: `.csv`, and `.mat` as Modelica tools share it.

    .csv   RFC 4180: `time`, then every variable that is no parameter; numbers with as
           many digits as reading them back exactly needs; on request with units, `"x [m]"`
    .mat   MATLAB level 4, variables and parameters; what is equal or opposite is stored once

With a regular expression only what it matches is written, and then parameters also as .csv.
Both are read back as a `Table`, also those that other tools wrote; of a .mat only the
columns that are asked for.
"""

from __future__ import annotations

import mmap
import re
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from planarc.core.diagnostic import refused, usage_error
from planarc.core.files import open_plain
from planarc.ir.result import Result
from planarc.view.storage import known_ending, refuse_no_match, replacing, shown
from planarc.view.table.table import Table

SUFFIXES = (".csv", ".mat")


def write_table(
    path: Path, result: Result, only: re.Pattern[str] | None = None, units: bool = False
) -> None:
    """Write a result by the ending of the name; `only` matches names somewhere, `units` go into
    the head of a .csv.

    Raises UsageError V501 (cannot write), V502 (unknown ending), V505 (nothing matches).
    """
    suffix = _suffix(path)
    refuse_no_match(result.program, only)
    columns = shown(result.program, only)
    with replacing(path) as file:
        if suffix == ".csv":
            from planarc.view.table import csv as table_csv

            chosen = [c for c in columns if only is not None or not c.constant]
            table_csv.write(file, result, chosen, units)
        else:
            from planarc.view.table import mat as table_mat

            table_mat.write(file, result, columns)


def read_table(path: Path) -> Table:
    """Read a table. Raises UsageError V502 (unknown ending), V503 (cannot read), V504 (not such
    a table)."""
    from planarc.view.table import csv as table_csv
    from planarc.view.table import mat as table_mat

    suffix = _suffix(path)
    try:
        with open_plain(path) as file:
            if suffix == ".csv":
                return table_csv.read(file)
            return table_mat.read(_mapped(file))
    except OSError as problem:
        raise refused("V503", f"cannot read `{path}`", problem) from None
    except ValueError as problem:
        hint = _UNFINISHED if _is_cut(path, suffix, str(problem)) else None
        raise usage_error("V504", f"`{path}` is no result table: {problem}", hint=hint) from None


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
