"""Source text and places in it.

A `Source` is one text with a name; a `Span` is a half-open range of characters
in it. Every node of every tree carries a span, so that any later stage can
point at the user's line. Lines and columns are computed only when asked for.
"""

from __future__ import annotations

from bisect import bisect_right
from pathlib import Path
from typing import NamedTuple

from planarc.core.files import read_plain

#: The endings of model files.
SUFFIXES = (".pmo", ".mo")


class Source:
    """One text that was read, under the name that messages show."""

    __slots__ = ("_line_starts", "_text", "name", "path")

    def __init__(self, name: str, text: str | None = None, path: Path | None = None) -> None:
        self.name = name
        self.path = path
        self._text = text
        self._line_starts: list[int] | None = None

    @property
    def text(self) -> str:
        """The whole text; read again from `path` when it was not kept."""
        if self._text is None:
            self._text = decode(read_plain(self.path)) if self.path else ""
        return self._text

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column of a character, both counted from 1."""
        starts = self._starts()
        line = bisect_right(starts, offset)
        return line, offset - starts[line - 1] + 1

    def start_of(self, line: int) -> int:
        """The first character of a line (from 1); of one behind the last, the end of the text."""
        starts = self._starts()
        return starts[max(line, 1) - 1] if line <= len(starts) else len(self.text)

    def _starts(self) -> list[int]:
        if self._line_starts is None:
            text = self.text
            self._line_starts = [0, *(i + 1 for i, c in enumerate(text) if c == "\n")]
        return self._line_starts

    def line(self, number: int) -> str:
        """The text of a line (from 1), without its end."""
        lines = self.text.split("\n")
        return lines[number - 1].rstrip("\r") if 0 < number <= len(lines) else ""

    def __reduce__(self) -> tuple[object, ...]:
        # Trees are cached on disk; a text that lives in a file stays there.
        return (Source, (self.name, None if self.path else self._text, self.path))

    def __eq__(self, other: object) -> bool:
        # Entries of a cache that are read one by one have each its own.
        if self is other or not isinstance(other, Source):
            return self is other
        if (self.name, self.path) != (other.name, other.path):
            return False
        unread = self._text is None and other._text is None
        return unread or self.text == other.text

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"Source({self.name!r})"


class Span(NamedTuple):
    """Characters `start` to `end` (exclusive) of a source."""

    source: Source
    start: int
    end: int

    @property
    def line(self) -> int:
        return self.source.position(self.start)[0]

    @property
    def column(self) -> int:
        return self.source.position(self.start)[1]

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]

    def to(self, other: Span) -> Span:
        """The span from the start of this one to the end of another."""
        return Span(self.source, self.start, max(self.end, other.end))

    def covers(self, other: Span) -> bool:
        inside = self.start <= other.start and other.end <= self.end
        return inside and self.source is other.source


class _Nowhere(Span):
    """No place; what is read from the disk has the same one, which `is NOWHERE`."""

    __slots__ = ()

    def __reduce__(self) -> str | tuple[object, ...]:
        return "NOWHERE" if self is NOWHERE else (Span, tuple(self))


#: The place of what no file holds (a generated equation, a default).
NOWHERE: Span = _Nowhere(Source("<planarc>", ""), 0, 0)


def model_files(folder: Path, below: bool = False) -> list[Path]:
    """The model files in a folder, by their names; with `below`, in the folders in it, too."""
    inside = folder.rglob("*") if below else folder.iterdir()
    return sorted(path for path in inside if path.suffix in SUFFIXES)


def decode(data: bytes) -> str:
    """Bytes of a model file as text: UTF-8 with or without mark, else Latin-1."""
    try:
        text = data.decode("utf-8").removeprefix("\ufeff")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n")
