"""The printing of the commands: results on standard output, diagnostics on standard error.

Colour is for terminals only, and only when the user did not refuse it
(https://no-color.org).
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import TextIO

from planarc.cli.streams import silence
from planarc.core.diagnostic import Diagnostic, Severity


class Volume(IntEnum):
    QUIET = 0  # only what was asked for, and errors
    NORMAL = 1
    VERBOSE = 2  # also what only an expert asks


_volume = Volume.NORMAL


def prepare(volume: Volume = Volume.NORMAL) -> None:
    """Let no character that the terminal cannot show stop a command."""
    global _volume
    _volume = volume
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def may_colour(stream: TextIO) -> bool:
    refused = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    return not refused and stream.isatty()


def plain(text: str) -> str:
    """A text of the model on one line, without characters that would steer a terminal."""
    line = " ".join(text.split())
    return "".join(c if c.isprintable() else "\N{MIDDLE DOT}" for c in line)


def plain_lines(lines: Iterable[str]) -> str:
    """Lines as they are, without characters that would steer a terminal."""
    return "\n".join(line if line.isprintable() else _tamed(line) for line in lines)


def _tamed(line: str) -> str:
    return "".join(c if c.isprintable() or c == "\t" else "\N{MIDDLE DOT}" for c in line)


def say(text: str) -> None:
    """Print on standard output, without characters of names that would steer a terminal."""
    sys.stdout.write(plain_lines(text.removesuffix("\n").split("\n")) + "\n")


def tell(text: str, least: Volume = Volume.NORMAL) -> None:
    """Print a remark on standard error, unless it is too quiet for it."""
    if _volume >= least:
        warn(text if text.endswith("\n") else text + "\n")


def is_quiet() -> bool:
    return _volume == Volume.QUIET


def is_verbose() -> bool:
    return _volume == Volume.VERBOSE


def complain(diagnostics: Iterable[Diagnostic]) -> None:
    """Print diagnostics on standard error."""
    found = tuple(d for d in diagnostics if _volume or d.severity is Severity.ERROR)
    if not found:
        return
    from planarc.core.render import render_all

    text = render_all(found, may_colour(sys.stderr), is_verbose())
    if may_colour(sys.stderr):
        _rich_print(text, sys.stderr)
    else:
        warn(text)


def warn(text: str) -> None:
    """Print on standard error, as it is; where that is full or gone, there is nobody to tell."""
    try:
        sys.stderr.write(text)
        sys.stderr.flush()
    except OSError:
        silence(sys.stderr)


def say_rows(rows: Sequence[tuple[str, str]]) -> None:
    """Print labels with their texts, one below the other; a text may have several lines."""
    width = max((len(label) for label, _ in rows), default=0)
    lines = []
    for label, text in rows:
        first, *more = map(plain, text.split("\n"))
        lines.append((label.ljust(width), first))
        lines += [(" " * width, line) for line in more]
    if may_colour(sys.stdout):
        _rich_rows(lines)
    else:
        say("\n".join(f"{label}  {text}".rstrip() for label, text in lines))


def _rich_print(text: str, stream: TextIO) -> None:
    from rich.console import Console
    from rich.text import Text

    Console(file=stream, highlight=False).print(Text.from_ansi(text), soft_wrap=True, end="")


def _rich_rows(lines: Sequence[tuple[str, str]]) -> None:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="bold cyan", no_wrap=True)
    grid.add_column(overflow="fold")
    for label, text in lines:
        grid.add_row(Text(label), Text(text))
    Console(file=sys.stdout, highlight=False).print(grid)
