"""Results that stand in files, as a user holds them in Python."""

from __future__ import annotations

from pathlib import Path

from planarc.api.load import load
from planarc.api.model import Model
from planarc.api.restore import compile_guess, of_origin, restore
from planarc.api.result import Result
from planarc.core.diagnostic import usage_error
from planarc.core.unknown import telling_keywords
from planarc.view.table.files import read_table


@telling_keywords
def read(path: str | Path, model: Model | str | Path | None = None) -> Result:
    """A result from a file (.csv or .mat), of planarc or another tool.

    It has names, units and values as the result of a run, `at` and `plot`. What moves needs the
    model: one that the file tells of is found, another may be given.

    Raises UsageError: V503 (no such file), V504 (no table), C290 (a result of another model).
    """
    if not isinstance(path, str | Path):
        raise usage_error("C202", f"a file has a path, not {path!r:.60}", hint='give "run.csv"')
    table = read_table(Path(path))
    compiled = None
    if model is not None:
        compiled = model.compiled() if isinstance(model, Model) else load(model).compiled()
    elif table.origin is not None and (found := of_origin(table.origin)) is not None:
        compiled = compile_guess(found, table)
    return Result(restore(table, Path(path).name, compiled).result, compiled)
