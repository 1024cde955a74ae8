"""The journal of a study: a line for each finished point, so that it can be taken up again.

The first line says which study it is; a last line that was cut off does not count.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import TextIO

from planarc.core.diagnostic import usage_error
from planarc.study.bundle import Outcome


class Journal:
    """Open for one study, known by its `key`. Raises UsageError C233 to C235."""

    def __init__(self, path: Path, key: str) -> None:
        self._path = path
        self.done: dict[int, Outcome] = {}
        try:
            self._file: TextIO = path.open("a+", encoding="utf-8")
        except OSError as problem:
            reason = (problem.strerror or str(problem)).lower()
            raise usage_error("C233", f"cannot write the journal `{path}`: {reason}") from None
        try:
            self._lock()
            self._read(key)
        except BaseException:
            self._file.close()
            raise

    def _lock(self) -> None:
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
        lines = self._file.read().split("\n")
        whole, rest = lines[:-1], lines[-1]
        if not whole and not rest:
            self._write({"planarc study": key})
            return
        head = _parsed(whole[0]) if whole else None
        if not isinstance(head, dict) or head.get("planarc study") != key:
            raise usage_error(
                "C235",
                f"the journal `{self._path}` belongs to another study",
                hint="give another file, or the same model, points, metric and options",
            )
        for line in whole[1:]:
            item = _parsed(line)
            if isinstance(item, dict) and isinstance(item.get("point"), int):
                i = item["point"]
                self.done[i] = Outcome(i, item.get("values"), item.get("failed"))
        if rest:
            self._file.write("\n")

    def add(self, outcomes: Iterable[Outcome]) -> None:
        for o in outcomes:
            item: dict[str, object] = {"point": o.index}
            item |= {"values": o.values} if o.values is not None else {"failed": o.failed}
            self._file.write(json.dumps(item) + "\n")
        self._file.flush()

    def _write(self, item: object) -> None:
        self._file.write(json.dumps(item) + "\n")
        self._file.flush()

    def close(self) -> None:
        self._file.close()


def _parsed(line: str) -> object:
    try:
        return json.loads(line)
    except ValueError:
        return None
