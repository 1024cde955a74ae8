"""Diagnostics as text and as data for JSON; the only place that knows their form.

Example:

    error[P101]: expected `;` after the equation
      --> spring.pmo:4:8
       |
     4 |   x = 1
       |        ^
      hint: end the equation with `;`
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from typing import TYPE_CHECKING

from planarc.core.resources import stdlib
from planarc.core.source import NOWHERE, Span

if TYPE_CHECKING:
    from planarc.core.diagnostic import Diagnostic

#: Columns of a source line that are shown; a longer one is cut on both sides.
WIDTH = 100

_COLORS = {"error": "\033[1;31m", "warning": "\033[1;33m", "note": "\033[1m"}
_BLUE, _BOLD, _RESET = "\033[1;34m", "\033[1m", "\033[0m"


def render_all(
    diagnostics: Iterable[Diagnostic], color: bool = False, verbose: bool = False
) -> str:
    """All diagnostics in source order, each once, an empty line between them."""
    return "\n".join(render(d, color, verbose) for d in _folded(in_order(diagnostics)))


def _folded(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """A warning inside of the place of an error is a note of that: one mistake, one message."""
    kept = list(diagnostics)
    for i, error in enumerate(kept):
        inside = [w for w in kept if error.severity.value == "error" and _is_inside(w, error)]
        if inside:
            kept[i] = error.noting(inside)
    return [d for d in kept if not any(_is_inside(d, other) for other in kept)]


def _is_inside(warning: Diagnostic, error: Diagnostic) -> bool:
    inner, outer = warning.span, error.span
    if inner is None or outer is None or inner.source.name != outer.source.name:
        return False
    severities = warning.severity.value, error.severity.value
    return severities == ("warning", "error") and outer.start <= inner.start < outer.end


def render(diagnostic: Diagnostic, color: bool = False, verbose: bool = False) -> str:
    """One diagnostic as lines that end with a line feed; `color` adds ANSI sequences, `verbose`
    the notes about libraries' insides, which tell whoever only uses them little."""
    head = f"{diagnostic.severity.value}[{diagnostic.code}]"
    paint = _COLORS[diagnostic.severity.value] if color else ""
    message = _printable(diagnostic.message)
    lines = [f"{_painted(head, paint)}{_painted(f': {message}', _BOLD if color else '')}"]
    if diagnostic.span is not None:
        lines += _place(diagnostic.span, color, paint)
    inside_hidden = not verbose and not _is_shipped(diagnostic.span)
    for related in diagnostic.related:
        if (inside_hidden and _is_shipped(related.span)) or (related.detail and not verbose):
            continue
        lines.append(f"  note: {_printable(related.message)}")
        if related.span is not None:
            lines += _place(related.span, color, _BLUE if color else "")
    if diagnostic.hint:
        lines.append(f"  {_painted('hint', _BOLD if color else '')}: {_printable(diagnostic.hint)}")
    return "\n".join(lines) + "\n"


def _is_shipped(span: Span | None) -> bool:
    """Whether a place is in a library that planarc brings along."""
    path = span.source.path if span is not None else None
    return path is not None and path.is_relative_to(stdlib())


def to_json(diagnostic: Diagnostic) -> dict[str, str | int | None]:
    """A diagnostic as `--json` prints it; without a place, file, line and column are null."""
    place = _located(diagnostic.span)
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity.value,
        "message": diagnostic.message,
        "file": place[0] if place else None,
        "line": place[1] if place else None,
        "column": place[2] if place else None,
        "hint": diagnostic.hint,
    }


def in_order(diagnostics: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """File by file as they first occur, then by place; what is said twice is kept once."""
    files: dict[str, int] = {}
    kept: dict[tuple[object, ...], tuple[tuple[int, int], Diagnostic]] = {}
    for diagnostic in diagnostics:
        span = diagnostic.span
        name, start, end = (span.source.name, span.start, span.end) if span else ("", -1, -1)
        place = (files.setdefault(name, len(files)), start)
        key = (diagnostic.code, diagnostic.message, name, start, end)
        kept.setdefault(key, (place, diagnostic))
    return tuple(d for _, d in sorted(kept.values(), key=lambda item: item[0]))


def _located(span: Span | None) -> tuple[str, int, int] | None:
    """File, line and column; None where no file holds the place or it cannot be read."""
    if span is None or span.source is NOWHERE.source:
        return None
    try:
        return span.source.name, span.line, span.column
    except OSError:  # the file is gone since it was read
        return span.source.name, 1, 1


def _place(span: Span, color: bool, paint: str) -> list[str]:
    place = _located(span)
    if place is None:
        return []
    name, line, column = place
    bar = _painted("|", _BLUE if color else "")
    number = str(line)
    gap = " " * (len(number) + 2)
    arrow = _painted("-->", _BLUE if color else "")
    lines = [f"{gap[:-1]}{arrow} {_printable(name)}:{line}:{column}"]
    try:
        text = span.source.line(line)
    except OSError:
        return lines
    if not text.strip() and not column <= len(text) + 1:
        return lines
    before, marked, after = _cut(text, column - 1, min(span.end - span.start, len(text)))
    shown = _painted(number, _BLUE if color else "")
    lines.append(f"{gap}{bar}")
    lines.append(f" {shown} {bar} {before}{marked}{after}".rstrip())
    carets = _painted("^" * max(1, _columns(marked)), paint)
    lines.append(f"{gap}{bar} {' ' * _columns(before)}{carets}")
    return lines


def _cut(text: str, at: int, length: int) -> tuple[str, str, str]:
    """A line before, at and after the marked place, at most `WIDTH` characters in all."""
    length = max(0, min(length, len(text) - at, WIDTH - 20))
    start = max(0, min(at - (WIDTH - length) // 2, len(text) - WIDTH)) if len(text) > WIDTH else 0
    stop = min(len(text), start + WIDTH)
    before = ("..." if start else "") + _printable(text[start:at])
    after = _printable(text[at + length : stop]) + ("..." if stop < len(text) else "")
    return before, _printable(text[at : at + length]), after


def _printable(text: str) -> str:
    """Tabs become a space and control characters a mark: text cannot steer the terminal."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else " " if c.isspace() else "\N{MIDDLE DOT}" for c in text)


def _columns(text: str) -> int:
    """The width of a text on a terminal, in columns."""
    if text.isascii():
        return len(text)
    wide = sum(unicodedata.east_asian_width(c) in "WF" for c in text)
    return len(text) + wide - sum(unicodedata.combining(c) != 0 for c in text)


def _painted(text: str, paint: str) -> str:
    return f"{paint}{text}{_RESET}" if paint else text
