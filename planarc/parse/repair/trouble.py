"""A token that does not fit, its repair, and what is seen from there.

`repairs` looks for what mends a trouble, `hints` says it in words.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

from planarc.core.diagnostic import Diagnostic, Related
from planarc.core.mend import Write
from planarc.core.source import Span
from planarc.parse.grammar.lexer import Terminals, Token
from planarc.parse.grammar.machine import Automaton, Stack

#: The words that open a block, as terminals and as written.
BLOCKS = {"IF": "if", "FOR": "for", "WHEN": "when", "WHILE": "while"}
_ELSE_IF = ("ELSE", "IF")
#: What ends an `if` between an `end` and what that one closes.
ELSE_IF_ENDED = ("IF", "SEMICOLON", "END")


def instead(
    message: str, span: Span, new: str, code: str = "P101", related: tuple[Related, ...] = ()
) -> Diagnostic:
    """The message that names what to write in the place of something."""
    return Diagnostic(code, message, span, hint=f"write `{new}`", related=related, mend=Write(new))


class StrayEnd(Diagnostic):
    """An `end if` for which no `if` is open."""


class WrongSection(Diagnostic):
    """An equation among declarations, or the like: one missing word makes many of them."""


class Trouble(NamedTuple):
    """A token that does not fit."""

    automaton: Automaton
    terminals: Terminals
    stack: Stack  # before that token
    tokens: list[Token]
    at: int
    begin: int  # first token of the statement, equation or declaration

    @property
    def token(self) -> Token:
        return self.tokens[self.at]

    @property
    def previous(self) -> Token | None:
        return self.tokens[self.at - 1] if self.at else None

    @property
    def on_new_line(self) -> bool:
        """Whether a line ends between the last token that fits and this one."""
        if not self.at:
            return False
        between = self.token.span._replace(start=self.tokens[self.at - 1].span.end)
        return "\n" in between.source.text[between.start : self.token.span.start]

    @property
    def accepted(self) -> tuple[str, ...]:
        return self.automaton.accepts(self.stack)

    @property
    def after(self) -> Span:
        """The character after the last token that fits."""
        previous = self.previous
        if previous is None:
            return self.token.span
        return previous.span._replace(start=previous.span.end, end=previous.span.end + 1)

    @property
    def here(self) -> Span:
        return self.after if self.token.type == "$END" else self.token.span

    @property
    def opened_index(self) -> int | None:
        """The token, a word or a name, that the next `end` would close."""
        for before, item in reversed(tuple(pairwise(self.stack))):
            named = item.symbol == "IDENT" and before.symbol in ("class_kind", "EXTENDS")
            if named or item.symbol in BLOCKS:
                return item.first
        return None

    @property
    def opened(self) -> Token | None:
        index = self.opened_index
        return None if index is None else self.tokens[index]

    @property
    def open_ifs(self) -> list[int]:
        """The `if`s that are open here, in nothing else that has an `end`, innermost first."""
        found: list[int] = []
        for before, item in reversed(tuple(pairwise(self.stack))):
            named = item.symbol == "IDENT" and before.symbol in ("class_kind", "EXTENDS")
            if named or (item.symbol in BLOCKS and item.symbol != "IF"):
                break
            if item.symbol == "IF":
                found.append(item.first)
        return found

    @property
    def else_if(self) -> Span | None:
        """The first `else if` in the `if`s that are open here."""
        opened = self.open_ifs
        since = self.tokens[opened[-1] : self.at] if opened else []
        pairs = ((a.span, b.span) for a, b in pairwise(since) if (a.type, b.type) == _ELSE_IF)
        return next((a.to(b) for a, b in pairs), None)

    @property
    def opening(self) -> tuple[Related, ...]:
        """The note where that stands."""
        opened = self.opened
        return (Related(f"`{opened.text}` begins here", opened.span),) if opened else ()

    @property
    def open_bracket(self) -> Token | None:
        closed = 0
        for item in reversed(self.stack):
            closed += item.symbol in ("RPAR", "RSQB", "RBRACE")
            if item.symbol in ("LPAR", "LSQB", "LBRACE"):
                if not closed:
                    return self.tokens[item.first]
                closed -= 1
        return None

    @property
    def open_symbols(self) -> set[str]:
        """The symbols since the last bracket, comma or boundary."""
        symbols: set[str] = set()
        for item in reversed(self.stack):
            if item.symbol in ("LPAR", "LSQB", "LBRACE", "COMMA", "SEMICOLON", "EQUAL", "ASSIGN"):
                break
            if item.symbol in ("AND", "OR", "PLUS", "SIGN", "TIMES", "EACH_TIMES") and not symbols:
                break
            symbols.add(item.symbol)
        return symbols

    @property
    def in_equations(self) -> bool:
        return self.inside("equation_section") or self.inside("EQUATION")

    def inside(self, symbol: str) -> bool:
        return any(item.symbol == symbol for item in self.stack)

    def text_of(self, kind: str) -> str:
        names = {"PLUS": "+", "SIGN": "-", "TIMES": "*", "RELATION": "<", "POWER": "^"}
        texts = {name: text for text, name in self.terminals.fixed.items()}
        return names.get(kind) or texts.get(kind) or kind.lower()


class Repair(NamedTuple):
    """The mend of a trouble, and the place where reading goes on."""

    inserted: tuple[str, ...]
    dropped: int
    stack: Stack
    at: int
    back_to: int | None = None  # the first token before the trouble that is left out too


def shown(token: Token) -> str:
    if token.type == "$END":
        return "the end of the text"
    text = token.text if len(token.text) <= 30 else f"{token.text[:27]}..."
    return "an annotation" if token.type == "ANNOTATION" else f"`{text}`".replace("\n", " ")
