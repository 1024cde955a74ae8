"""Finds every syntax error of a text, each once, by repairing and reading on.

In:   list[Token]        the tokens of a text that the parser refused
Out:  list[Diagnostic]   its errors in source order, and the tokens as repaired

Where a token does not fit, `repairs` finds a small change after which the text
can be read on; it also tells what the error was, which `hints` puts in words.

Example:

    x = 1           put in `;`      "expected `;` after the equation"
    y := 2;         `=` for `:=`    "an equation is written with `=`"

Needs:     a text that is wrong; a right one gives no error.
Promises:  reads each token a bounded number of times.
"""

from __future__ import annotations

from bisect import bisect_left
from itertools import pairwise

from planarc.core.diagnostic import Diagnostic, Related
from planarc.parse.grammar.lexer import MAX_ERRORS, Token
from planarc.parse.grammar.machine import Automaton, Stack
from planarc.parse.language import Language
from planarc.parse.repair.declarations import is_end_of_two_words
from planarc.parse.repair.habits import joined_end
from planarc.parse.repair.hints import explain
from planarc.parse.repair.quotes import Unquoted
from planarc.parse.repair.repairs import Place, find_repair
from planarc.parse.repair.trouble import Repair, StrayEnd, Trouble, WrongSection

#: After these a new statement, equation or declaration begins.
_BOUNDARIES = frozenset(
    {"SEMICOLON", "EQUATION", "ALGORITHM", "PUBLIC", "PROTECTED", "THEN", "ELSE", "LOOP"}
)


class _Mended:
    """The tokens read so far, with the repairs made."""

    def __init__(self) -> None:
        self._places: list[int] = []  # the token of the text that each belongs to
        self.tokens: list[Token] = []

    def add(self, token: Token, at: int) -> None:
        self._places.append(at)
        self.tokens.append(token)

    def follow(self, repair: Repair, token: Token, at: int) -> None:
        if repair.back_to is not None:
            size = bisect_left(self._places, repair.back_to)
            del self._places[size:]
            del self.tokens[size:]
        for kind in repair.inserted:
            self.add(Token(kind, "", token.span), at)


def find_errors(
    language: Language, start: str, tokens: list[Token], lexical: list[Diagnostic]
) -> tuple[list[Diagnostic], list[Token]]:
    """The errors, and the tokens as they would be right."""
    automaton = Automaton(language.table, start)
    kinds = [token.type for token in tokens]
    errors: list[Diagnostic] = []
    mended = _Mended()
    stack, at = automaton.begin, 0
    begin = Place(stack, at)
    while at < len(tokens) and len(errors) < MAX_ERRORS:
        if kinds[at - 1] == "END" and kinds[at] == "IDENT" and at:
            stack = _compare_names(automaton, stack, tokens, at, errors, mended)
        following = automaton.shift(stack, kinds[at], at)
        trouble = Trouble(automaton, language.terminals, stack, tokens, at, begin.at)
        if following is not None and not joined_end(trouble):  # `endif;` would be an equation
            if kinds[at] != "$END":
                mended.add(tokens[at], at)
            stack = following
            at += 1
            if kinds[at - 1] in _BOUNDARIES:
                begin = Place(stack, at)
            continue
        repair = find_repair(trouble, begin)
        error = explain(trouble, repair)
        if not _is_echo(error, errors):
            errors.append(error)
        if repair is None or kinds[at] == "$END":
            break
        mended.follow(repair, tokens[at], at)
        stack, at = repair.stack, repair.at
        begin = Place(stack, at)
    return _without_echo(errors, lexical, tokens), mended.tokens


def _compare_names(
    automaton: Automaton,
    stack: Stack,
    tokens: list[Token],
    at: int,
    errors: list[Diagnostic],
    mended: _Mended,
) -> Stack:
    """Report an `end B` that does not name the innermost class; if it names an outer one, an
    `end` is missing."""
    opened = [
        item.first
        for before, item in pairwise(stack)
        if item.symbol == "IDENT" and before.symbol in ("class_kind", "EXTENDS")
    ]
    found = tokens[at]
    if automaton.shift(stack, "IDENT", at) is None:
        return stack
    while opened and tokens[opened[-1]].type == "IDENT" and tokens[opened[-1]].text != found.text:
        first = opened.pop()
        if is_end_of_two_words(tokens, first, found):
            break
        name = tokens[first]
        related = (Related(f"`{name.text}` begins here", name.span),)
        closed = automaton.shift(stack, "IDENT", at)
        ended = automaton.shift(closed, "SEMICOLON", at) if closed else None
        again = automaton.shift(ended, "END", at) if ended else None
        if again is None or all(tokens[outer].text != found.text for outer in opened):
            message = f"`end {found.text}` does not match `{name.text}`"
            hint = f"write `end {name.text}`"
            errors.append(Diagnostic("P102", message, found.span, hint=hint, related=related))
            break
        message = f"missing `end {name.text};` before `end {found.text}`"
        errors.append(Diagnostic("P112", message, found.span, related=related))
        stack = again
        for kind in ("IDENT", "SEMICOLON", "END"):
            mended.add(Token(kind, "", found.span), at)
    return stack


def _is_echo(error: Diagnostic, errors: list[Diagnostic]) -> bool:
    """One missing section makes many equations wrong, one word that cannot stand its `end`."""
    if isinstance(error, WrongSection):
        return bool(errors) and isinstance(errors[-1], WrongSection)
    last = errors[-1].span if errors else None
    if last and error.span and last.start <= error.span.start and error.span.end <= last.end:
        return True
    if last and error.span and last.text.startswith("der(") and error.span.start == last.end:
        return True  # what follows an operator in the place of a name
    return isinstance(error, StrayEnd) and any(
        e.span and error.span and e.span.text == error.span.text.split()[-1] for e in errors
    )


def _without_echo(
    errors: list[Diagnostic], lexical: list[Diagnostic], tokens: list[Token]
) -> list[Diagnostic]:
    """The errors without those that only follow from an unreadable character or an open string."""
    lines = {e.span.line for e in lexical if e.span}
    cut_short = any(e.span and e.span.end >= tokens[-2].span.end for e in lexical if tokens[1:])
    kept = []
    for error in errors:
        if error.span is None or (error.span.line in lines and not isinstance(error, Unquoted)):
            continue
        if cut_short and error.span.start >= tokens[-2].span.end:
            continue
        kept.append(error)
    return kept
