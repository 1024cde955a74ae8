"""A client's session with the language server: texts, diagnostics, messages that are malformed."""

from __future__ import annotations

from pathlib import Path

import pytest
from lsprotocol import types as lsp
from pytest_lsp import LanguageClient

from tests.editor.conftest import EXAMPLES, Editor, codes

pytestmark = pytest.mark.asyncio
FOUR_BAR = EXAMPLES / "four_bar.pmo"


async def test_an_example_is_right(client: LanguageClient) -> None:
    editor = Editor(client)
    assert await editor.checked(editor.open(FOUR_BAR)) == []


async def test_a_wrong_name_is_told_with_its_place_and_code(client: LanguageClient) -> None:
    editor = Editor(client)
    text = FOUR_BAR.read_text("utf-8").replace("revC.frame_a", "revC.frame_z")
    (found,) = await editor.checked(editor.open(FOUR_BAR, text))
    assert (found.code, found.severity) == ("F213", lsp.DiagnosticSeverity.Error)
    line = text.splitlines()[found.range.start.line]
    assert line[found.range.start.character : found.range.end.character] == "revC.frame_z"
    assert "frame_a" in found.message
    assert found.code_description is not None
    page, _, section = found.code_description.href.removeprefix("file://").partition("#")
    assert f'id="{section}"' in Path(page).read_text("utf-8")


async def test_edits_arrive_in_the_units_of_the_client(client: LanguageClient) -> None:
    editor = Editor(client)
    text = 'model M "𝛗 of a bar"\n  Real x(start=0);\nequation\n  der(x) = y;\nend M;\n'
    uri = editor.open(Path("untitled:one"), text)
    assert codes(await editor.checked(uri)) == [(4, "F210")]
    start = lsp.Position(0, 10)  # behind the letter, which takes two units of UTF-16
    changes = [
        lsp.TextDocumentContentChangePartial(lsp.Range(start, lsp.Position(0, 12)), "OF"),
        lsp.TextDocumentContentChangePartial(
            lsp.Range(lsp.Position(3, 11), lsp.Position(3, 12)), "x"
        ),
    ]
    editor.edit(uri, changes, 2)
    assert await editor.checked(uri, 2) == []


BROKEN = """model A
  Real x(start=1);
equation
  der(x) = -x
end A;

model B
  Real y;
equation
  y = z;
end B;

model C
  A a;
  Real w = a.x;
  Real v = a.q;
end C;
"""


async def test_a_broken_class_silences_no_other(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(Path("untitled:two"), BROKEN)
    found = codes(await editor.checked(uri))
    assert [(line, code[0]) for line, code in found] == [(4, "P"), (10, "F"), (16, "F")] or [
        (line, code[0]) for line, code in found
    ] == [(5, "P"), (10, "F"), (16, "F")]


async def test_others_see_the_last_good_class(client: LanguageClient) -> None:
    editor = Editor(client)
    good = BROKEN.replace("-x\n", "-x;\n").replace("= z", "= 1").replace("a.q", "1")
    uri = editor.open(Path("untitled:three"), good)
    assert await editor.checked(uri) == []
    editor.change(uri, good.replace("Real x(start=1);", "Real (start=1);"), 2)
    found = await editor.checked(uri, 2)
    assert {d.code for d in found if str(d.code)[0] != "P"} == set()
    assert found != []


async def test_a_component_of_a_library_is_not_told_what_its_user_gives(
    client: LanguageClient,
) -> None:
    editor = Editor(client)
    path = EXAMPLES.parent / "stdlib" / "PlanarMultiBody" / "Parts" / "Body.pmo"
    assert await editor.checked(editor.open(path)) == []
