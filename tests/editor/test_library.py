"""The server with the real Modelica Standard Library, as a user loads it.

`PLANARC_MSL` names the folder that holds `Modelica`; without it these tests skip.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pytest_lsp import LanguageClient

from tests.editor.conftest import Editor

pytestmark = [
    pytest.mark.asyncio,
    pytest.mark.skipif("PLANARC_MSL" not in os.environ, reason="PLANARC_MSL names no library"),
]
MODEL = """model Motor
  Modelica.Mechanics.Rotational.Components.Inertia load(J=2);
  Modelica.Mechanics.Rotational.Sources.ConstantTorque drive(tau_constant=1);
equation
  connect(drive.flange, load.|flange_a);
end Motor;
"""


def use_library(client: LanguageClient) -> Path:
    folder = Path(os.environ["PLANARC_MSL"])
    client.workspace_did_change_configuration(
        lsp.DidChangeConfigurationParams({"planarc": {"libraries": [str(folder)]}})
    )
    return folder


async def test_a_model_on_the_library(client: LanguageClient) -> None:
    editor = Editor(client)
    use_library(client)
    uri, at = editor.mark(MODEL, "motor")
    assert await editor.checked(uri) == []
    asked = lsp.TextDocumentIdentifier(uri)
    place = await client.text_document_definition_async(lsp.DefinitionParams(asked, at))
    assert isinstance(place, lsp.Location) and "Rotational" in place.uri
    found = await client.text_document_completion_async(lsp.CompletionParams(asked, at))
    assert isinstance(found, lsp.CompletionList)
    assert {"flange_a", "flange_b"} == {item.label for item in found.items}


async def test_a_file_of_the_library(client: LanguageClient) -> None:
    editor = Editor(client)
    folder = use_library(client)
    path = next(folder.glob("Modelica*/Blocks/Math.mo"))
    uri = editor.open(path)
    found = await editor.checked(uri)
    assert [d for d in found if d.severity is lsp.DiagnosticSeverity.Error] == []
    text = path.read_text("utf-8").replace("y = k*u;", "y = k*;", 1)
    editor.change(uri, text, 2)
    assert [d.code for d in await editor.checked(uri, 2)][:1] == ["P101"]


async def test_questions_about_names_of_the_library(client: LanguageClient) -> None:
    """What a name means and where it is used, arguments, the page of a class; none is renamed."""
    editor = Editor(client)
    use_library(client)
    uri, at = editor.mark(MODEL.replace("load.|", "load.").replace("(J=2", "(|J=2"), "asked")
    await editor.checked(uri)
    asked = lsp.TextDocumentIdentifier(uri)
    hover = await client.text_document_hover_async(lsp.HoverParams(asked, at))
    assert hover is not None and isinstance(hover.contents, lsp.MarkupContent)
    assert "Moment of inertia" in hover.contents.value
    assert "unit: `kg.m2`" in hover.contents.value
    listed = await client.text_document_completion_async(lsp.CompletionParams(asked, at))
    assert isinstance(listed, lsp.CompletionList)
    offered = {item.label: item for item in listed.items}
    assert {"J", "phi", "w", "stateSelect"} <= offered.keys()
    with pytest.raises(JsonRpcException, match="library"):
        await client.text_document_rename_async(lsp.RenameParams(asked, at, "inertia"))
    uses = await client.text_document_references_async(
        lsp.ReferenceParams(lsp.ReferenceContext(True), asked, at)
    )
    assert uses is not None
    assert uri in {use.uri for use in uses}
    page = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams(
            "planarc.handbook",
            [{"uri": uri, "position": {"line": at.line, "character": at.character}}],
        )
    )
    assert page["class"] == "Modelica.Mechanics.Rotational.Components.Inertia"


async def test_a_whole_file_of_the_library(client: LanguageClient) -> None:
    """Outline, colours, folds, form, hints and lenses of a file of some thousand lines."""
    editor = Editor(client)
    path = next(use_library(client).glob("Modelica*/Mechanics/Rotational/Sources/Torque.mo"), None)
    path = path or next(Path(os.environ["PLANARC_MSL"]).glob("Modelica*/Mechanics/Rotational.mo"))
    uri = editor.open(path)
    await editor.checked(uri)
    asked = lsp.TextDocumentIdentifier(uri)
    outline = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(asked))
    assert outline and isinstance(outline[0], lsp.DocumentSymbol)
    assert outline[0].name in ("Torque", "Rotational")
    colours = await client.text_document_semantic_tokens_full_async(lsp.SemanticTokensParams(asked))
    assert colours is not None and len(colours.data) > 50
    assert await client.text_document_folding_range_async(lsp.FoldingRangeParams(asked))
    formed = await client.text_document_formatting_async(
        lsp.DocumentFormattingParams(asked, lsp.FormattingOptions(2, True))
    )
    assert formed is not None
    whole = lsp.Range(lsp.Position(0, 0), lsp.Position(100_000, 0))
    assert (
        await client.text_document_inlay_hint_async(lsp.InlayHintParams(asked, whole)) is not None
    )
    assert await client.text_document_code_lens_async(lsp.CodeLensParams(asked)) is not None
    found = await client.workspace_symbol_async(lsp.WorkspaceSymbolParams("ConstantTorque"))
    assert found and "ConstantTorque" in [symbol.name for symbol in found]


async def test_a_function_of_the_library_tells_its_arguments(client: LanguageClient) -> None:
    editor = Editor(client)
    use_library(client)
    text = "model M\n  Real x = Modelica.Math.Vectors.interpolate({0, 1}, |);\nend M;\n"
    uri, at = editor.mark(text, "arguments")
    found = await client.text_document_signature_help_async(
        lsp.SignatureHelpParams(lsp.TextDocumentIdentifier(uri), at)
    )
    assert found is not None
    assert "interpolate(x, y, xi" in found.signatures[0].label
    assert found.active_parameter == 1
