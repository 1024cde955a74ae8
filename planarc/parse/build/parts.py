"""What the builders hand each other: lists and words with the place they stand at."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic
from planarc.core.source import NOWHERE, Span
from planarc.ir import syntax
from planarc.parse.grammar.lexer import Token

T = TypeVar("T")


class Part(Data):
    """A piece that is no node of the tree: subscripts, arguments, a dotted name."""

    value: Any
    span: Span


class Description(Data):
    comment: str = ""
    annotation: syntax.Annotation | None = None


def cover(children: Iterable[Any]) -> Span:
    """The span from the first to the last of the children that stand somewhere."""
    spans: list[Span] = [child.span for child in children if hasattr(child, "span")]
    return spans[0].to(spans[-1])


def nodes(children: Iterable[Any]) -> tuple[Any, ...]:
    """The children without punctuation and without what was left out."""
    return tuple(c for c in children if c is not None and not isinstance(c, Token))


def texts(name: Part) -> tuple[str, ...]:
    """The words of a dotted name."""
    return tuple(word.text for word in name.value)


def separated(children: Iterable[Any]) -> list[Any]:
    """The children between commas; None where nothing stands."""
    items: list[Any] = [None]
    for child in children:
        if isinstance(child, Token):
            items.append(None)
        else:
            items[-1] = child
    return items


def made(
    node: Callable[..., T], fields: Callable[[list[Any]], Iterable[Any]]
) -> Callable[[Builder, list[Any]], T]:
    """A builder's method: the node over all children of a rule, with its fields from these."""

    def method(self: Builder, c: list[Any]) -> T:
        return node(cover(c), *fields(c))

    return method


def part(value: Callable[[list[Any]], Any]) -> Callable[[Builder, list[Any]], Part]:
    """A builder's method: a piece over all children of a rule, with its value from these."""
    return made(lambda span, given: Part(given, span), lambda c: (value(c),))


class Builder:
    """Collects what the grammar lets pass and the language forbids."""

    def __init__(self) -> None:
        self.errors: list[Diagnostic] = []
        self.whole = NOWHERE  # the whole text
        self.chains: dict[int, int] = {}  # operators in a row, by the id of the last one

    def begin(self, whole: Span) -> None:
        """Forget the text before this one."""
        self.errors = []
        self.whole = whole
        self.chains = {}

    def refuse(self, code: str, message: str, span: Span, hint: str | None = None) -> None:
        self.errors.append(Diagnostic(code, message, span, hint=hint))

    def check_order(self, words: Iterable[Token], order: tuple[tuple[str, ...], ...]) -> None:
        """Report prefixes out of order, and two of one kind."""
        last: Token | None = None
        reached = -1
        for word in words:
            rank = next(i for i, group in enumerate(order) if word.text in group)
            if last is not None and rank == reached:
                self.refuse("P107", f"`{word.text}` cannot follow `{last.text}`", word.span)
            elif last is not None and rank < reached:
                hint = f"write `{word.text} {last.text}`"
                message = f"`{word.text}` stands before `{last.text}`"
                self.refuse("P107", message, word.span, hint)
            last, reached = word, rank
