"""A progress bar on one line of standard error, for studies."""

from __future__ import annotations

import sys
from time import monotonic

WIDTH = 30
PERIOD = 0.1  # s between two drawings


class Bar:
    """Called with the numbers of finished, of all, and of failed points."""

    def __init__(self) -> None:
        self._begin = monotonic()
        self._due = 0.0

    def __call__(self, done: int, total: int, failed: int) -> None:
        now = monotonic()
        if now < self._due and done < total:
            return
        self._due = now + PERIOD
        full = WIDTH * done // max(1, total)
        rest = (now - self._begin) * (total - done) / max(1, done)
        text = f"{'#' * full}{'.' * (WIDTH - full)} {done}/{total}"
        text += f", {failed} failed" if failed else ""
        text += f", {rest:.0f} s left" if done < total else f", {now - self._begin:.1f} s\n"
        sys.stderr.write(f"\r\x1b[K{text}" if sys.stderr.isatty() else f"\r{text}")
        sys.stderr.flush()
