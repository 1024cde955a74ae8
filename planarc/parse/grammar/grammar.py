"""From the grammar's text to the automaton's table, by lark.

This is the only module that imports lark (40 ms). What it makes of `grammar/modelica.lark`
lies beside it, as `grammar/modelica.json`, so that it is needed only where the grammar was
changed; `pytest --update-golden tests/parse/test_machine.py` writes it again.
"""

from __future__ import annotations

from typing import Any

import msgspec
from lark import Lark
from lark.lexer import Lexer, PatternStr
from lark.parse_tree_builder import ExpandSingleChild
from lark.parsers.lalr_analysis import Shift

from planarc.parse.grammar.table import Rule, Table, digest

STARTS = ("stored_definition", "expression_text", "annotation_text")


class NoLexer(Lexer):
    """Stands where lark wants a lexer; `lexer.scan` makes the tokens."""

    def __init__(self, lexer_conf: Any) -> None: ...

    def lex(self, lexer_state: Any, parser_state: Any) -> Any:
        return iter(())


def make_table(text: str) -> Table:
    """The LALR(1) automaton of a grammar. lark raises an error where it has conflicts."""
    lark = make_lark(text)
    confs = {start: _conf(lark, start) for start in STARTS}
    conf = confs[STARTS[0]]
    numbers = {rule: i for i, rule in enumerate(lark.rules)}
    rules = tuple(_rule(rule, conf.callbacks[rule]) for rule in lark.rules)

    def action(entry: tuple[Any, Any]) -> int:
        kind, target = entry
        return target if kind is Shift else ~numbers[target]

    states = [
        {str(symbol): action(entry) for symbol, entry in sorted(conf.states[i].items(), key=str)}
        for i in range(len(conf.states))
    ]
    order = _order(states, [confs[start].start_state for start in STARTS])
    place = {old: new for new, old in enumerate(order)}
    return Table(
        tuple({s: place[n] if n >= 0 else n for s, n in states[i].items()} for i in order),
        rules,
        {start: (place[c.start_state], place[c.end_state]) for start, c in confs.items()},
        tuple(
            (t.name, t.pattern.value if fixed else t.pattern.to_regexp(), fixed)
            for t in lark.terminals
            for fixed in (isinstance(t.pattern, PatternStr),)
        ),
    )


def _order(states: list[dict[str, int]], starts: list[int]) -> list[int]:
    """The states as they are reached: lark numbers them differently in each process."""
    found = dict.fromkeys(starts)
    waiting = list(found)
    for state in waiting:
        for target in states[state].values():
            if target >= 0 and target not in found:
                found[target] = None
                waiting.append(target)
    return waiting


def table_text(text: str) -> str:
    """The table of a grammar as JSON, one line a state or rule."""
    table = make_table(text)

    def lines(values: Any) -> str:
        return ",\n".join(msgspec.json.encode(v).decode() for v in values)

    return (
        f'{{"grammar":"{digest(text)}","table":{{"states":[\n{lines(table.states)}\n],'
        f'"rules":[\n{lines(table.rules)}\n],"starts":{lines([table.starts])},'
        f'"terminals":[\n{lines(table.terminals)}\n]}}}}\n'
    )


def make_lark(text: str, build: object = None) -> Lark:
    """lark's own parser; `build` has a method for each rule."""
    return Lark(
        text,
        parser="lalr",
        lexer=NoLexer,
        start=list(STARTS),
        keep_all_tokens=True,
        transformer=build,
    )


def _conf(lark: Lark, start: str) -> Any:
    """lark's automaton (`lark.parsers.lalr_parser_state.ParseConf`)."""
    state: Any = lark.parse_interactive(start=start).parser_state
    return state.parse_conf


def _rule(rule: Any, callback: Any) -> Rule:
    """`callback` is what lark would call: a chain of wrappers around the builder's method."""
    size = len(rule.expansion)
    kept: list[tuple[int, bool, int]] = [(i, False, 0) for i in range(size)]
    absent = 0
    if hasattr(callback, "to_include"):
        absent = getattr(callback, "append_none", 0)
        kept = [
            (i, is_list, nones[0] if nones else 0) for i, is_list, *nones in callback.to_include
        ]
        callback = callback.node_builder
    single = isinstance(callback, ExpandSingleChild)
    name = str(rule.origin.name)
    return Rule(name, str(rule.alias or name), size, single, tuple(kept), absent)
