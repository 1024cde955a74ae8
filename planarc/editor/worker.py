"""A thread that works when typing pauses, and gives up what is overtaken.

ask(key)    work(key, wanted) begins after a pause without another `ask` of that key;
            `wanted()` turns false as soon as there is one
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic
from typing import Generic, TypeVar

from planarc.editor.check import Overtaken

Key = TypeVar("Key")

#: Bytes for the calls of a thread: classes and expressions may be nested deeply.
_STACK = 256 * 2**20


class Worker(Generic[Key]):
    def __init__(
        self,
        work: Callable[[Key, Callable[[], bool]], None],
        failed: Callable[[Exception], None],
        pause: float,
    ) -> None:
        self._work, self._failed, self._pause = work, failed, pause
        self._due: dict[Key, float] = {}
        self._edition: dict[Key, int] = {}
        self._changed = threading.Condition()
        self._ended = False
        before = threading.stack_size(_STACK)
        self._thread = threading.Thread(target=self._run, name="planarc editor", daemon=True)
        self._thread.start()
        threading.stack_size(before)

    def ask(self, key: Key, pause: float | None = None) -> None:
        with self._changed:
            self._edition[key] = self._edition.get(key, 0) + 1
            self._due[key] = monotonic() + (self._pause if pause is None else pause)
            self._changed.notify()

    def forget(self, key: Key) -> None:
        """Give up what was asked of a key."""
        with self._changed:
            self._edition[key] = self._edition.get(key, 0) + 1
            self._due.pop(key, None)

    def rest(self, seconds: float) -> None:
        """Let other threads go first, as long as nothing else is asked of this one."""
        with self._changed:
            self._changed.wait_for(lambda: self._ended or self._due, seconds)

    def stop(self) -> None:
        with self._changed:
            self._ended = True
            self._edition = {key: n + 1 for key, n in self._edition.items()}
            self._changed.notify()
        self._thread.join(timeout=5)

    def _next(self) -> Key | None:
        """The key that is due, waited for; None at the end."""
        with self._changed:
            while not self._ended:
                key = min(self._due, key=self._due.__getitem__, default=None)
                wait = None if key is None else self._due[key] - monotonic()
                if key is not None and wait is not None and wait <= 0:
                    del self._due[key]
                    return key
                self._changed.wait(wait)
        return None

    def _run(self) -> None:
        while (key := self._next()) is not None:
            edition = self._edition[key]
            try:
                self._work(key, lambda k=key, e=edition: self._edition[k] == e)  # type: ignore[misc]
            except Overtaken:
                pass
            except Exception as problem:  # told, and the next text is looked at
                self._failed(problem)
