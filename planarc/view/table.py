"""Results as tables in files, and back: `.csv`, and `.mat` as Modelica tools share it.

    .csv   RFC 4180: `time`, then every variable that is no parameter; numbers with as
           many digits as reading them back exactly needs
    .mat   MATLAB level 4, variables and parameters; what is equal or opposite is stored once

Both are read back as a `Table`, also those that other tools wrote.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.ir.result import Result

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SUFFIXES = (".csv", ".mat")


@dataclass(frozen=True, slots=True)
class Table:
    """Columns over time. `units` only holds those that the file told."""

    time: NDArray[np.float64]
    columns: Mapping[str, NDArray[np.float64]]
    units: Mapping[str, str]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.time if name == "time" else self.columns[name]

    def __contains__(self, name: str) -> bool:
        return name == "time" or name in self.columns


def write_table(path: Path, result: Result) -> None:
    """By the name's ending. Raises UsageError V501 (cannot write), V502 (unknown ending)."""
    from planarc.view import table_csv, table_mat
    from planarc.view.storage import replacing

    suffix = _suffix(path)
    with replacing(path) as file:
        if suffix == ".csv":
            table_csv.write(file, result)
        else:
            table_mat.write(file, result)


def read_table(path: Path) -> Table:
    """Raises UsageError V502 (unknown ending), V503 (cannot read), V504 (not such a table)."""
    from planarc.view import table_csv, table_mat

    suffix = _suffix(path)
    try:
        data = path.read_bytes()
    except OSError as problem:
        reason = (problem.strerror or str(problem)).lower()
        raise UsageError(Diagnostic("V503", f"cannot read `{path}`: {reason}")) from None
    try:
        return table_csv.read(data) if suffix == ".csv" else table_mat.read(data)
    except ValueError as problem:
        raise UsageError(Diagnostic("V504", f"`{path}` is no result table: {problem}")) from None


def _suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(
            Diagnostic(
                "V502",
                f"`{path.name}` has no ending that says how to store a table",
                hint="use `.csv` or `.mat`",
            )
        )
    return suffix
