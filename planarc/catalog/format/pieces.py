"""Cuts a text into pieces that, joined, are the text again: the formatter loses nothing.

In:   str          a text that parses
Out:  list[Piece]  words, numbers, strings, operators and comments, each with the blank
                   space before it

Example:

    x = 1; // one
    x| =| 1|;| // one|        the blank space before each piece is `blank`

Promises:  fails on no text.
Reference: Modelica Language Specification 3.6, chapter 2.
"""

from __future__ import annotations

import re
from enum import Enum, auto

from planarc.core.data import Data


class Kind(Enum):
    WORD = auto()  # names and keywords
    NUMBER = auto()
    STRING = auto()
    OPERATOR = auto()  # and punctuation
    LINE_COMMENT = auto()
    BLOCK_COMMENT = auto()


class Piece(Data):
    kind: Kind
    text: str
    blank: str  # the blank space before it

    @property
    def comment(self) -> bool:
        return self.kind in (Kind.LINE_COMMENT, Kind.BLOCK_COMMENT)

    @property
    def lines_before(self) -> int:
        """The number of line ends between this piece and the one in front of it."""
        return self.blank.count("\n")


_PIECE = re.compile(
    r"""(?P<blank>\s*)(?:
      (?P<LINE_COMMENT>//[^\n]*)
    | (?P<BLOCK_COMMENT>/\*.*?\*/)
    | (?P<STRING>"(?:[^"\\]++|\\.)*+")
    | (?P<WORD>[A-Za-z_][A-Za-z_0-9]*|'(?:[^'\\\n]|\\.)+')
    | (?P<NUMBER>\d+(?:\.\d*(?:[eE][+-]?\d+)?|[eE][+-]?\d+)?)
    | (?P<OPERATOR>:=|==|<>|<=|>=|\.[-+*/^]|\S)
    )""",
    re.DOTALL | re.VERBOSE,
)


def cut(text: str) -> list[Piece]:
    pieces = []
    for found in _PIECE.finditer(text):
        kind = found.lastgroup
        assert kind is not None
        words = found[kind].rstrip() if kind == "LINE_COMMENT" else found[kind]
        pieces.append(Piece(Kind[kind], words, found["blank"]))
    return pieces
