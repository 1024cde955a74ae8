"""The table run on word types alone, to try what would come next.

The parser proper makes nodes and stops at the first error. What follows an error
is only read to find further errors, and to try repairs: that needs no nodes, but
stacks that can be kept and taken up again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, TypeAlias

from planarc.parse.grammar.machine import Machine


class Item(NamedTuple):
    """One symbol of the parse so far."""

    state: int
    symbol: str  # a terminal or rule of the grammar
    first: int  # the place of its first token


Stack: TypeAlias = tuple[Item, ...]


class Automaton:
    def __init__(self, machine: Machine, start: str) -> None:
        self.table, self._rules = machine.table.states, machine.table.rules
        first, self._end = machine.table.starts[start]
        self.begin: Stack = (Item(first, "", 0),)

    def shift(self, stack: Stack, kind: str, at: int) -> Stack | None:
        """The stack after one more token, None where that token cannot stand."""
        reduced = self._reduce(stack, kind)
        if reduced is None or kind == "$END":
            return reduced
        return (*reduced, Item(self.table[reduced[-1].state][kind], kind, at))

    def finished(self, stack: Stack, kind: str) -> list[str]:
        """The rules that end where a token of this kind stands, innermost first."""
        names: list[str] = []
        self._reduce(stack, kind, names)
        return names

    def accepts(self, stack: Stack) -> tuple[str, ...]:
        """The kinds of tokens that can come next, in the order of their names."""
        kinds = (kind for kind in self.table[stack[-1].state] if kind.isupper() or kind == "$END")
        return tuple(sorted(kind for kind in kinds if self._reduce(stack, kind) is not None))

    def advance(self, stack: Stack, kinds: Iterable[str]) -> int:
        """How many of these tokens can follow."""
        count = 0
        for kind in kinds:
            following = self.shift(stack, kind, 0)
            if following is None:
                break
            stack = following
            count += 1
        return count

    def _reduce(self, stack: Stack, kind: str, names: list[str] | None = None) -> Stack | None:
        """The stack just before `kind` is shifted."""
        top = list(stack)
        while True:
            if kind == "$END" and top[-1].state == self._end:
                return tuple(top)
            found = self.table[top[-1].state].get(kind)
            if found is None:
                return None
            if found >= 0:
                return tuple(top)
            rule = self._rules[~found]
            size = rule.size
            first = top[-size].first if size else top[-1].first
            if size:
                del top[-size:]
            top.append(Item(self.table[top[-1].state][rule.name], rule.name, first))
            if names is not None:
                names.append(rule.alias)
