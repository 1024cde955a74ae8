"""The progress of a command: shown on a terminal, unless it is to be quiet."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from planarc.cli import console
from planarc.core.progress import Progress


@contextmanager
def progress_line() -> Iterator[Callable[[float], None] | None]:
    """A function to call with the simulated time, where somebody sees it; else None."""
    if not is_seen():
        yield None
        return
    with Progress() as progress:
        yield lambda time: progress.show(f"t = {time:.6g} s, Ctrl-C stops and saves")


@contextmanager
def counting_line() -> Iterator[Callable[[int, int, str], None] | None]:
    """A function to call with the number of classes done, of those known, and a name; or None."""
    if not is_seen():
        yield None
        return
    with Progress() as progress:
        yield lambda done, known, name: progress.show(
            f"classes, {console.plain(name)[:50]}", done, known
        )


def is_seen() -> bool:
    return sys.stderr.isatty() and not console.is_quiet()
