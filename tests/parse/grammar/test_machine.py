"""The automaton's table that lies beside the grammar, and the one that lark makes."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.core import resources
from planarc.parse import language
from planarc.parse.grammar.grammar import STARTS, make_table, table_text


@pytest.fixture(scope="module")
def text() -> str:
    return resources.grammar_file().read_text("utf-8")


def test_the_table_in_the_file_is_that_of_the_grammar(
    text: str, request: pytest.FixtureRequest
) -> None:
    written = table_text(text)
    if request.config.getoption("--update-golden"):
        resources.table_file().write_text(written, encoding="utf-8", newline="\n")
    assert resources.table_file().read_text("utf-8") == written


def test_a_changed_grammar_has_a_table_of_its_own(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed = tmp_path / "modelica.lark"
    changed.write_text(text.replace('"equation"', '"equations"'), encoding="utf-8")
    monkeypatch.setattr(language, "grammar_file", lambda: changed)
    names = {pattern for _, pattern, _ in language._load_table().terminals}
    assert "equations" in names
    assert "equation" not in names


@pytest.mark.parametrize("content", [None, "", "{}", '{"grammar":"","table":[]}'])
def test_a_table_that_is_missing_or_damaged_is_made_again(
    content: str | None, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "modelica.json"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    monkeypatch.setattr(language, "table_file", lambda: path)
    assert language._load_table() == make_table(text)


def test_each_state_is_reached_and_each_target_there(text: str) -> None:
    table = make_table(text)
    targets = {n for state in table.states for n in state.values() if n >= 0}
    starts = {table.starts[name][0] for name in STARTS}
    assert targets | starts == set(range(len(table.states)))
    assert {~n for s in table.states for n in s.values() if n < 0} <= set(range(len(table.rules)))
