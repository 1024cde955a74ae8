"""Closes what a text leaves open at its end, so that what stands before can be built.

In:   the tokens as repaired     `model A Real x; equation x = 1; der(`
Out:  tokens of a whole text     `model A Real x; equation x = 1; end A;`

What follows the last `;` or section after which everything can be closed is left out.
"""

from __future__ import annotations

from planarc.parse.grammar.lexer import Token
from planarc.parse.grammar.machine import Automaton, Stack, Table
from planarc.parse.repair.trouble import BLOCKS

#: The ways to close the innermost block or class.
_CLOSING = tuple(("END", kind, "SEMICOLON") for kind in (*BLOCKS, "IDENT"))
_ENDS = frozenset({"SEMICOLON", "EQUATION", "ALGORITHM", "THEN", "ELSE", "LOOP"})
_MOST = 200


def close(table: Table, start: str, tokens: list[Token], last: Token) -> list[Token]:
    """The tokens with what closes them and `last`, the end of the text."""
    automaton = Automaton(table, start)
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
        for tried in _CLOSING:
            if automaton.advance(stack, tried) == len(tried):
                for kind in tried:
                    stack = automaton.shift(stack, kind, 0) or stack
                added += tried
                break
        else:
            return None
        if len(added) > _MOST:
            return None
    return added
