"""Random edits of the examples: the server lives, and says in the end what `planarc check` says
of each model of the text: the same, where its syntax is right. Where that is wrong, the command
stops there; the server says all of that, and goes on. A component with connectors is for others:
the server does not solve it alone, nor asks for what these give it.

`PLANARC_EDITS=10000` makes as many edits as one wants.
"""

from __future__ import annotations

import os
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types as lsp
from msgspec.structs import replace
from pytest_lsp import LanguageClient

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.source import Source
from planarc.editor.check import _connectors, models_of
from planarc.editor.convert import Units, diagnostic
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text, Texts
from planarc.probe.check import check_model
from planarc.request.request import Request
from tests.editor.conftest import EXAMPLES, Editor

pytestmark = pytest.mark.asyncio
EDITS = int(os.environ.get("PLANARC_EDITS", "120"))
FILES = [p for p in sorted(EXAMPLES.rglob("*.pmo")) if "model" in p.read_text("utf-8")]
#: What whoever uses a component gives it: the server says nothing of it, the command does.
GIVEN = ("F262", "F281", "F286")
PIECES = (
    ";", "(", ")", "{", "}", "[", "]", '"', "'", ",", ".", "=", ":=", "end", "equation", "model X",
    "connect(", "annotation(", "/*", "//", "\n", "\0", "é", "𝛗", "Real x;", "if ", "der(", "each ",
    "extends ", "import A.*;", "1e", "inner ", "parameter Real k = 1;", "protected\n", "\t", "\\",
    "when time > 1 then", "redeclare ", "within;", "algorithm\n", "\ufeff", "\r",
)  # fmt: skip


def edits(text: str, dice: random.Random) -> tuple[int, int, str]:
    """A random edit: the range that goes, and what comes."""
    at = dice.randrange(len(text) + 1)
    kind = dice.random()
    if kind < 0.4:
        return at, at, dice.choice(PIECES)
    if kind < 0.7:
        return at, min(at + dice.randrange(1, 12), len(text)), ""
    end = min(at + dice.randrange(1, 40), len(text))
    return (at, at, text[at:end]) if kind < 0.85 else (at, end, dice.choice(PIECES))


def place(text: str, at: int) -> lsp.Position:
    line = text.rfind("\n", 0, at) + 1
    return lsp.Position(text.count("\n", 0, at), len(text[line:at].encode("utf-16-le")) // 2)


def said(path: Path, text: str) -> set[tuple[Any, ...]]:
    """What the command says of each model of a text: codes, places and messages."""
    names = models_of(Text(path, text)) or (None,)
    found = (d for n in names for d in _found(Request(path, n, text=text)))
    return {_told(d, text) for d in found}


def has_components(path: Path, text: str) -> bool:
    """True where a model of the text has connectors of its own."""
    try:
        shelf, content = Shelf(Texts()), Text(path, text)
        target = shelf.target(content)
        return any(
            next(_connectors(replace(target, class_name=n)), None) for n in models_of(content)
        )
    except PlanarcError:
        return False


def _found(request: Request) -> Iterator[Diagnostic]:
    try:
        checked = check_model(request)
    except PlanarcError as problem:
        yield from problem.diagnostics
        return
    yield from checked.warnings
    if checked.mobility is not None and checked.mobility.redundant is not None:
        yield checked.mobility.redundant


def _told(found: Diagnostic, text: str) -> tuple[Any, ...]:
    told = diagnostic(found, Units(), Source("", text))
    return str(told.code), told.message, told.range.start.line, told.range.start.character


async def test_random_edits(client: LanguageClient) -> None:
    editor = Editor(client)
    dice = random.Random(18)
    version, made = 1, 0
    while made < EDITS:
        path = dice.choice(FILES)
        text = original = path.read_text("utf-8")
        version += 1
        uri = editor.open(path, text, version)
        for _ in range(dice.randrange(2, 40)):
            start, end, new = edits(text, dice)
            where = lsp.Range(place(text, start), place(text, end))
            version += 1
            made += 1
            editor.edit(uri, [lsp.TextDocumentContentChangePartial(where, new)], version)
            text = text[:start] + new + text[end:]
            if dice.random() < 0.1:
                at = place(text, dice.randrange(len(text) + 1))
                asked = lsp.TextDocumentIdentifier(uri)
                await client.text_document_hover_async(lsp.HoverParams(asked, at))
                await client.text_document_completion_async(lsp.CompletionParams(asked, at))
                await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(asked))
            if dice.random() < 0.15:
                version += 1
                editor.change(uri, original, version)
                text = original
        found = await editor.checked(uri, version)
        mine = {(str(d.code), d.message, *_start(d)) for d in found}
        compare(path, text, mine)
        client.text_document_did_close(
            lsp.DidCloseTextDocumentParams(lsp.TextDocumentIdentifier(uri))
        )
    assert await editor.checked(editor.open(FILES[0], version=version + 1), version + 1) == []


def compare(path: Path, text: str, mine: set[tuple[Any, ...]]) -> None:
    """Hold what the server says against what the command does."""
    wanted = said(path, text)
    if any(t[0].startswith("P") for t in wanted):
        # Of the rest the command says nothing then, nor of what stands in annotations.
        assert mine >= {t for t in wanted if t[0].startswith("P")}
        more = {t for t in mine - wanted if t[0].startswith("P")}
        assert all(_in_annotation(text, *t[2:]) for t in more), more
        return
    wanted = {t[:2] for t in wanted if not t[0].startswith("C")}  # of the request
    if has_components(path, text):
        given = {t for t in wanted if t[0].startswith("F") and t[0] not in GIVEN}
        assert {t[:2] for t in mine} >= given
    else:
        assert {t[:2] for t in mine} == wanted


def _in_annotation(text: str, line: int, column: int) -> bool:
    lines = text.split("\n")
    before = "\n".join([*lines[:line], lines[line][:column]])
    return "annotation" in before.rpartition(";")[2]


def _start(found: lsp.Diagnostic) -> tuple[int, int]:
    return found.range.start.line, found.range.start.character
