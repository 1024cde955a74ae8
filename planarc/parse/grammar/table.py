"""The automaton of the grammar as plain data, and its run over tokens.

lark makes the table from `grammar/modelica.lark`, see `grammar`. To run it
takes no more than the loop below, while lark's own needs its import and a rebuild of all
its objects, 35 ms in each process that parses a text.

    states[s][kind]   n >= 0: shift, go on in state n; n < 0: reduce by rule ~n
    states[s][name]   the state after a rule of that name was reduced
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import blake2b
from typing import Any

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.parse.grammar.lexer import Token

#: States of the automaton inside each other. It bounds how deep a tree is nested,
#: other than by operators in a row.
MAX_NESTING = 400

Reduction = Callable[[list[Any]], Any]


class Rule(Data):
    """What becomes of the `size` symbols of a rule when it is reduced.

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
    """Tells grammars apart."""
    return blake2b(text.encode("utf-8"), digest_size=16).hexdigest()


def reductions(table: Table, build: object) -> tuple[Reduction, ...]:
    """For each rule the method of `build` with its name. A rule without one gives its
    children as a list, to be put into that of an outer rule."""
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
