"""Writes a file so that it is there whole or not at all.

The text goes to a new file beside the old one, which it then replaces: a full disk or a
power cut leaves the old file as it was.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from planarc.core.diagnostic import Diagnostic, UsageError
from planarc.ir.program import Column
from planarc.ir.result import Result


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A file to write bytes to; it stands at `path` when the block ends without error.

    Raises `UsageError` V501 where the system refuses.
    """
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not target.is_file():
            # A device or a pipe (`/dev/stdout`) is written to, never replaced.
            with target.open("wb") as file:
                yield file
            return
        new = target.with_name(f".{target.name}.{os.getpid()}.new")
        try:
            with new.open("wb") as file:
                yield file
            new.replace(target)
        except BaseException:
            with suppress(OSError):
                new.unlink()
            raise
    except OSError as problem:
        raise UsageError(
            Diagnostic("V501", f"cannot write `{path}`: {_reason(target, problem)}", hint=_hint)
        ) from None


_hint = "give another place to write to"


def _reason(target: Path, problem: OSError) -> str:
    if isinstance(problem, FileNotFoundError) and not target.parent.is_dir():
        return f"there is no folder `{target.parent.name}`"
    if isinstance(problem, IsADirectoryError):
        return "it is a folder"
    return (problem.strerror or str(problem)).lower()


def shown(result: Result) -> tuple[Column, ...]:
    """The columns that a user knows of: names made by planarc itself begin with `$`."""
    return tuple(c for c in result.program.columns if not c.name.startswith("$"))
