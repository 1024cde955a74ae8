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
from planarc.parse.grammar.machine import Automaton
from planarc.parse.language import load_language
from planarc.parse.parser import parse_file

TEXT = """within A;
package P
  import B.C;
  replaceable model M = N(redeclare type T = Real[3] (each min = 1)) constrainedby N;
protected
  function f input Real x; output Real y = if x > 1 then 2 else -x^2; algorithm
    for i in 1:3 loop y := sum(y*k for k in {1, 2}); end for;
    while not y < 2 or y == x and true loop (y, , x) := f(x, a = 1); break; end while;
  end f;
  type E = enumeration(a "a", b);
initial equation
  x[end] = der(y.z[1, :]);
equation
  when initial() then reinit(x, 1); elsewhen x then connect(a, b[2].c); end when;
  if x then y = 1; elseif z then assert(x, "text" + "more"); else z = [1, 2; 3, 4]; end if;
  annotation(Icon());
end P;
"""


def test_lalr_has_no_conflicts(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG, logger=lark.logger.name)
    text = grammar_file().read_text("utf-8")
    lark.Lark(text, parser="lalr", lexer=NoLexer, start=list(STARTS), debug=True)
    assert [r.getMessage() for r in caplog.records if "conflict" in r.getMessage().lower()] == []


def test_every_rule_has_a_builder() -> None:
    names = {rule.alias for rule in load_language().table.rules}
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
    assert load_language().terminals.keywords == set(words.split())


def test_the_table_gives_the_trees_that_lark_gives() -> None:
    """Of all files of the libraries: equal nodes at equal places."""
    build = Build()
    parser = make_lark(grammar_file().read_text("utf-8"), build)
    paths = sorted(stdlib().rglob("*.pmo"))
    assert len(paths) > 200
    for path in paths:
        source = Source(path.name, decode(path.read_bytes()), path)
        tokens, _ = scan(source, load_language().terminals)
        build.begin(Span(source, 0, len(source.text)))
        interactive = parser.parse_interactive(start="stored_definition")
        for token in tokens:
            expected = interactive.feed_token(token)
        found = parse_file(path, path.name)
        assert found == expected
        assert places(found) == places(expected)


def test_the_machine_expects_what_lark_expects() -> None:
    """After each word of a text with every kind of section."""
    parser = make_lark(grammar_file().read_text("utf-8"))
    automaton = Automaton(load_language().table, "stored_definition")
    interactive = parser.parse_interactive(start="stored_definition")
    tokens, _ = scan(Source("text", TEXT), load_language().terminals)
    stack = automaton.begin
    for token in tokens[:-1]:
        assert set(automaton.accepts(stack)) == interactive.accepts()
        following = automaton.shift(stack, token.type, 0)
        assert following is not None
        interactive.feed_token(token)
        stack = following


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
