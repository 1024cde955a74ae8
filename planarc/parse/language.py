"""The language made ready to read: the machine's table, our builder, our terminals.

lark needs 0.25 s to make the table, which therefore lies beside the grammar. Only where that is
not the table of this grammar is lark imported, and the table kept in the cache.
"""

from __future__ import annotations

# Beneath the module `threading`, whose import is 0.6 ms of a run.
from _thread import LockType, allocate_lock
from contextlib import suppress
from functools import cache

import msgspec

from planarc.core import cache as disk
from planarc.core.data import Data
from planarc.core.resources import grammar_file, table_file
from planarc.parse.build.build import Build
from planarc.parse.grammar.lexer import Terminals, compile_terminals
from planarc.parse.grammar.machine import Kept, Reduction, Table, digest, reductions


class Language(Data):
    table: Table
    reductions: tuple[Reduction, ...]
    build: Build
    terminals: Terminals
    #: `build` collects the errors of one text: one text at a time.
    lock: LockType


@cache
def load_language() -> Language:
    """The language, made ready once in a process."""
    build, table = Build(), _load_table()
    terminals = compile_terminals(table.terminals)
    return Language(table, reductions(table, build), build, terminals, allocate_lock())


def _load_table() -> Table:
    text = grammar_file().read_text("utf-8")
    with suppress(OSError, msgspec.DecodeError):
        kept = msgspec.json.decode(table_file().read_bytes(), type=Kept)
        if kept.grammar == digest(text):
            return kept.table
    key = disk.key("table", text)
    stored = disk.load("grammar", key)
    if stored is not None:
        with suppress(msgspec.DecodeError):
            return msgspec.json.decode(stored, type=Table)
    from planarc.parse.grammar.grammar import make_table

    made = make_table(text)
    disk.store("grammar", key, msgspec.json.encode(made))
    return made
