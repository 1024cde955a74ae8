"""The grammar made ready to run: the automaton's table, our builder, our terminals.

lark needs 0.25 s to make the table, which therefore lies beside the grammar. Only where that is
not the table of this grammar is lark imported, and the table kept in the cache.
"""

from __future__ import annotations

import pickle
from contextlib import suppress
from functools import cache
from threading import Lock
from typing import Any

import msgspec

from planarc.core import cache as disk
from planarc.core.data import Data
from planarc.core.resources import grammar_file, table_file
from planarc.parse.build.build import Build
from planarc.parse.grammar.lexer import Terminals, compile_terminals
from planarc.parse.grammar.table import Kept, Reduction, Table, digest, reductions


class Machine(Data):
    table: Table
    reductions: tuple[Reduction, ...]
    build: Build
    terminals: Terminals
    #: `build` collects the errors of one text: one text at a time.
    lock: Lock


@cache
def load_machine() -> Machine:
    """Once in a process."""
    build, table = Build(), _load_table()
    terminals = compile_terminals(table.terminals)
    return Machine(table, reductions(table, build), build, terminals, Lock())


def _load_table() -> Table:
    text = grammar_file().read_text("utf-8")
    with suppress(OSError, msgspec.DecodeError):
        kept = msgspec.json.decode(table_file().read_bytes(), type=Kept)
        if kept.grammar == digest(text):
            return kept.table
    key = disk.key("table", text)
    stored = disk.load("grammar", key)
    if stored is not None:
        table: Any = pickle.loads(stored)
        if isinstance(table, Table):
            return table
    from planarc.parse.grammar.grammar import make_table

    made = make_table(text)
    disk.store("grammar", key, pickle.dumps(made, pickle.HIGHEST_PROTOCOL))
    return made
