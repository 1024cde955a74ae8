"""Makes a text that can be built of tokens that do not fit, with all classes that it begins.

In:   the tokens, as they are and as repaired
Out:  tokens of a whole text

    model A Real x; equation x = 1; der(     what is open at the end is closed: ... x = 1; end A;
    model A Real x; equation x.  end A;      a statement that hides an `end` is left out

Repairs serve messages, each told once; so they may leave out a whole class to go on behind it.
Where they did, statements are left out instead.
"""

from __future__ import annotations

from planarc.parse.grammar.lexer import Token
from planarc.parse.grammar.machine import Automaton, Stack, Table
from planarc.parse.repair.trouble import BLOCKS

#: The ways to close the innermost block or class.
_CLOSING = tuple(("END", kind, "SEMICOLON") for kind in (*BLOCKS, "IDENT"))
_ENDS = frozenset({"SEMICOLON", "EQUATION", "ALGORITHM", "THEN", "ELSE", "LOOP"})
_SECTIONS = frozenset({"EQUATION", "ALGORITHM", "INITIAL_SECTION", "PUBLIC", "PROTECTED"})
_NAMED = frozenset({"MODEL", "CLASS", "BLOCK", "TYPE", "PACKAGE", "RECORD", "CONNECTOR"})
_NAMED |= {"FUNCTION"}
_MOST = 200


def salvage(table: Table, start: str, tokens: list[Token], mended: list[Token]) -> list[Token]:
    """The tokens to build; the last of `tokens` is the end of the text."""
    automaton = Automaton(table, start)
    if leaves_out(tokens, mended):
        mended = _without_statements(automaton, tokens)
    return _closed(automaton, mended, tokens[-1])


def leaves_out(tokens: list[Token], mended: list[Token]) -> bool:
    """True where repairs left out a class."""
    return _classes(mended) < _classes(tokens)


def _classes(tokens: list[Token]) -> int:
    return sum(token.type in _NAMED for token in tokens)


def _without_statements(automaton: Automaton, tokens: list[Token]) -> list[Token]:
    """The tokens without the statements in which one does not fit."""
    kept: list[Token] = []
    stack, at = automaton.begin, 0
    begin, size = stack, 0
    while at < len(tokens) - 1:
        following = automaton.shift(stack, tokens[at].type, at)
        if following is not None:
            kept.append(tokens[at])
            stack = following
            at += 1
            if tokens[at - 1].type in _ENDS | _SECTIONS or _is_head(tokens, at):
                begin, size = stack, len(kept)
            continue
        del kept[size:]
        stack = begin
        at, closers = _next(automaton, stack, tokens, at)
        for kind in closers:
            stack = automaton.shift(stack, kind, at) or stack
            kept.append(Token(kind, "", tokens[at].span))
        begin, size = stack, len(kept)
    return kept


def _is_head(tokens: list[Token], at: int) -> bool:
    """True behind `model M`."""
    return at > 1 and tokens[at - 1].type == "IDENT" and tokens[at - 2].type in _NAMED


def _next(
    automaton: Automaton, stack: Stack, tokens: list[Token], at: int
) -> tuple[int, list[str]]:
    """The place where reading goes on, and what closes the blocks before it."""
    for place in range(at, len(tokens) - 1):
        kinds = [t.type for t in tokens[place : place + 2]]
        if kinds == ["END", "IDENT"]:
            closers: list[str] = []
            current = stack
            while automaton.advance(current, kinds) < 2:
                closed = _close_one(automaton, current, _CLOSING[:-1])
                if closed is None:
                    break
                closers += closed
                for kind in closed:
                    current = automaton.shift(current, kind, place) or current
            else:
                return place, closers
        behind = place > at and tokens[place - 1].type == "SEMICOLON"
        if (behind or kinds[0] in _SECTIONS) and automaton.advance(stack, kinds) == len(kinds):
            return place, []
    return len(tokens) - 1, []


def _closed(automaton: Automaton, tokens: list[Token], last: Token) -> list[Token]:
    """The tokens with what closes them and `last`, the end of the text."""
    stack, places = automaton.begin, [(0, automaton.begin)]
    for at, token in enumerate(tokens, 1):
        following = automaton.shift(stack, token.type, at)
        if following is None:
            break
        stack = following
        if at == len(tokens) or token.type in _ENDS:
            places.append((at, stack))
    for at, before in reversed(places[-_MOST:]):
        closing = _closing(automaton, before)
        if closing is not None:
            return [*tokens[:at], *(Token(kind, "", last.span) for kind in closing), last]
    return [last]


def _closing(automaton: Automaton, stack: Stack) -> list[str] | None:
    """The tokens after which the text may end."""
    added: list[str] = []
    while automaton.shift(stack, "$END", 0) is None:
        closed = _close_one(automaton, stack, _CLOSING)
        if closed is None or len(added) > _MOST:
            return None
        for kind in closed:
            stack = automaton.shift(stack, kind, 0) or stack
        added += closed
    return added


def _close_one(
    automaton: Automaton, stack: Stack, ways: tuple[tuple[str, ...], ...]
) -> tuple[str, ...] | None:
    return next((way for way in ways if automaton.advance(stack, way) == len(way)), None)
