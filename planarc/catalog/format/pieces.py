"""Cuts a text into pieces that, joined, are the text again: the formatter loses nothing.

In:   str          a text that parses
Out:  list[Piece]  words, numbers, strings, operators and comments, each with the blank
                   space before it

Example:

    x = 1; // one
    x| =| 1|;| // one|        the blank space before each piece is `blank`

Promises:  fails on no text.
Reference: Modelica Language Specification 3.6, chapter 2 and appendix A.
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


# Words that tell where lines, blocks and classes begin and end

OPENING = {"(": ")", "[": "]", "{": "}"}
CLOSING = frozenset(OPENING.values())

#: What may stand before the kind of a class.
CLASS_PREFIXES = frozenset(
    {"encapsulated", "partial", "final", "inner", "outer", "replaceable", "redeclare"}
    | {"pure", "impure", "expandable"}
)
CLASS_KINDS = frozenset(
    {"class", "model", "block", "type", "package", "record", "connector", "function", "operator"}
)
SECTIONS = frozenset({"public", "protected", "equation", "algorithm"})
BLOCKS = frozenset({"if", "for", "when", "while"})
BRANCHES = frozenset({"else", "elseif", "elsewhen"})

#: Words after which a parenthesis or a sign does not continue an operand.
KEYWORDS = (
    CLASS_PREFIXES
    | CLASS_KINDS
    | SECTIONS
    | BLOCKS
    | BRANCHES
    | {"and", "or", "not", "in", "then", "loop", "break", "return", "connect", "within", "import"}
    | {"extends", "constrainedby", "each", "external", "constant", "parameter", "discrete"}
    | {"flow", "stream", "input", "output"}
)

#: Keywords that are followed by a parenthesis as a function's name is.
CALLED = frozenset({"connect", "break"})
#: Operators with a space on both sides, wherever they stand.
SPACED = frozenset({":=", "==", "<>", "<", "<=", ">", ">="})
#: Operators whose spaces are the writer's choice, but on both sides or on none.
CHOSEN = frozenset({"+", "-", "*", "/", "^", ":", ".+", ".-", ".*", "./", ".^"})
SIGNS = frozenset({"+", "-", ".+", ".-"})
