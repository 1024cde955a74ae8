"""The grammar itself: no conflict is settled by chance, and every rule has its builder."""

from __future__ import annotations

import logging

import lark
import pytest

from planarc.core.resources import grammar_file
from planarc.parse.build import Build
from planarc.parse.machine import STARTS, NoLexer, load_machine


def test_lalr_has_no_conflicts(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG, logger=lark.logger.name)
    text = grammar_file().read_text("utf-8")
    lark.Lark(text, parser="lalr", lexer=NoLexer, start=list(STARTS), debug=True)
    assert [r.getMessage() for r in caplog.records if "conflict" in r.getMessage().lower()] == []


def test_every_rule_has_a_builder() -> None:
    names = {str(rule.alias or rule.origin.name) for rule in load_machine().lark.rules}
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
