"""A thread that works when typing pauses, and gives up what is overtaken.

ask(path)    work(path, wanted) begins after a pause without another `ask` of that path;
             `wanted()` turns false as soon as there is one
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import TypeAlias

from planarc.editor.check import Overtaken

Work: TypeAlias = Callable[[Path, Callable[[], bool]], None]

#: Bytes for the calls of a thread: classes and expressions may be nested deeply.
_STACK = 256 * 2**20


class Worker:
    def __init__(self, work: Work, failed: Callable[[Exception], None], pause: float = 0.08):
        self._work, self._failed, self._pause = work, failed, pause
        self._due: dict[Path, float] = {}
        self._edition: dict[Path, int] = {}
        self._changed = threading.Condition()
        self._ended = False
        before = threading.stack_size(_STACK)
        self._thread = threading.Thread(target=self._run, name="planarc editor", daemon=True)
        self._thread.start()
        threading.stack_size(before)

    def ask(self, path: Path, pause: float | None = None) -> None:
        with self._changed:
            self._edition[path] = self._edition.get(path, 0) + 1
            self._due[path] = monotonic() + (self._pause if pause is None else pause)
            self._changed.notify()

    def forget(self, path: Path) -> None:
        """Give up what was asked of a path."""
        with self._changed:
            self._edition[path] = self._edition.get(path, 0) + 1
            self._due.pop(path, None)

    def stop(self) -> None:
        with self._changed:
            self._ended = True
            self._edition = {path: n + 1 for path, n in self._edition.items()}
            self._changed.notify()
        self._thread.join(timeout=5)

    def _next(self) -> Path | None:
        """The path that is due, waited for; None at the end."""
        with self._changed:
            while not self._ended:
                path = min(self._due, key=lambda p: self._due[p], default=None)
                wait = None if path is None else self._due[path] - monotonic()
                if path is not None and wait is not None and wait <= 0:
                    del self._due[path]
                    return path
                self._changed.wait(wait)
        return None

    def _run(self) -> None:
        while (path := self._next()) is not None:
            edition = self._edition[path]
            try:
                self._work(path, lambda p=path, e=edition: self._edition[p] == e)  # type: ignore[misc]
            except Overtaken:
                pass
            except Exception as problem:  # told, and the next text is looked at
                self._failed(problem)
