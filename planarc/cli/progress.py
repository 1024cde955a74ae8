"""How far a long run is, on a terminal, on one line that goes away."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from planarc.cli.console import plain

PATIENCE = 1.0  # s before the first word
PERIOD = 0.2  # s between two


class ProgressLine:
    """Called with the simulated time; writes it on standard error now and then."""

    def __init__(self) -> None:
        self._due = monotonic() + PATIENCE
        self.shown = False

    def __call__(self, time: float) -> None:
        self.write(f"t = {time:.6g} s, Ctrl-C stops and saves")

    def write(self, text: str) -> None:
        if monotonic() >= self._due:
            sys.stderr.write(f"\r\x1b[K{text}")
            sys.stderr.flush()
            self._due = monotonic() + PERIOD
            self.shown = True


@contextmanager
def progress_line() -> Iterator[ProgressLine | None]:
    """A line of progress when standard error is a terminal, else None."""
    if not sys.stderr.isatty():
        yield None
        return
    line = ProgressLine()
    try:
        yield line
    finally:
        if line.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


@contextmanager
def counting_line() -> Iterator[Callable[[int, int, str], None] | None]:
    """A line that counts classes when standard error is a terminal, else None."""
    with progress_line() as line:
        if line is None:
            yield None
        else:
            yield lambda done, known, name: line.write(
                f"{done} of {known} classes, {plain(name)[:50]}"
            )
