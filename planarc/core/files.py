"""Files that a user names: read only where they have an end.

A device has none, and a named pipe none before somebody writes into it; neither is waited for.
A pipe that a shell has opened stands below `/dev`, and is read.
"""

from __future__ import annotations

import os
from io import UnsupportedOperation
from pathlib import Path
from stat import S_ISBLK, S_ISCHR, S_ISFIFO
from typing import BinaryIO

#: A named pipe is opened without waiting for its writer, where the system can do that.
_NO_WAIT = getattr(os, "O_NONBLOCK", 0)


class Endless(UnsupportedOperation):
    """A device or a named pipe stands where a file should. An OSError."""

    strerror = "it is no ordinary file"


def open_plain(path: Path) -> BinaryIO:
    """A file to read bytes from. Raises OSError; ValueError for names that no file can have."""
    if path.is_relative_to("/dev") and not _is_device(path.stat().st_mode):
        return path.open("rb")
    return open(path, "rb", opener=_opened)


def read_plain(path: Path) -> bytes:
    """The content of a file, as `open_plain` gives it."""
    with open_plain(path) as file:
        return file.read()


def _opened(name: str, flags: int) -> int:
    number = os.open(name, flags | _NO_WAIT)
    mode = os.fstat(number).st_mode
    if _is_device(mode) or S_ISFIFO(mode):
        os.close(number)
        raise Endless
    return number


def _is_device(mode: int) -> bool:
    return S_ISCHR(mode) or S_ISBLK(mode)
