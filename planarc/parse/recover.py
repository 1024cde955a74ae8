"""Finds every syntax error of a text, each once, by repairing and reading on.

In:   list[Token]        the tokens of a text that the parser refused
Out:  list[Diagnostic]   its errors in source order

Where a token does not fit, small repairs are tried (a token put in, left out or
replaced); the one after which most of the following tokens fit both names the
error (`hints`) and lets the reading go on. Where none helps, the text up to the
next `;` or section is skipped.

Example:

    x = 1           put in `;`      "expected `;` after the equation"
    y := 2;         `=` for `:=`    "an equation is written with `=`"

Needs:     a text that is wrong; a right one gives no error.
Promises:  reads each token a bounded number of times.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

from planarc.core.diagnostic import Diagnostic, Related
from planarc.parse.automaton import Automaton, Stack
from planarc.parse.hints import Repair, Trouble, explain
from planarc.parse.lexer import MAX_ERRORS, Token
from planarc.parse.machine import Machine

#: Tokens after a repair that are looked at, and how many of them have to fit.
_AHEAD = 8
_ENOUGH = 3
_FAR_AHEAD = 60
#: Places tried when text is skipped.
_MAX_SKIPS = 300

_BOUNDARIES = frozenset(
    {"SEMICOLON", "EQUATION", "ALGORITHM", "PUBLIC", "PROTECTED", "THEN", "ELSE", "LOOP"}
)
_RESTARTS = frozenset({"EQUATION", "ALGORITHM", "INITIAL_SECTION", "PUBLIC", "PROTECTED", "END"})
_CLOSERS = frozenset({"SEMICOLON", "COMMA", "RPAR", "RSQB", "RBRACE"})
_BLOCKS = ("IF", "FOR", "WHEN", "WHILE")
#: `2 x`, `2(a + b)`, `(a + b)(c + d)`
_PRODUCTS = frozenset(
    {(number, after) for number in ("INTEGER", "REAL") for after in ("IDENT", "LPAR")}
    | {("RPAR", "LPAR")}
)

#: The words that begin what this one goes on with.
_BEGINS = {"THEN": ("IF", "ELSEIF", "WHEN"), "LOOP": ("WHILE", "FOR"), "IN": ("FOR",)}

#: What is put in, most likely first.
_INSERTED: tuple[tuple[str, ...], ...] = (
    *(("SEMICOLON",), ("COMMA",), ("RPAR",), ("RSQB",), ("RBRACE",), ("THEN",), ("LOOP",)),
    *(("EQUAL",), ("ASSIGN",), ("IN",), ("ELSE", "IDENT")),
)
#: What is put in the place of a token.
_REPLACED = {
    "ASSIGN": ("EQUAL",),
    "EQUAL": ("ASSIGN", "RELATION", "IN"),
    "IDENT": ("THEN", "LOOP"),
}
_INSERTED_LAST: tuple[tuple[str, ...], ...] = (
    ("IDENT",),
    ("LPAR",),
    *((block, "SEMICOLON", "END") for block in _BLOCKS),
)
_INSERTED_LAST += tuple(("END", block, "SEMICOLON") for block in _BLOCKS)


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
        for kind in repair.inserted if repair.at >= at or repair.back_to == repair.at else ():
            self.add(Token(kind, "", token.span), at)


class _Place(NamedTuple):
    """Where a statement, equation or declaration begins."""

    stack: Stack
    at: int


def find_errors(
    machine: Machine, start: str, tokens: list[Token], lexical: list[Diagnostic]
) -> tuple[list[Diagnostic], list[Token]]:
    """The errors, and the tokens as they would be right."""
    automaton = Automaton(machine, start)
    kinds = [token.type for token in tokens]
    errors: list[Diagnostic] = []
    mended = _Mended()
    stack, at = automaton.begin, 0
    begin = _Place(stack, at)
    while at < len(tokens) and len(errors) < MAX_ERRORS:
        if kinds[at - 1] == "END" and kinds[at] == "IDENT" and at:
            stack = _compare_names(automaton, stack, tokens, at, errors, mended)
        following = automaton.shift(stack, kinds[at], at)
        if following is not None:
            if kinds[at] != "$END":
                mended.add(tokens[at], at)
            stack = following
            at += 1
            if kinds[at - 1] in _BOUNDARIES:
                begin = _Place(stack, at)
            continue
        trouble = Trouble(automaton, machine.terminals, stack, tokens, at, begin.at)
        repair = _choose(trouble, kinds, begin) or _skip(trouble, kinds, begin)
        error = explain(trouble, repair)
        if not _is_echo(error, errors):
            errors.append(error)
        if repair is None or kinds[at] == "$END":
            break
        mended.follow(repair, tokens[at], at)
        stack, at = repair.stack, repair.at
        begin = _Place(stack, at)
    return _without_echo(errors, lexical, tokens), mended.tokens


def _choose(trouble: Trouble, kinds: list[str], begin: _Place) -> Repair | None:
    """The repair after which most tokens fit."""
    automaton, at = trouble.automaton, trouble.at
    for known in (_misspelt_elseif, _stray_end, _first_word, _other_section):
        repair = known(trouble, kinds, begin)
        if repair is not None:
            return repair
    best: Repair | None = None
    best_score = 0
    for inserted, dropped in _candidates(trouble):
        stack: Stack | None = trouble.stack
        for kind in inserted:
            stack = automaton.shift(stack, kind, at) if stack else None
        if stack is None:
            continue
        ahead = kinds[at + dropped : at + dropped + _AHEAD]
        score = automaton.advance(stack, ahead)
        enough = 1 if inserted == ("SEMICOLON",) and trouble.on_new_line else _ENOUGH
        mended = inserted and "SEMICOLON" in ahead[:score]
        if score < min(enough, len(ahead)) and not mended and kinds[at] != "$END":
            continue
        if score > best_score:
            best, best_score = Repair(inserted, dropped, stack, at + dropped), score
    return best


def _candidates(trouble: Trouble) -> Iterator[tuple[tuple[str, ...], int]]:
    """What to put in, and how many tokens to leave out."""
    token, previous = trouble.token, trouble.previous
    if previous and (previous.type, token.type) in _PRODUCTS:
        yield ("TIMES",), 0
    for inserted in _INSERTED:
        yield inserted, 0
    if token.type == "$END":
        return
    for right in _REPLACED.get(token.type, ()):
        yield (right,), 1
    if token.text in trouble.terminals.keywords:
        yield ("IDENT",), 1
    if previous and previous.type == "END":
        for block in _BLOCKS:
            yield (block,), 1
        for name in (*_BLOCKS, "IDENT"):
            yield (name,), 0
    yield ("TIMES",), 0
    if token.type in _CLOSERS:  # rather an expression missing than one token too many
        yield ("IDENT",), 0
    yield (), 1
    for inserted in _INSERTED_LAST:
        yield inserted, 0


def _misspelt_elseif(trouble: Trouble, kinds: list[str], begin: _Place) -> Repair | None:
    word = trouble.tokens[begin.at]
    if begin.at != trouble.at - 1 or word.type != "IDENT":
        return None
    if word.text.lower() not in ("elif", "elsif", "elseif"):
        return None
    stack = trouble.automaton.shift(begin.stack, "ELSEIF", begin.at)
    return Repair(("ELSEIF",), 0, stack, trouble.at, begin.at) if stack else None


def _stray_end(trouble: Trouble, kinds: list[str], begin: _Place) -> Repair | None:
    """`end if` where no block is open."""
    at = trouble.at
    if begin.at != at - 1 or kinds[begin.at] != "END" or kinds[at] not in _BLOCKS:
        return None
    if trouble.automaton.shift(trouble.stack, "IDENT", at) is None:
        return None
    return Repair((), 1, begin.stack, at + 1 + (kinds[at + 1] == "SEMICOLON"), begin.at)


def _first_word(trouble: Trouble, kinds: list[str], begin: _Place) -> Repair | None:
    """`a > 1 then` without its `if`; `if;` without its `end`."""
    at, automaton = trouble.at, trouble.automaton
    if kinds[at] == "SEMICOLON" and kinds[at - 1] in _BLOCKS and begin.at == at - 1:
        tried = [("END",)]
    else:
        tried = [(block,) for block in _BEGINS.get(kinds[at], ())]
    best: Repair | None = None
    best_score = at - begin.at
    for inserted in tried:
        stack = automaton.shift(begin.stack, inserted[0], begin.at)
        if stack is None:
            continue
        score = automaton.advance(stack, kinds[begin.at : at + _FAR_AHEAD])
        if score > best_score:
            best, best_score = Repair(inserted, 0, stack, begin.at, begin.at), score
    return best


def _other_section(trouble: Trouble, kinds: list[str], begin: _Place) -> Repair | None:
    """An equation among the declarations, or a declaration among the equations."""
    automaton = trouble.automaton
    read = trouble.at - begin.at
    following = kinds[begin.at : begin.at + read + _ENOUGH]
    among_declarations = automaton.shift(begin.stack, "PARAMETER", begin.at) is not None
    for section in ("EQUATION", "ALGORITHM") if among_declarations else ("PUBLIC",):
        stack = automaton.shift(begin.stack, section, begin.at)
        if not stack or automaton.advance(stack, following) < len(following):
            continue
        if among_declarations:
            return Repair((section,), 0, stack, begin.at, begin.at)
        ended = kinds.index("SEMICOLON", trouble.at) if "SEMICOLON" in kinds[trouble.at :] else 0
        if ended:  # the declaration is left out
            return Repair((section,), 0, begin.stack, ended + 1, begin.at)
    return None


def _skip(trouble: Trouble, kinds: list[str], begin: _Place) -> Repair | None:
    """Go on after the next `;` or at the next section, in the innermost place that fits."""
    automaton = trouble.automaton
    outer = [trouble.stack[:size] for size in range(len(trouble.stack), 0, -1)]
    tried = 0
    for at in range(trouble.at + 1, len(kinds)):
        after_semicolon = kinds[at - 1] == "SEMICOLON"
        if not after_semicolon and kinds[at] not in _RESTARTS:
            continue
        ahead = kinds[at : at + _AHEAD]
        if after_semicolon and automaton.advance(begin.stack, ahead):
            return Repair((), at - trouble.at, begin.stack, at, begin.at)
        for stack in outer:
            if automaton.advance(stack, ahead) == len(ahead):
                left_out = trouble.stack[len(stack) :]
                back_to = left_out[0].first if left_out else None
                return Repair((), at - trouble.at, stack, at, back_to)
        tried += 1
        if tried > _MAX_SKIPS:
            break
    return None


def _compare_names(
    automaton: Automaton,
    stack: Stack,
    tokens: list[Token],
    at: int,
    errors: list[Diagnostic],
    mended: _Mended,
) -> Stack:
    """`end B` has to name the innermost class; if it names an outer one, an `end` is missing."""
    opened = [
        tokens[item.first]
        for before, item in pairwise(stack)
        if item.symbol == "IDENT" and before.symbol in ("class_kind", "EXTENDS")
    ]
    found = tokens[at]
    if automaton.shift(stack, "IDENT", at) is None:
        return stack
    while opened and opened[-1].type == "IDENT" and opened[-1].text != found.text:
        name = opened.pop()
        related = (Related(f"`{name.text}` begins here", name.span),)
        closed = automaton.shift(stack, "IDENT", at)
        ended = automaton.shift(closed, "SEMICOLON", at) if closed else None
        again = automaton.shift(ended, "END", at) if ended else None
        if again is None or all(outer.text != found.text for outer in opened):
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
    if error.code == "P113":
        return bool(errors) and errors[-1].code == "P113"
    stray = error.code == "P112" and error.message.startswith("no ")
    return stray and any(
        e.span and error.span and e.span.text == error.span.text.split()[-1] for e in errors
    )


def _without_echo(
    errors: list[Diagnostic], lexical: list[Diagnostic], tokens: list[Token]
) -> list[Diagnostic]:
    """Without those that only follow from an unreadable character or an open string."""
    lines = {e.span.line for e in lexical if e.span}
    cut_short = any(e.span and e.span.end >= tokens[-2].span.end for e in lexical if tokens[1:])
    kept = []
    for error in errors:
        if error.span is None or error.span.line in lines:
            continue
        if cut_short and error.span.start >= tokens[-2].span.end:
            continue
        kept.append(error)
    return kept
