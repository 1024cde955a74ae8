"""The grammar made ready to run: lark's table, our builder, our terminals.

Building the table takes lark 0.2 s, so that it is kept in the cache. This is the
only module that imports lark (40 ms); import it where a text is parsed, not before.
"""

from __future__ import annotations

import pickle
from functools import cache
from threading import Lock
from typing import Any

import lark
from lark import Lark
from lark.grammar import Rule
from lark.lexer import Lexer, PatternStr, TerminalDef

from planarc.core import cache as disk
from planarc.core.data import Data
from planarc.core.resources import grammar_file
from planarc.parse.build import Build
from planarc.parse.lexer import Terminals, compile_terminals

STARTS = ("stored_definition", "expression_text", "annotation_text")


class NoLexer(Lexer):
    """Stands where lark wants a lexer; `lexer.scan` makes the tokens."""

    def __init__(self, lexer_conf: Any) -> None: ...

    def lex(self, lexer_state: Any, parser_state: Any) -> Any:
        return iter(())


class Machine(Data):
    lark: Lark
    build: Build
    terminals: Terminals
    #: `build` collects the errors of one text: one text at a time.
    lock: Lock

    def begin(self, start: str) -> Any:
        """lark's automaton before the first token (`lark.parsers.lalr_parser_state`)."""
        return self.lark.parse_interactive(start=start).parser_state


@cache
def load_machine() -> Machine:
    """Once in a process."""
    build = Build()
    parser = _load_lark(build)
    terminals = compile_terminals(
        (t.name, t.pattern.value if fixed else t.pattern.to_regexp(), fixed)
        for t in parser.terminals
        for fixed in (isinstance(t.pattern, PatternStr),)
    )
    return Machine(parser, build, terminals, Lock())


def _load_lark(build: Build) -> Lark:
    text = grammar_file().read_text("utf-8")
    key = disk.key("lark", lark.__version__, text)
    stored = disk.load("grammar", key)
    if stored is not None:
        try:
            data, memo = pickle.loads(stored)
            load: Any = Lark._load_from_dict
            loaded: Lark = load(data, memo, transformer=build)
            return loaded
        except Exception:  # written by another build of lark: make it anew
            pass
    parser = Lark(
        text,
        parser="lalr",
        lexer=NoLexer,
        start=list(STARTS),
        keep_all_tokens=True,
        transformer=build,
    )
    disk.store("grammar", key, pickle.dumps(parser.memo_serialize([TerminalDef, Rule])))
    return parser
