"""From the grammar's text to the automaton's table, by lark.

This is the only module that imports lark (40 ms).
"""

from __future__ import annotations

from typing import Any

from lark import Lark
from lark.lexer import Lexer, PatternStr
from lark.parse_tree_builder import ExpandSingleChild
from lark.parsers.lalr_analysis import Shift

from planarc.parse.table import Rule, Table

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

    return Table(
        tuple(
            {str(symbol): action(entry) for symbol, entry in conf.states[i].items()}
            for i in range(len(conf.states))
        ),
        rules,
        {start: (found.start_state, found.end_state) for start, found in confs.items()},
        tuple(
            (t.name, t.pattern.value if fixed else t.pattern.to_regexp(), fixed)
            for t in lark.terminals
            for fixed in (isinstance(t.pattern, PatternStr),)
        ),
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
