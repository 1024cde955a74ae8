"""The journal of a study: a line for each finished point, so that it can be taken up again.

The first line says which study it is; a line that was cut off or damaged does not count.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from msgspec import Struct, ValidationError, convert

from planarc.core.diagnostic import refused, usage_error
from planarc.study.bundle import Outcome


class _Line(Struct):
    point: int
    values: dict[str, float] | None = None
    failed: str | None = None


class Journal:
    """Open for one study, known by its `key`. Raises UsageError C233 to C235."""

    def __init__(self, path: Path, key: str) -> None:
        self._path = path
        self.done: dict[int, Outcome] = {}
        try:
            self._file: BinaryIO = path.open("a+b")
        except (OSError, ValueError) as problem:
            raise refused("C233", f"cannot write the journal `{path}`", problem) from None
        try:
            self._lock()
            self._read(key)
        except BaseException:
            self._file.close()
            raise

    def _lock(self) -> None:
        if not stat.S_ISREG(os.fstat(self._file.fileno()).st_mode):
            raise usage_error(
                "C233", f"cannot write the journal `{self._path}`: it is no ordinary file"
            )
        try:
            import fcntl
        except ImportError:  # Windows
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise usage_error(
                "C234", f"another study is writing the journal `{self._path}`"
            ) from None

    def _read(self, key: str) -> None:
        self._file.seek(0)
        lines = self._file.read().split(b"\n")
        whole, rest = lines[:-1], lines[-1]
        if not whole and not rest:
            self._write([{"planarc study": key}])
            return
        head = _parsed(whole[0]) if whole else None
        if not isinstance(head, dict) or head.get("planarc study") != key:
            raise usage_error(
                "C235",
                f"the journal `{self._path}` belongs to another study",
                hint="give another file, or the same model, points, metric and options",
            )
        for line in whole[1:]:
            try:
                item = convert(_parsed(line), _Line)
            except ValidationError:
                continue
            self.done[item.point] = Outcome(item.point, item.values, item.failed)
        if rest:
            self._file.write(b"\n")

    def add(self, outcomes: Iterable[Outcome]) -> None:
        items: list[object] = []
        for o in outcomes:
            told = {"values": o.values} if o.values is not None else {"failed": o.failed}
            items.append({"point": o.index, **told})
        self._write(items)

    def _write(self, items: Iterable[object]) -> None:
        """Write lines. Raises UsageError C233 where that fails, as on a full disk."""
        try:
            self._file.writelines(json.dumps(item).encode() + b"\n" for item in items)
            self._file.flush()
        except OSError as problem:
            raise refused("C233", f"cannot write the journal `{self._path}`", problem) from None

    def close(self) -> None:
        try:
            self._file.close()
        except OSError:  # what could not be written was told already
            return


def _parsed(line: bytes) -> object:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
