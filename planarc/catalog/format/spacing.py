"""The spaces between the pieces of one line.

in code         one space after a comma, none inside brackets, none before `;`
`=`             spaces in equations, none in modifiers and arguments; in declarations
                the writer chooses
`+ - * / ^ :`   the writer chooses, but the same on both sides; a sign has none after it
lists           after a comma the writer chooses, as in indices and annotations
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.catalog.format.pieces import (
    CALLED,
    CHOSEN,
    CLASS_KINDS,
    CLOSING,
    KEYWORDS,
    OPENING,
    SIGNS,
    SPACED,
    Kind,
    Piece,
)
from planarc.core.data import Data


class Place(Data):
    """The place of a piece."""

    brackets: int = 0  # how many are open before it
    equations: bool = False  # in an equation section
    loose: bool = False  # in a list, in indices or in an annotation


def blank_before(pieces: Sequence[Piece], places: Sequence[Place], i: int) -> str:
    """The blank space before piece i, where it does not begin a line."""
    piece = pieces[i]
    if piece.kind is Kind.LINE_COMMENT:
        return piece.blank.expandtabs(2) or " "
    return " " if _apart(pieces, places, i) else ""


def _apart(pieces: Sequence[Piece], places: Sequence[Place], i: int) -> bool:
    before, piece = pieces[i - 1], pieces[i]
    if before.comment or piece.comment:
        return True
    if piece.text in {",", ";"} | CLOSING or before.text in OPENING:
        return False
    if before.text == ",":
        return piece.blank != "" if places[i].loose else True
    if before.text == ";":
        return True
    if before.text == ".":
        return False
    if _is_operator(before):
        return not _is_sign(pieces, i - 1) and _spaced(pieces, places, i - 1)
    if _is_operator(piece):
        return _is_sign(pieces, i) or _spaced(pieces, places, i)
    if piece.text in {".", "(", "["}:
        return not _ends_operand(before) and before.text not in CALLED
    return True


def _is_operator(piece: Piece) -> bool:
    return piece.text in SPACED or piece.text in CHOSEN or piece.text == "="


def _is_sign(pieces: Sequence[Piece], i: int) -> bool:
    """True where piece i is a sign of what follows, not an operation on what stands before."""
    if pieces[i].text not in SIGNS:
        return False
    at = i - 1
    while at >= 0 and pieces[at].comment:
        at -= 1
    return at < 0 or not _ends_operand(pieces[at])


def _ends_operand(piece: Piece) -> bool:
    if piece.kind is Kind.WORD:
        return piece.text not in KEYWORDS
    return piece.kind in (Kind.NUMBER, Kind.STRING) or piece.text in CLOSING


def _spaced(pieces: Sequence[Piece], places: Sequence[Place], i: int) -> bool:
    """True where the operator i has spaces around it."""
    operator = pieces[i].text
    if operator in SPACED:
        return True
    if operator == "=" and i > 1 and pieces[i - 2].text in CLASS_KINDS:
        return True
    if operator == "=" and places[i].brackets:
        return False
    if operator == "=" and places[i].equations:
        return True
    around = (pieces[i], pieces[i + 1]) if i + 1 < len(pieces) else (pieces[i],)
    return any(piece.blank and not piece.lines_before for piece in around)
