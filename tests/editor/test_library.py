"""The server with the real Modelica Standard Library, as a user loads it.

`PLANARC_MSL` names the folder that holds `Modelica`; without it these tests skip.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from lsprotocol import types as lsp
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


async def test_a_model_on_the_library(client: LanguageClient) -> None:
    editor = Editor(client)
    folder = Path(os.environ["PLANARC_MSL"])
    client.workspace_did_change_configuration(
        lsp.DidChangeConfigurationParams({"planarc": {"libraries": [str(folder)]}})
    )
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
    folder = Path(os.environ["PLANARC_MSL"])
    client.workspace_did_change_configuration(
        lsp.DidChangeConfigurationParams({"planarc": {"libraries": [str(folder)]}})
    )
    path = next(folder.glob("Modelica*/Blocks/Math.mo"))
    uri = editor.open(path)
    found = await editor.checked(uri)
    assert [d for d in found if d.severity is lsp.DiagnosticSeverity.Error] == []
    text = path.read_text("utf-8").replace("y = k*u;", "y = k*;", 1)
    editor.change(uri, text, 2)
    assert [d.code for d in await editor.checked(uri, 2)][:1] == ["P101"]
