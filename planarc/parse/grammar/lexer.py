"""Cuts a text into tokens, with what no regular expression can say.

In:   Source            one text
Out:  list[Token]       without spaces and comments, `$END` last; and the errors met

The terminals are those of `grammar/modelica.lark`. Three things depend on what
stands around a word and are decided here: the body of an annotation is skipped
and becomes one token; `end` inside brackets is a subscript; `initial` before
`equation` or `algorithm` opens a section.

Example:

    x[end] "d" annotation(Icon(a={1}));
    IDENT [ END_SUBSCRIPT ] STRING ANNOTATION ; $END

Promises:  fails on no text and never recurses.
Reference: Modelica Language Specification 3.6, chapter 2.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.source import Source, Span
from planarc.parse.grammar.unreadable import Unclosed, never_closed, skip_illegal

#: Characters of a name.
MAX_NAME = 1000
#: Errors after which the rest of a text is not read: it is no Modelica.
MAX_ERRORS = 20

_OPENING = {"LPAR": "RPAR", "LSQB": "RSQB", "LBRACE": "RBRACE"}
_CLOSING = frozenset(_OPENING.values())
_SPECIAL = frozenset({*_OPENING, *_CLOSING, "SEMICOLON", "END", "ANNOTATION", "_OPEN_COMMENT"})
_SECTIONS = frozenset({"EQUATION", "ALGORITHM"})

_AFTER_STRING = frozenset({*_CLOSING, "SEMICOLON", "COMMA", "PLUS", "ANNOTATION", "RELATION"})

_STRING = r'"(?:[^"\\]++|\\.)*+"'
_QUOTED = r"'(?:[^'\\\n]|\\.)+'"
_BLANK = re.compile(r"(?:\s+|//[^\n]*|/\*.*?\*/)*", re.DOTALL)
_BODY = re.compile(
    rf"""[^()"'/]+|{_STRING}|{_QUOTED}|//[^\n]*|/\*.*?\*/|/(?!\*)|(?P<open>\()|(?P<close>\))""",
    re.DOTALL,
)
_AFTER_END = r"\s+(?!(?:then|else|elseif|loop|and|or)\b|for\b(?!\s*;))[A-Za-z_]"


class Token(NamedTuple):
    type: str
    text: str
    span: Span


class Terminals(Data):
    """The words of the grammar: one expression, and the type of each fixed text."""

    pattern: re.Pattern[str]
    fixed: dict[str, str]  # text -> type: keywords and punctuation
    keywords: frozenset[str]


def compile_terminals(defined: Iterable[tuple[str, str, bool]]) -> Terminals:
    """The terminals of (name, pattern, whether that is a fixed text), as the grammar defines."""
    fixed = {"annotation": "ANNOTATION"}
    free: dict[str, str] = {}
    for name, pattern, is_text in defined:
        if is_text:
            fixed[pattern] = name
        else:
            free[name] = pattern
    skipped = "|".join(free.pop(name) for name in ("SPACE", "LINE_COMMENT", "BLOCK_COMMENT"))
    punctuation = sorted((t for t in fixed if not t[0].isalpha()), key=lambda t: (-len(t), t))
    names = ["IDENT", "REAL", "INTEGER", "STRING"]
    names += sorted(free.keys() - set(names))
    groups = [r"(?P<_OPEN_COMMENT>/\*)", *(f"(?P<{name}>{free[name]})" for name in names)]
    groups.append(f"(?P<_FIXED>{'|'.join(map(re.escape, punctuation))})")
    compiled = re.compile(f"(?:{skipped})*+(?:{'|'.join(groups)})?")
    return Terminals(compiled, fixed, frozenset(t for t in fixed if t[0].isalpha()))


