"""Texts that stand without their quotes: messages, values of Strings, descriptions.

In:   Trouble            a token that does not fit
Out:  range | Unquoted   the tokens of the text, and the message about them

Example: `assert(x > 0, The wheel has left the ground)` wants quotes, and no operator between `The`
and `wheel`.

Promises:  says so only where a text is expected and words follow each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from planarc.core.diagnostic import Diagnostic
from planarc.core.mend import Write
from planarc.parse.grammar.lexer import Token
from planarc.parse.repair.trouble import Repair, Trouble

#: Modifiers whose values are texts.
_TEXTS = frozenset(
    (
        "unit",
        "displayUnit",
        "quantity",
        "fileName",
        "tableName",
        "info",
        "revisions",
        "group",
        "tab",
    )
)
_KINDS = frozenset(("MODEL", "BLOCK", "CLASS", "PACKAGE", "CONNECTOR", "RECORD", "FUNCTION"))
#: What begins the computation of a text; `String x` is a declaration.
_COMPUTING = ("if", "String")
_OPENING = frozenset(("LPAR", "LSQB", "LBRACE"))
_CLOSING = frozenset(("RPAR", "RSQB", "RBRACE"))
#: Words of a description, at least: fewer may be a declaration whose `;` was forgotten.
_DESCRIBING = 3
#: Letters of a text that a hint repeats.
_SHORT = 60


class Unquoted(Diagnostic):
    """A text without quotes: what cannot be read inside of it is no error of its own."""


def unquoted(trouble: Trouble) -> range | None:
    """The tokens of the text without quotes in which a token does not fit."""
    first = _begin_of_text(trouble)
    if first is None:
        return _description(trouble)
    tokens, depth = trouble.tokens, 0
    if tokens[first].type == "END":  # of the class: what stood before it is none of its words
        return None
    for end in range(first, len(tokens)):
        kind = tokens[end].type
        depth += (kind in _OPENING) - (kind in _CLOSING)
        if kind == "STRING" or tokens[end].text in _COMPUTING:
            return None  # a text is there already, or computed, and something else is wrong
        if depth < 0 or kind in ("SEMICOLON", "$END") or (kind == "COMMA" and _ends(tokens, end)):
            words = any(_is_word(a) and _is_word(b) for a, b in pairwise(tokens[first:end]))
            return range(first, end) if words and first <= trouble.at <= end else None
    return None


def _begin_of_text(trouble: Trouble) -> int | None:
    """The first token where a text is expected, in the statement up to the trouble."""
    tokens, begin = trouble.tokens, trouble.begin
    places: list[int] = []  # the open brackets
    commas: list[int] = []  # for each, those inside of it
    first = None
    for at in range(begin, trouble.at):
        token, before = tokens[at], tokens[at - 1].text if at > begin else ""
        if token.type in _OPENING:
            places.append(at)
            commas.append(0)
            if before == "terminate":
                first = at + 1
        elif token.type in _CLOSING and places:
            commas.pop()
            opened = places.pop()
            if first is not None and opened < first <= at:
                first = None
        elif token.type == "COMMA" and places:
            commas[-1] += 1
            if commas[-1] == 1 and places[-1] > begin and tokens[places[-1] - 1].text == "assert":
                first = at + 1
        elif token.type == "EQUAL" and first is None:
            declared = not places and any(t.text == "String" for t in tokens[begin:at])
            if before in _TEXTS or declared:
                first = at + 1
    return first


def _ends(tokens: Sequence[Token], comma: int) -> bool:
    """Whether a comma ends the text: another modifier or the level of an assertion follows."""
    following = [t.type for t in tokens[comma + 1 : comma + 3]]
    return following == ["IDENT", "EQUAL"] or tokens[comma + 1].text == "AssertionLevel"


def _is_word(token: Token) -> bool:
    return token.text[:1].isalpha()


def _description(trouble: Trouble) -> range | None:
    """The words behind a declaration or an equation, on its line up to its `;`, and those behind
    the name of a class up to the end of the line."""
    tokens, at = trouble.tokens, trouble.at
    for first in range(max(at - _DESCRIBING + 1, 2), at):
        if tokens[first - 2].type in _KINDS and tokens[first - 1].type == "IDENT":
            words = range(first, _end_of_words(tokens, first))
            return words if _describes(tokens, words, ended=True) and at in words else None
    if "STRING" not in trouble.accepted or trouble.on_new_line or trouble.open_bracket is not None:
        return None
    words = range(at, _end_of_words(tokens, at))
    return words if _describes(tokens, words, ended=False) else None


def _end_of_words(tokens: Sequence[Token], first: int) -> int:
    line = tokens[first].span.line
    more = range(first, len(tokens))
    return next((k for k in more if not _is_word(tokens[k]) or tokens[k].span.line != line), first)


def _describes(tokens: Sequence[Token], words: range, ended: bool) -> bool:
    """Whether words are no declaration, and end with their line or, behind others, at a `;`."""
    if len(words) < _DESCRIBING or any(t.type != "IDENT" for t in tokens[words[0] : words[2]]):
        return False
    after = tokens[words.stop]
    on_a_line = after.span.line == tokens[words[-1]].span.line
    return not on_a_line if ended else on_a_line and after.type == "SEMICOLON"


def explain_unquoted(trouble: Trouble, repair: Repair | None) -> Diagnostic | None:
    """Explain `terminate(The end)`."""
    found = unquoted(trouble)
    if found is None:
        return None
    span = trouble.tokens[found[0]].span.to(trouble.tokens[found[-1]].span)
    after = trouble.tokens[found.stop].span.start
    more = span.source.text[span.end : after].rstrip()  # signs that no token has: `Take care!`
    span = span._replace(end=span.end + len(more))
    written = f'"{span.text}"'
    hint = f"write `{written}`" if len(written) < _SHORT else 'write it as `"..."`'
    mend = Write(written) if '"' not in span.text and "\n" not in span.text else None
    return Unquoted("P101", "a text stands in double quotes", span, hint=hint, mend=mend)
