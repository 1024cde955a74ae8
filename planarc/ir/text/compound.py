"""The lines of equations and statements that hold others, in both trees of the language."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from planarc.ir import flat, syntax

_IF = syntax.IfEquation | syntax.IfStatement | flat.IfEquation | flat.IfStatement
_WHEN = syntax.WhenEquation | syntax.WhenStatement | flat.WhenEquation | flat.WhenStatement


class Compound:
    """`text` prints an expression, `head` the iterators of a loop, `plain` what holds no others."""

    def __init__(
        self,
        text: Callable[[Any], str],
        head: Callable[[Any], str],
        plain: Callable[[Any], str],
    ) -> None:
        self._text, self._head, self._plain = text, head, plain

    def lines(self, item: Any) -> Iterator[str]:
        """The lines of an equation or a statement, each ended by `;`."""
        if isinstance(item, _IF):
            yield from self._branches("if", item.branches)
            if item.otherwise:
                yield "else"
                yield from self.body(item.otherwise)
            yield "end if;"
        elif isinstance(item, _WHEN):
            yield from self._branches("when", item.branches)
            yield "end when;"
        elif isinstance(item, syntax.ForEquation | syntax.ForStatement | flat.ForStatement):
            yield f"for {self._head(item)} loop"
            yield from self.body(item.body)
            yield "end for;"
        elif isinstance(item, syntax.WhileStatement | flat.WhileStatement):
            yield f"while {self._text(item.condition)} loop"
            yield from self.body(item.body)
            yield "end while;"
        elif isinstance(item, syntax.Break | flat.Break):
            yield "break;"
        elif isinstance(item, syntax.Return | flat.Return):
            yield "return;"
        else:
            yield self._plain(item)

    def body(self, items: Iterable[Any]) -> Iterator[str]:
        return (f"  {line}" for item in items for line in self.lines(item))

    def _branches(self, word: str, branches: Iterable[tuple[Any, Any]]) -> Iterator[str]:
        for index, (condition, items) in enumerate(branches):
            yield f"{'else' if index else ''}{word} {self._text(condition)} then"
            yield from self.body(items)
