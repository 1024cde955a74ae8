"""Formats a text: the indentation, the spaces in a line, and the blank lines.

In:   str   a text that parses
Out:  str   the same pieces in the same order and lines

The line breaks and comments are the writer's. More than one blank line becomes one; blank
space at the end of lines, and blank lines at the ends of the text, go. What stands in
strings and in comments over several lines is not touched.

Example:

    model  M
    Real x (start = 1) ;        model M
    equation                      Real x(start=1);
      der (x)=-x;               equation
    end M;                        der(x) = -x;
                                end M;

Promises:  the pieces stay as they are, so the tree does; formatting twice is formatting
           once; lines end as they did, with or without a carriage return.
"""

from __future__ import annotations

from planarc.catalog.format.indent import indent_lines
from planarc.catalog.format.pieces import cut
from planarc.catalog.format.spacing import blank_before
from planarc.core.diagnostic import error
from planarc.core.source import Source
from planarc.parse.parser import parse_text


def format_text(text: str) -> str:
    """The formatted text. Raises PlanarcError X002 rather than changing more than blank space."""
    mark = "\ufeff" if text.startswith("\ufeff") else ""
    body = text.removeprefix(mark)
    windows = "\r\n" in body and body.count("\r\n") == body.count("\n")
    if windows:
        body = body.replace("\r\n", "\n")
    formatted = _format(body)
    if _words(formatted) != _words(body):
        raise error("X002", "sorry, planarc cannot format this text")
    return mark + (formatted.replace("\n", "\r\n") if windows else formatted)


def format_source(source: Source) -> str:
    """The text of a source, formatted. Raises PlanarcError when it does not parse."""
    plain = source.text.removeprefix("\ufeff").replace("\r\n", "\n")
    parse_text(Source(source.name, plain))
    return format_text(source.text)


def _format(text: str) -> str:
    pieces = cut(text)
    lines = indent_lines(pieces)
    places = [line.place for line in lines]
    out: list[str] = []
    for i, piece in enumerate(pieces):
        if i == 0 or piece.lines_before:
            breaks = min(piece.lines_before, 2) if i else 0
            out.append("\n" * breaks + " " * lines[i].indent)
        else:
            out.append(blank_before(pieces, places, i))
        out.append(piece.text)
    return "".join(out) + "\n" if out else ""


def _words(text: str) -> list[str]:
    return [piece.text for piece in cut(text)]