def scan(
    source: Source, terminals: Terminals, start: int = 0, end: int | None = None
) -> tuple[list[Token], list[Diagnostic]]:
    """The tokens between two characters of a source."""
    text = source.text
    stop = len(text) if end is None else end
    tokens: list[Token] = []
    errors: list[Diagnostic] = []
    open_brackets: list[str] = []
    match, fixed, append = terminals.pattern.match, terminals.fixed, tokens.append
    at = start
    while True:
        found = match(text, at, stop)
        assert found is not None  # it matches the empty text too
        kind = found.lastgroup
        at = found.end()
        if kind is None:
            if at >= stop:
                break
            opening = _string_left_open(tokens) if text[at] == '"' else None
            if opening is not None:
                errors.append(never_closed("string", tokens[opening].span))
                del tokens[opening:]
                break
            at = skip_illegal(source, at, stop, errors)
            if len(errors) >= MAX_ERRORS:
                break
            continue
        begin = found.start(kind)
        word = text[begin:at]
        if kind == "IDENT" or kind == "_FIXED":
            kind = fixed.get(word, kind)
        span = Span(source, begin, at)
        if kind in _SPECIAL:
            if kind == "_OPEN_COMMENT":
                errors.append(never_closed("comment", span))
                break
            if kind == "ANNOTATION":
                span = _annotation_body(source, span, stop, errors)
                at = span.end
                if at == stop and errors:
                    break
            else:
                kind = _follow_brackets(kind, open_brackets, text, at)
        elif kind in _SECTIONS and tokens and tokens[-1].type == "INITIAL":
            tokens[-1] = tokens[-1]._replace(type="INITIAL_SECTION")
        elif at - begin > MAX_NAME and kind == "IDENT":
            message = f"this name has {at - begin} characters, {MAX_NAME} are allowed"
            errors.append(Diagnostic("P106", message, Span(source, begin, begin + 20)))
        append(Token(kind, word, span))
    append(Token("$END", "", Span(source, stop, stop)))
    return tokens, errors


def _follow_brackets(kind: str, open_brackets: list[str], text: str, at: int) -> str:
    """Keep account of open brackets; `end` between `[` and `]` is a subscript."""
    if kind in _OPENING:
        open_brackets.append(_OPENING[kind])
    elif kind in _CLOSING:
        if kind in open_brackets:
            while open_brackets.pop() != kind:
                pass
    elif kind == "END":
        if "RSQB" not in open_brackets:
            return kind
        if not re.compile(_AFTER_END).match(text, at):
            return "END_SUBSCRIPT"
        open_brackets.clear()  # `end Name`: a bracket was left open
    elif open_brackets and open_brackets[-1] != "RSQB":
        open_brackets.clear()  # `;` stands between brackets only in a matrix
    return kind


def _annotation_body(source: Source, word: Span, stop: int, errors: list[Diagnostic]) -> Span:
    """The parenthesised text after `annotation`; strings and comments may hold parentheses."""
    text = source.text
    blank = _BLANK.match(text, word.end, stop)
    begin = blank.end() if blank else word.end
    depth = 0
    at = begin
    while at < stop:
        found = _BODY.match(text, at, stop)
        if found is None or (depth == 0 and found.lastgroup != "open"):
            break
        at = found.end()
        if found.lastgroup == "open":
            depth += 1
        elif found.lastgroup == "close":
            depth -= 1
            if depth == 0:
                return Span(source, begin, at)
    if depth == 0:
        after = Span(source, begin, min(begin + 1, stop))
        errors.append(Diagnostic("P101", "expected `(` after `annotation`", after))
        return Span(source, word.start, word.end)
    message = "this annotation is never closed"
    related = []
    if at < stop:
        what = {'"': "string", "'": "quoted name"}.get(text[at], "comment")
        related.append(Related(f"this {what} is never closed", Span(source, at, at + 1)))
    errors.append(Unclosed("P103", message, word, related=tuple(related)))
    return Span(source, word.start, stop)


def _string_left_open(tokens: list[Token]) -> int | None:
    """The index of the string over several lines that took another's quote, if the last one
    has no partner.

    A string that ends where the next one begins is followed by words of that one.
    """
    for index, (token, following) in enumerate(pairwise(tokens)):
        if token.type == "STRING" and following.type not in _AFTER_STRING and "\n" in token.text:
            return index
    return None
