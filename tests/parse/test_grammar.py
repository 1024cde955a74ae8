"""The grammar itself: no conflict is settled by chance, and every rule has its builder."""

from __future__ import annotations

import logging

import lark
import pytest
from msgspec import Struct

from planarc.core.resources import grammar_file, stdlib
from planarc.core.source import Source, Span, decode
from planarc.parse.build.build import Build
from planarc.parse.grammar.grammar import STARTS, NoLexer, make_lark
from planarc.parse.grammar.lexer import scan
from planarc.parse.grammar.machine import load_machine
from planarc.parse.parser import parse_file


def test_lalr_has_no_conflicts(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG, logger=lark.logger.name)
    text = grammar_file().read_text("utf-8")
    lark.Lark(text, parser="lalr", lexer=NoLexer, start=list(STARTS), debug=True)
    assert [r.getMessage() for r in caplog.records if "conflict" in r.getMessage().lower()] == []


def test_every_rule_has_a_builder() -> None:
    names = {rule.alias for rule in load_machine().table.rules}
    passed_on = {  # `?rule` with one child, which is handed on as it is
        *("expression", "range", "disjunction", "conjunction", "negation"),
        *("relation", "sum", "product", "power", "primary"),
    }
    missing = {n for n in names if not n.startswith("_") and not hasattr(Build, n)} - passed_on
    assert missing == set()


def test_the_reserved_words_are_those_of_the_specification() -> None:
    """Section 2.3.3."""
    words = """algorithm and annotation block break class connect connector constant
        constrainedby der discrete each else elseif elsewhen encapsulated end enumeration
        equation expandable extends external false final flow for function if import impure
        in initial inner input loop model not operator or outer output package parameter
        partial protected public pure record redeclare replaceable return stream then true
        type when while within"""
    assert load_machine().terminals.keywords == set(words.split())


def test_the_table_gives_the_trees_that_lark_gives() -> None:
    """Of all files of the libraries: equal nodes at equal places."""
    build = Build()
    parser = make_lark(grammar_file().read_text("utf-8"), build)
    paths = sorted(stdlib().rglob("*.pmo"))
    assert len(paths) > 200
    for path in paths:
        source = Source(path.name, decode(path.read_bytes()), path)
        tokens, _ = scan(source, load_machine().terminals)
        build.begin(Span(source, 0, len(source.text)))
        state = parser.parse_interactive(start="stored_definition").parser_state
        for token in tokens[:-1]:
            state.feed_token(token)
        expected = state.feed_token(tokens[-1], is_end=True)
        found = parse_file(path, path.name)
        assert found == expected
        assert places(found) == places(expected)


def places(tree: object) -> list[tuple[int, int]]:
    """Where each node stands, in the order of the nodes."""
    found, stack = [], [tree]
    while stack:
        node = stack.pop()
        if isinstance(node, Span):
            found.append(node[1:])
        elif isinstance(node, tuple):
            stack.extend(node)
        elif isinstance(node, Struct):
            stack.extend(getattr(node, name) for name in node.__struct_fields__)
    return found
