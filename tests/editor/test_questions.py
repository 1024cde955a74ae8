"""What a client asks of a place: each kind of question once, over the protocol."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pytest_lsp import LanguageClient

from planarc.editor.tokens import TYPES
from tests.editor.conftest import EXAMPLES, Editor

pytestmark = pytest.mark.asyncio
FOUR_BAR = EXAMPLES / "four_bar.pmo"
TEXT = FOUR_BAR.read_text("utf-8")


def position(text: str, mark: str, shift: int = 0, last: bool = False) -> lsp.Position:
    at = (text.rindex(mark) if last else text.index(mark)) + shift
    return lsp.Position(text.count("\n", 0, at), at - text.rfind("\n", 0, at) - 1)


def document(uri: str) -> lsp.TextDocumentIdentifier:
    return lsp.TextDocumentIdentifier(uri)


def piece(text: str, where: lsp.Range) -> str:
    lines = text.split("\n")
    assert where.start.line == where.end.line
    return lines[where.start.line][where.start.character : where.end.character]


async def completed(editor: Editor, text: str) -> dict[str, lsp.CompletionItem]:
    uri, at = editor.mark(text)
    found = await editor.client.text_document_completion_async(
        lsp.CompletionParams(document(uri), at)
    )
    assert isinstance(found, lsp.CompletionList)
    return {item.label: item for item in found.items}


# Hover ---------------------------------------------------------------------------------------


async def test_hover_tells_declaration_description_unit_value_and_state(
    client: LanguageClient,
) -> None:
    editor = Editor(client)
    uri = editor.open(Path("untitled:h"), TEXT.replace("equation\n", "equation\n  revA.phi = 1;\n"))
    text = TEXT.replace("equation\n", "equation\n  revA.phi = 1;\n")
    at = position(text, "revA.phi = 1", 6)
    found = await client.text_document_hover_async(lsp.HoverParams(document(uri), at))
    assert found is not None and isinstance(found.contents, lsp.MarkupContent)
    assert "SI.Angle phi" in found.contents.value
    assert "unit: `rad`" in found.contents.value
    assert found.range is not None and piece(text, found.range) == "phi"


async def told_when_checked(editor: Editor, text: str, mark: str, words: str) -> str:
    """What hover says at a mark, once the words are among it."""
    uri = editor.open(Path("untitled:v"), text)
    await editor.checked(uri)
    told = ""
    for _ in range(100):
        found = await editor.client.text_document_hover_async(
            lsp.HoverParams(document(uri), position(text, mark, 1))
        )
        assert found is not None and isinstance(found.contents, lsp.MarkupContent)
        told = found.contents.value
        if words in told:
            break
        await asyncio.sleep(0.02)
    return told


async def test_hover_tells_the_value_at_the_start(client: LanguageClient) -> None:
    text = 'model M\n  Real x(start=2, fixed=true, unit="m");\nequation\n  der(x) = -x;\nend M;\n'
    told = await told_when_checked(Editor(client), text, "-x", "at the start")
    assert "at the start: `2 m`" in told
    assert "a state" in told


async def test_hover_tells_the_block_that_solves_a_variable(client: LanguageClient) -> None:
    text = "model M\n  Real x, y;\nequation\n  x + y^3 = 3 + time;\n  sin(x) = y;\nend M;\n"
    told = await told_when_checked(Editor(client), text, " y;", "computed in")
    assert "computed in" in told and "nonlinear" in told


# Definition, references, renaming ---------------------------------------------------------------


async def test_definition_goes_into_the_library(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    at = position(TEXT, "revA.frame_b", 6)
    found = await client.text_document_definition_async(lsp.DefinitionParams(document(uri), at))
    assert isinstance(found, lsp.Location)
    assert found.uri.endswith(".pmo") and "four_bar" not in found.uri


async def test_references_and_highlights(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    at = position(TEXT, "crank(")
    found = await client.text_document_references_async(
        lsp.ReferenceParams(lsp.ReferenceContext(True), document(uri), at)
    )
    assert found is not None
    assert [piece(TEXT, f.range) for f in found] == ["crank"] * 3
    lit = await client.text_document_document_highlight_async(
        lsp.DocumentHighlightParams(document(uri), at)
    )
    assert lit is not None and len(lit) == 3


async def test_rename_edits_each_use(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    at = position(TEXT, "revA(")
    found = await client.text_document_rename_async(lsp.RenameParams(document(uri), at, "motor"))
    assert found is not None and found.changes is not None
    assert len(found.changes[uri]) == TEXT.count("revA")


@pytest.mark.parametrize(
    ("mark", "name", "reason"),
    [
        ("revA(", "equation", "reserved"),
        ("revA(", "Real", "reserved"),
        ("revA(", "sin", "built in"),
        ("revA(", "2x", "no name"),
        ("revA(", "revB", "revB"),
        ("frame_a", "other", "library"),
        ("world;", "earth", "outer"),
    ],
)
async def test_rename_refuses(client: LanguageClient, mark: str, name: str, reason: str) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    with pytest.raises(JsonRpcException, match=reason):
        await client.text_document_rename_async(
            lsp.RenameParams(document(uri), position(TEXT, mark), name)
        )


# Completion ---------------------------------------------------------------------------------------


async def test_members_are_completed_behind_a_dot(client: LanguageClient) -> None:
    editor = Editor(client)
    text = "model M\n  PlanarMultiBody.Joints.Revolute a;\nequation\n  a.|\nend M;\n"
    found = await completed(editor, text)
    assert {"phi", "w", "frame_a", "frame_b"} <= found.keys()


async def test_classes_of_a_package_are_completed(client: LanguageClient) -> None:
    editor = Editor(client)
    found = await completed(editor, "model M\n  PlanarMultiBody.Jo|\nend M;\n")
    assert "Joints" in found
    found = await completed(editor, "model M\n  import PlanarMultiBody.Joints.|\nend M;\n")
    assert "Revolute" in found


async def test_modifiers_come_with_default_and_unit(client: LanguageClient) -> None:
    editor = Editor(client)
    text = "model M\n  PlanarMultiBody.Parts.Body b(m=1, |);\nend M;\n"
    found = await completed(editor, text)
    assert found["I"].detail is not None and "kg" in found["I"].detail
    assert found["I"].text_edit is not None and found["I"].text_edit.new_text == "I="
    found = await completed(editor, "model M\n  Real x(st|\nend M;\n")
    assert {"start", "stateSelect", "unit"} <= found.keys()


async def test_connectors_that_fit_are_completed_in_connect(client: LanguageClient) -> None:
    editor = Editor(client)
    text = TEXT.replace("connect(groundA.frame_b, revA.frame_a);", "connect(groundA.frame_b, |);")
    found = await completed(editor, text)
    assert "revA.frame_a" in found
    assert "groundA.frame_b" not in found
    assert all("." in name for name in found)


async def test_literals_and_annotations_are_completed(client: LanguageClient) -> None:
    editor = Editor(client)
    text = "model M\n  Real x(stateSelect=StateSelect.|);\nend M;\n"
    assert "prefer" in await completed(editor, text)
    text = "model M\n  Real x(stateSelect=|);\nend M;\n"
    assert "StateSelect.prefer" in await completed(editor, text)
    text = "model M\n  annotation(experiment(St|\nend M;\n"
    assert {"StopTime", "StartTime"} <= (await completed(editor, text)).keys()


async def test_a_class_tells_its_description_when_it_is_looked_at(client: LanguageClient) -> None:
    editor = Editor(client)
    found = await completed(editor, "model M\n  import PlanarMultiBody.Parts.|\nend M;\n")
    assert found["Body"].documentation is None  # its file was not read
    told = await client.completion_item_resolve_async(found["Body"])
    assert (told.detail, told.documentation) == ("model", "Rigid body with mass and inertia")
    known = await client.completion_item_resolve_async(lsp.CompletionItem("world"))
    assert known.documentation is None


async def test_the_type_of_a_new_line_is_not_hidden_by_the_next_one(
    client: LanguageClient,
) -> None:
    editor = Editor(client)
    text = "model M\n  import PlanarMultiBody.Parts.Body;\n  Bo|\n  Body b;\nend M;\n"
    assert (await completed(editor, text))["Body"].documentation is not None


@pytest.mark.parametrize(
    ("before", "names"),
    [
        ("PlanarMultiBody.Joints.Revolute |", ["revolute"]),
        ("Joint joint;\n  Joint jo|", ["joint1"]),
        ("parameter Real |", []),
        ("nowhere |", []),
        ("Joint a |", []),
    ],
)
async def test_a_component_may_be_named_after_its_class(
    client: LanguageClient, before: str, names: list[str]
) -> None:
    text = f"model M\n  model Joint end Joint;\n  {before}\nend M;\n"
    assert list(await completed(Editor(client), text)) == names


async def test_nothing_is_completed_in_comments_and_strings(client: LanguageClient) -> None:
    editor = Editor(client)
    assert await completed(editor, "model M // a|\nend M;\n") == {}
    assert await completed(editor, 'model M "a|\nend M;\n') == {}


async def test_signature_help(client: LanguageClient) -> None:
    text = (
        'function f\n  input Real u;\n  input Real k = 2 "gain";\n  output Real y;\n'
        "algorithm\n  y := k*u;\nend f;\nmodel M\n  Real x;\nequation\n  x = f(1, |);\nend M;\n"
    )
    editor = Editor(client)
    uri, at = editor.mark(text)
    found = await client.text_document_signature_help_async(
        lsp.SignatureHelpParams(document(uri), at)
    )
    assert found is not None
    assert found.signatures[0].label == "y = f(u, k = 2)"
    assert found.active_parameter == 1


# The whole text ----------------------------------------------------------------------------------


async def test_symbols(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    found = await client.text_document_document_symbol_async(
        lsp.DocumentSymbolParams(document(uri))
    )
    assert found is not None and isinstance(found[0], lsp.DocumentSymbol)
    assert found[0].name == "FourBar"
    assert "crank" in [child.name for child in found[0].children or ()]
    classes = await client.workspace_symbol_async(lsp.WorkspaceSymbolParams("crnkSl"))
    assert classes is not None
    assert [c.name for c in classes] == ["CrankSlider"]


async def test_semantic_tokens_name_their_types(client: LanguageClient) -> None:
    editor = Editor(client)
    text = "model M\n  parameter Real k = 2;\n  Real x;\nequation\n  x = sin(k);\nend M;\n"
    uri = editor.open(Path("untitled:t"), text)
    found = await client.text_document_semantic_tokens_full_async(
        lsp.SemanticTokensParams(document(uri))
    )
    assert found is not None
    lines, told = text.split("\n"), []
    line = column = 0
    for step, shift, length, kind, _ in zip(*[iter(found.data)] * 5, strict=True):
        line, column = (line + step, shift) if step else (line, column + shift)
        told.append((lines[line][column : column + length], TYPES[kind]))
    assert told == [
        ("M", "class"), ("Real", "type"), ("k", "parameter"), ("Real", "type"), ("x", "variable"),
        ("x", "variable"), ("sin", "function"), ("k", "parameter"), ("M", "class"),
    ]  # fmt: skip


async def test_folds(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    found = await client.text_document_folding_range_async(lsp.FoldingRangeParams(document(uri)))
    assert found is not None
    kinds = {f.kind for f in found}
    assert {"comment", "imports", "region"} <= {getattr(k, "value", k) for k in kinds}
    assert any(f.start_line == 0 and f.end_line >= TEXT.count("\n") - 2 for f in found)


async def test_formatting_is_that_of_the_command(client: LanguageClient) -> None:
    editor = Editor(client)
    text = "model  M\nReal x (start = 1) ;\nequation\n  der (x)=-x;\nend M;\n"
    uri = editor.open(Path("untitled:f"), text)
    found = await client.text_document_formatting_async(
        lsp.DocumentFormattingParams(document(uri), lsp.FormattingOptions(2, True))
    )
    assert found is not None
    lines = text.splitlines(True)
    for edit in reversed(found):
        lines[edit.range.start.line : edit.range.end.line] = [edit.new_text]
    assert "".join(lines) == ("model M\n  Real x(start=1);\nequation\n  der(x) = -x;\nend M;\n")
