"""Ctrl-C in a work that must not break off in its middle: the work asks for it, or ends first.

An exception in the middle of a step would be lost where Python is called from C, or leave half
a row; in the middle of a file it would lose what was computed. A second Ctrl-C is raised at
once, for what never comes back.
"""

from __future__ import annotations

# Beneath the module `signal`, which looks for names of numbers and handlers, for 20 us a run.
from _signal import SIGINT, default_int_handler, getsignal, signal  # type: ignore[import-not-found]
from contextlib import suppress
from types import FrameType


class Interruption:
    """A context; `asked` becomes true with the first Ctrl-C in it.

    Only in the main thread, and where nobody else has taken the signal: elsewhere
    KeyboardInterrupt comes as it always does.
    """

    def __init__(self) -> None:
        self.asked = False
        self._installed = False

    def __enter__(self) -> Interruption:
        if getsignal(SIGINT) is default_int_handler:
            with suppress(ValueError):  # in another thread
                signal(SIGINT, self._take)
                self._installed = True
        return self

    def _take(self, number: int, frame: FrameType | None) -> None:
        if self.asked:
            default_int_handler(number, frame)
        self.asked = True

    def __exit__(self, *_: object) -> None:
        if self._installed:
            signal(SIGINT, default_int_handler)
