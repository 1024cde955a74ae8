"""Standard streams that a command can rely on: open, and telling whether they can be written.

Imported before everything else, so it imports next to nothing.
"""

from __future__ import annotations

import io
import os
import sys
from typing import TextIO


class CannotPrint(Exception):
    """Standard output is full or closed; the reason is its text."""


class Output(io.TextIOWrapper):
    """Standard output. Raises CannotPrint where the system refuses what is printed."""

    def write(self, text: str) -> int:
        try:
            return super().write(text)
        except OSError as problem:
            raise _refusal(problem) from None

    def flush(self) -> None:
        try:
            super().flush()
        except OSError as problem:
            raise _refusal(problem) from None


def _refusal(problem: OSError) -> Exception:
    if isinstance(problem, BrokenPipeError):
        return problem
    return CannotPrint((problem.strerror or str(problem)).lower())


def silence(stream: TextIO) -> None:
    """Let what goes to a stream go nowhere from here on: Python flushes it again at the end."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
    except (OSError, ValueError):
        return


def open_streams() -> None:
    """Put something in the place of closed streams, else a file that is opened gets their number,
    and with it what C's libraries print. A standard output that was closed refuses all."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_WRONLY if number == 2 else os.O_RDONLY)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
            setattr(sys, name, os.fdopen(number, "w" if number else "r"))
    out = sys.stdout
    if isinstance(out, io.TextIOWrapper):
        told = out.encoding, out.errors, None, out.line_buffering, out.write_through
        sys.stdout = Output(out.detach(), *told)
