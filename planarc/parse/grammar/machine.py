"""The machine that runs the grammar: a table as plain data, and its run over tokens.

In:   Table, list[Token]     states and rules; `$END` is the last token
Out:  the value of the text, as the builder's methods make it

`grammar` makes the table, by lark. lark's own machine needs its import and a rebuild of all
its objects, 65 ms in each process that parses a text, and reads 30 % fewer lines a second;
the tests hold that both give the same trees.

    states[s][kind]   n >= 0: shift, go on in state n; n < 0: reduce by rule ~n
    states[s][name]   the state after a rule of that name was reduced

Reference: A. V. Aho, R. Sethi, J. D. Ullman, Compilers, 1986, section 4.7.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.digest import blake2b
from planarc.parse.grammar.lexer import Token

#: States of the machine inside each other: a bound on the depth of a tree, other than by
#: operators in a row.
MAX_NESTING = 400

Reduction: TypeAlias = "Callable[[list[Any]], Any]"


class Rule(Data):
    """The way in which the `size` symbols of a rule become one.

    Its children are those at the places in `kept`, each as (place, whether it is a list whose
    items stand for it, how many absent optional ones are told before it as None).
    """

    name: str
    alias: str  # the builder's method; also for messages
    size: int
    single: bool  # a lone child stands for the rule
    kept: tuple[tuple[int, bool, int], ...]
    absent: int  # Nones at the end


class Table(Data):
    states: tuple[dict[str, int], ...]
    rules: tuple[Rule, ...]
    starts: dict[str, tuple[int, int]]  # first and last state
    terminals: tuple[tuple[str, str, bool], ...]  # name, pattern, whether it is a fixed text


class Kept(Data):
    """A table in a file, with what tells whether it is that of a grammar."""

    grammar: str  # the digest of its text
    table: Table


def digest(text: str) -> str:
    """A text that tells grammars apart."""
    return blake2b(text.encode("utf-8"), digest_size=16).hexdigest()


def reductions(table: Table, build: object) -> tuple[Reduction, ...]:
    """The method of `build` for each rule, by its name. A rule without one gives its children
    as a list, which becomes part of that of an outer rule."""
    return tuple(_reduction(rule, getattr(build, rule.alias, _as_list)) for rule in table.rules)


def _as_list(children: list[Any]) -> list[Any]:
    return children


def _reduction(rule: Rule, method: Reduction) -> Reduction:
    single, kept, absent = rule.single, rule.kept, rule.absent
    plain = not absent and kept == tuple((i, False, 0) for i in range(rule.size))

    def reduce(symbols: list[Any]) -> Any:
        children = symbols if plain else _chosen(symbols, kept, absent)
        return children[0] if single and len(children) == 1 else method(children)

    return method if plain and not single else reduce


def _chosen(symbols: list[Any], kept: Sequence[tuple[int, bool, int]], absent: int) -> list[Any]:
    children: list[Any] = []
    for place, is_list, nones in kept:
        if nones:
            children += [None] * nones
        if not is_list:
            children.append(symbols[place])
        elif children:
            children += symbols[place]
        else:
            children = symbols[place]  # a list that grows from the left is never copied
    if absent:
        children += [None] * absent
    return children


def run(table: Table, reduce: Sequence[Reduction], start: str, tokens: Sequence[Token]) -> Any:
    """The value of the whole text; None where a token does not fit.

    The last token has the kind `$END`. Raises PlanarcError P106.
    """
    states, rules = table.states, table.rules
    first, last = table.starts[start]
    stack, values = [first], list[Any]()
    for token in tokens:
        kind = token.type
        while True:
            action = states[stack[-1]].get(kind)
            if action is None:
                return None
            if action >= 0:
                stack.append(action)
                values.append(token)
                break
            rule = rules[~action]
            children: list[Any] = []
            if rule.size:
                children = values[-rule.size :]
                del values[-rule.size :], stack[-rule.size :]
            stack.append(states[stack[-1]][rule.name])
            values.append(reduce[~action](children))
            if stack[-1] == last and kind == "$END":
                return values[-1]
        if len(stack) > MAX_NESTING:
            raise PlanarcError(Diagnostic("P106", "this is nested too deeply", token.span))
    return None


class Item(NamedTuple):
    """One symbol of the parse so far."""

    state: int
    symbol: str  # a terminal or rule of the grammar
    first: int  # the place of its first token


Stack: TypeAlias = tuple[Item, ...]


class Automaton:
    """The machine on kinds of tokens alone, to try what could come next.

    `run` makes nodes and stops at the first error. What follows an error is only read to find
    further errors, and to try repairs: that needs no nodes, but stacks that can be kept and
    taken up again.
    """

    def __init__(self, table: Table, start: str) -> None:
        self.table, self._rules = table.states, table.rules
        first, self._end = table.starts[start]
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
        """The number of these tokens that can follow."""
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
