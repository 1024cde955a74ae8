"""The indentation of each line: two spaces for every block that it stands in.

In:   Sequence[Piece]  all pieces of a text
Out:  list[Line]       for each piece where it stands, and the indentation of a line that
                       begins with it

What continues a line is indented once more (twice after the head of a block, so that it
is told from what the block holds); what stands in brackets once more than the line that
opened them.

Example:

    model M                        0
      Real x(                      2   an element
        start=1);                  4   in brackets
    equation                       0   a section
      if x > 0                     2
          and x < 1 then           6   the head of a block goes on
        x = 1                      4
          + 2;                     6   an equation goes on
      end if;                      2
    end M;                         0

Promises:  fails on no text and never recurses; depends on no blank space.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct

from planarc.catalog.format.pieces import (
    BLOCKS,
    BRANCHES,
    CLASS_KINDS,
    CLASS_PREFIXES,
    CLOSING,
    OPENING,
    SECTIONS,
    Kind,
    Piece,
)
from planarc.catalog.format.spacing import Place
from planarc.core.data import Data

STEP = 2  # spaces


class Line(Data):
    """A piece: the indentation of a line that begins with it, and where it stands."""

    indent: int
    place: Place


class _Bracket(Struct):
    inner: int  # indentation of the lines in it
    annotation: bool
    items: bool  # a list, or indices
    choices: int = 0  # if-expressions in it that wait for `then`


class _Walk:
    """Goes through the pieces and knows the blocks that are open."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = pieces
        self.blocks: list[str] = []  # `class`, or the word that opened the block
        self.equations: list[bool] = []  # of each open class: in an equation section
        self.brackets: list[_Bracket] = []
        self.begun = False  # inside of an element, equation or statement
        self.base = 0  # indentation of its first line
        self.head = ""  # the word of the head of a block that we are in
        self.head_end = -1  # the last piece of the head of a class that we are in
        self.choices = 0  # if-expressions outside of brackets that wait for `then`
        self.annotation = False  # the next bracket is an annotation's
        self.line = 0  # indentation of the line that we are in

    def step(self, i: int) -> Line:
        """The piece i, as a line that begins with it; then what it changes."""
        piece = self.pieces[i]
        place = Place(
            len(self.brackets),
            bool(self.equations and self.equations[-1]),
            bool(self.brackets and (self.brackets[-1].annotation or self.brackets[-1].items)),
        )
        line = Line(self._indent(i), place)
        if i == 0 or piece.lines_before:
            self.line = line.indent
        if not piece.comment:
            if self.brackets or piece.text in OPENING:
                self._bracket(piece)
            elif self.begun:
                self._inside(piece)
            else:
                self._begin(i)
            if i == self.head_end:
                self.blocks.append("class")
                self.equations.append(False)
                self.begun, self.head_end = False, -1
        return line

    def _indent(self, i: int) -> int:
        return self._first_indent(i) + (STEP if self._goes_deeper(i) else 0)

    def _goes_deeper(self, i: int) -> bool:
        """True where piece i is a branch of an if-expression, or continues its condition."""
        if i and (self.begun or self.brackets) and self.pieces[i - 1].text in {"then", "else"}:
            return True
        waiting = self.brackets[-1].choices if self.brackets else self.choices
        return waiting > 0 and self.pieces[i].text in {"and", "or"}

    def _first_indent(self, i: int) -> int:
        piece = self.pieces[i]
        if self.brackets:
            closers = self._closers(i)
            return self.brackets[-closers].inner - STEP if closers else self.brackets[-1].inner
        if self.begun:
            return self.base + (2 * STEP if self.head else STEP)
        level = len(self.blocks)
        dedented = piece.text in BRANCHES | SECTIONS | {"end", "external"} or (
            piece.text == "initial" and self._word(i + 1) in SECTIONS
        )
        return STEP * max(0, level - 1 if dedented else level)

    def _closers(self, i: int) -> int:
        """The number of brackets that the pieces from i on close, one after the other."""
        closed = 0
        while closed < len(self.brackets) and i + closed < len(self.pieces):
            if self.pieces[i + closed].text not in CLOSING:
                break
            closed += 1
        return closed

    def _bracket(self, piece: Piece) -> None:
        if piece.text in OPENING:
            inside = bool(self.brackets and self.brackets[-1].annotation)
            annotation = inside or self.annotation
            self.brackets.append(_Bracket(self.line + STEP, annotation, piece.text in "[{"))
            self.annotation = False
            if not self.begun:
                self.begun, self.base = True, self.line
        else:
            self.annotation = piece.text == "annotation"
            if piece.text in CLOSING:
                self.brackets.pop()
            elif piece.text in {"if", "elseif", "then"}:
                self.brackets[-1].choices += -1 if piece.text == "then" else 1

    def _begin(self, i: int) -> None:
        """The first word of an element, equation, statement, block or section."""
        word = self.pieces[i].text
        if word in SECTIONS:
            if self.equations and word in {"equation", "algorithm"}:
                self.equations[-1] = word == "equation"
            elif self.equations:
                self.equations[-1] = False
        elif word == "initial" and self._word(i + 1) in SECTIONS:
            pass
        elif word in BLOCKS:
            self.base = STEP * len(self.blocks)
            self.blocks.append(word)
            self.head, self.begun = word, True
        elif word in BRANCHES:
            if word != "else":
                self.base = STEP * max(0, len(self.blocks) - 1)
                self.head, self.begun = word, True
        elif word == "end":
            self._end(i)
            self.begun = True
        else:
            self.base = STEP * len(self.blocks)
            self.begun = True
            self.annotation = word == "annotation"
            if word in CLASS_KINDS | CLASS_PREFIXES:
                self.head_end = self._end_of_class_head(i)
        if word == ";":
            self.begun = False

    def _inside(self, piece: Piece) -> None:
        word = piece.text
        if self.head in {"for", "while"}:
            if word == "loop":
                self.head, self.begun = "", False
        elif word in {"if", "elseif"}:
            self.choices += 1
        elif word == "then" and self.choices:
            self.choices -= 1
        elif self.head and word == "then":
            self.head, self.begun = "", False
        elif word == ";" and not self.head:
            self.begun, self.choices = False, 0
        self.annotation = word == "annotation"

    def _end(self, i: int) -> None:
        self.base = STEP * max(0, len(self.blocks) - 1)
        if self._word(i + 1) in BLOCKS:
            if self.blocks and self.blocks[-1] != "class":
                self.blocks.pop()
            return
        while self.blocks and self.blocks.pop() != "class":
            pass
        if self.equations:
            self.equations.pop()

    def _end_of_class_head(self, i: int) -> int:
        """The last piece of the head of a class whose elements follow; -1 if there is none."""
        while self._word(i) in CLASS_PREFIXES:
            i = self._next(i)
        if self._word(i) not in CLASS_KINDS:
            return -1
        while self._word(i) in CLASS_KINDS:
            i = self._next(i)
        if self._word(i) == "extends":
            i = self._next(i)
            if self._word(self._next(i)) == "(":
                i = self._closing(self._next(i))
        elif self._word(self._next(i)) == "=":
            return -1
        while self._kind(self._next(i)) is Kind.STRING or self._word(self._next(i)) == "+":
            i = self._next(i)
        return i

    def _closing(self, i: int) -> int:
        depth = 0
        for k in range(i, len(self.pieces)):
            depth += (self.pieces[k].text in OPENING) - (self.pieces[k].text in CLOSING)
            if depth == 0:
                return k
        return len(self.pieces)

    def _next(self, i: int) -> int:
        i += 1
        while i < len(self.pieces) and self.pieces[i].comment:
            i += 1
        return i

    def _word(self, i: int) -> str:
        while i < len(self.pieces) and self.pieces[i].comment:
            i += 1
        return self.pieces[i].text if i < len(self.pieces) else ""

    def _kind(self, i: int) -> Kind | None:
        return self.pieces[i].kind if i < len(self.pieces) else None


def indent_lines(pieces: Sequence[Piece]) -> list[Line]:
    walk = _Walk(pieces)
    return [walk.step(i) for i in range(len(pieces))]
