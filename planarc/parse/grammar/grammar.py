"""From the grammar's text to the automaton's table, by lark.

In:   the text of `grammar/modelica.lark`
Out:  Table

This is the only module that imports lark (45 ms). It reads what `Lark.save` writes, plain
data. The table lies beside the grammar, as `grammar/modelica.json`, so that lark is needed
only where the grammar was changed; `pytest --update-golden tests/parse/grammar/test_machine.py`
writes it again.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Iterator
from typing import Any

import msgspec
from lark import Lark
from lark.lexer import Lexer

from planarc.parse.grammar.machine import Rule, Table, digest

STARTS = ("stored_definition", "expression_text", "annotation_text")


class NoLexer(Lexer):
    """A lexer without tokens, where lark wants one; `lexer.scan` makes them."""

    def __init__(self, lexer_conf: Any) -> None: ...

    def lex(self, lexer_state: Any, parser_state: Any) -> Iterator[Any]:
        return iter(())


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


def make_table(text: str) -> Table:
    """The LALR(1) automaton of a grammar. lark raises an error where it has conflicts."""
    file = io.BytesIO()
    make_lark(text).save(file)
    saved = pickle.loads(file.getvalue())
    data, objects = saved["data"], saved["memo"]
    rules = {reference["@"]: i for i, reference in enumerate(data["rules"])}
    parser = data["parser"]["parser"]

    def action(entry: tuple[int, Any]) -> int:
        reduces, target = entry
        return ~rules[target["@"]] if reduces else target

    states = {
        number: {parser["tokens"][kind]: action(entry) for kind, entry in entries.items()}
        for number, entries in parser["states"].items()
    }
    place = _places(states, list(parser["start_states"].values()))
    return Table(
        tuple(
            {kind: place[n] if n >= 0 else n for kind, n in sorted(states[number].items())}
            for number in place
        ),
        tuple(_rule(objects[number]) for number in rules),
        {s: (place[n], place[parser["end_states"][s]]) for s, n in parser["start_states"].items()},
        tuple(
            _terminal(objects[reference["@"]])
            for reference in data["parser"]["lexer_conf"]["terminals"]
        ),
    )


def _places(states: dict[int, dict[str, int]], starts: list[int]) -> dict[int, int]:
    """Numbers of the states as they are reached: lark's differ from process to process."""
    found = dict.fromkeys(starts)
    waiting = list(found)
    for state in waiting:
        for _, target in sorted(states[state].items()):
            if target >= 0 and target not in found:
                found[target] = None
                waiting.append(target)
    return {state: number for number, state in enumerate(found)}


def _rule(rule: dict[str, Any]) -> Rule:
    """Each symbol is kept; one whose name begins with `_` gives a list of children. Between
    the symbols stand the optional ones that are absent in this form of the rule."""
    name, options = rule["origin"]["name"], rule["options"]
    kept: list[tuple[int, bool, int]] = []
    nones = 0
    for absent in options["empty_indices"] or [False] * len(rule["expansion"]):
        if absent:
            nones += 1
            continue
        symbol = rule["expansion"][len(kept)]
        is_list = symbol["__type__"] == "NonTerminal" and symbol["name"].startswith("_")
        kept.append((len(kept), is_list, nones))
        nones = 0
    single = options["expand1"] and rule["alias"] is None
    return Rule(name, rule["alias"] or name, len(kept), single, tuple(kept), nones)


def _terminal(defined: dict[str, Any]) -> tuple[str, str, bool]:
    pattern = defined["pattern"]
    text = pattern["value"]
    for flag in pattern["flags"]:
        text = f"(?{flag}:{text})"
    return defined["name"], text, pattern["__type__"] == "PatternStr"


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
