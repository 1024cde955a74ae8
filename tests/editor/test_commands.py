"""Quick fixes, hints, lenses, commands and planarc's own requests, over the protocol."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest
from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pytest_lsp import LanguageClient

from planarc.editor.convert import Units, action
from planarc.editor.fixes import fixes_of
from planarc_docs.blocks import blocks_of
from tests.editor.conftest import EXAMPLES, Editor
from tests.editor.test_fixes import checked

pytestmark = pytest.mark.asyncio
FOUR_BAR = EXAMPLES / "four_bar.pmo"
TEXT = FOUR_BAR.read_text("utf-8")
WHOLE = lsp.Range(lsp.Position(0, 0), lsp.Position(10_000, 0))
COMPUTED = """model M
  parameter Integer n=2;
  parameter Real L(unit="m")=0.5;
  parameter Real A(unit="m2")=L*L;
  Real x[n](each start=1, each fixed=true);
equation
  der(x) = -x;
end M;
"""


def document(uri: str) -> lsp.TextDocumentIdentifier:
    return lsp.TextDocumentIdentifier(uri)


async def test_quick_fix(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR, TEXT.replace("revC.frame_a", "revC.frame_z"))
    (found,) = await editor.checked(uri)
    actions = await client.text_document_code_action_async(
        lsp.CodeActionParams(document(uri), found.range, lsp.CodeActionContext([found]))
    )
    assert actions is not None and isinstance(actions[0], lsp.CodeAction)
    assert [a.title for a in actions] == ["Write `frame_b`", "Write `frame_a`"]
    edit = actions[1].edit
    assert edit is not None and edit.changes is not None
    assert [e.new_text for e in edit.changes[uri]] == ["frame_a"]


async def test_redundant_joints_are_accepted_by_a_fix(client: LanguageClient) -> None:
    editor = Editor(client)
    guide = (Path(__file__).parents[2] / "docs" / "howto" / "loops.md").read_text("utf-8")
    text = next(b.text for b in blocks_of(guide) if b.argument == "parallel.pmo")
    uri = editor.open(Path("untitled:parallel"), COMPUTED + text)  # two models
    (found,) = await editor.checked(uri)
    opened, told = checked(COMPUTED + text)
    (fix,) = [fix for d in told for fix in fixes_of(opened, d)]
    command = action(fix, found, uri, Units()).command
    assert command is not None
    said = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams(command.command, arguments=command.arguments)
    )
    assert said["ok"] and "Parallel ran to t =" in said["text"]


async def test_hints_beside_the_text(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(Path("untitled:hints"), COMPUTED)
    await editor.checked(uri)
    labels: set[object] = set()
    for _ in range(200):
        found = await client.text_document_inlay_hint_async(
            lsp.InlayHintParams(document(uri), WHOLE)
        )
        labels = {(h.position.line + 1, h.label) for h in found or ()}
        if len(labels) == 3:
            break
        await asyncio.sleep(0.02)
    assert labels == {(1, "2 states"), (4, "= 0.25 m2"), (5, "[2]")}


async def test_mobility_beside_the_name(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    await editor.checked(uri)
    found = await client.text_document_inlay_hint_async(lsp.InlayHintParams(document(uri), WHOLE))
    assert found is not None
    assert found[0].label == "mobility 1, 2 states"
    assert found[0].position == lsp.Position(0, len("model FourBar"))


async def test_lenses_carry_commands_that_run(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(Path("untitled:lens"), COMPUTED)
    lenses = await client.text_document_code_lens_async(lsp.CodeLensParams(document(uri)))
    assert lenses is not None
    commands = {lens.command.command: lens.command for lens in lenses if lens.command}
    assert list(commands) == ["planarc.simulate", "planarc.view", "planarc.check"]
    for name, words in (("planarc.check", "M is complete"), ("planarc.simulate", "M ran to t =")):
        said = await client.workspace_execute_command_async(
            lsp.ExecuteCommandParams(name, arguments=commands[name].arguments)
        )
        assert said["ok"] and words in said["text"]
    assert any("M ran" in m.message for m in client.messages)


async def test_a_command_without_what_it_needs_is_refused(client: LanguageClient) -> None:
    Editor(client)
    for arguments in ([], [3], [{}], [{"uri": 3}], [{"uri": "file:///nothing.pmo"}]):
        with pytest.raises(JsonRpcException):
            await client.workspace_execute_command_async(
                lsp.ExecuteCommandParams("planarc.check", arguments=arguments)
            )
    with pytest.raises(JsonRpcException):
        await client.workspace_execute_command_async(lsp.ExecuteCommandParams("planarc.no"))


async def test_a_command_line_names_no_text(client: LanguageClient) -> None:
    editor = Editor(client)

    async def checked(*arguments: object) -> str:
        given = list(arguments) or None
        said = await client.workspace_execute_command_async(
            lsp.ExecuteCommandParams("planarc.check", arguments=given)
        )
        return str(said["text"])

    with pytest.raises(JsonRpcException, match="open a model first"):
        await checked()
    uri = editor.open(FOUR_BAR)
    assert "FourBar is complete" in await checked()
    two = editor.open(Path("untitled:two"), COMPUTED + "model N end N;\n")
    assert "N is complete" in await checked("N")
    assert "M is complete" in await checked({"class": "M"})
    with pytest.raises(JsonRpcException, match="`M`, `N`"):
        await checked()
    await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(document(uri)))
    assert "FourBar is complete" in await checked()
    for closed in (uri, two):
        client.text_document_did_close(lsp.DidCloseTextDocumentParams(document(closed)))
    with pytest.raises(JsonRpcException, match="open a model first"):
        await checked()
    handbook = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams("planarc.handbook", arguments=["F210"])
    )
    assert handbook["text"].startswith("## F210")


async def test_the_live_page_of_a_text(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    found = await client.protocol.send_request_async("planarc/livePage", {"uri": uri})
    with urlopen(found.url, timeout=60) as answer:
        assert b"FourBar" in answer.read()
    again = await client.protocol.send_request_async("planarc/livePage", {"uri": uri})
    assert again.url == found.url
    await client.protocol.send_request_async("planarc/closePage", {"uri": uri})
    with pytest.raises(OSError):
        urlopen(found.url, timeout=5)


async def test_the_live_page_follows_what_is_typed(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    page = await client.protocol.send_request_async("planarc/livePage", {"uri": uri})
    first = await asyncio.to_thread(_run, page.url)
    assert (first["problems"], _value(first, "crank.r[1]")) == ([], 0.4)
    for version, (text, length) in enumerate(
        [
            (TEXT.replace("crank(r={0.4", "crank(r={0.3"), 0.3),
            (TEXT.replace("crank(r={0.4", "crank(r={nowhere"), None),
            (TEXT.replace("crank(r={0.4", "crank(r={0.35").replace("end FourBar", "end"), None),
            (TEXT.replace("crank(r={0.4", "crank(r={0.35"), 0.35),
        ],
        2,
    ):
        with urlopen(f"{page.url}events?page=p", timeout=60) as events:
            assert events.readline() == b": open\n"
            editor.change(uri, text, version)
            while await asyncio.to_thread(events.readline) != b"event: edited\n":
                pass
            answer = await asyncio.to_thread(_run, page.url)
        assert bool(answer["problems"]) == ("scene" not in answer) == (length is None)
        if length is not None:
            assert _value(answer, "crank.r[1]") == length


def _run(url: str) -> Any:
    kind = {"Content-Type": "application/json"}
    with urlopen(Request(f"{url}run", data=b'{"page": "p"}', headers=kind), timeout=60) as answer:
        return json.load(answer)


def _value(answer: Any, name: str) -> float:
    fields = (f for g in answer["model"]["groups"] for f in g["fields"])
    return next(float(f["value"]) for f in fields if f["name"] == name)


async def test_parts_and_places(client: LanguageClient) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    line = next(i for i, s in enumerate(TEXT.split("\n")) if "connect(coupler.frame_b" in s)
    asked = {"textDocument": {"uri": uri}, "position": {"line": line, "character": 22}}
    part = await client.protocol.send_request_async("planarc/partAt", asked)
    assert part[1] == "coupler.frame_b"
    place = await client.protocol.send_request_async(
        "planarc/placeOf", {"uri": uri, "class": "FourBar", "component": "coupler"}
    )
    assert place.uri == uri
    assert "coupler(r" in TEXT.split("\n")[place.range.start.line]
    models = await client.protocol.send_request_async(
        "planarc/models", {"textDocument": {"uri": uri}}
    )
    assert len(models) == 1


async def test_a_code_is_explained(client: LanguageClient) -> None:
    Editor(client)
    said = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams("planarc.handbook", arguments=[{"code": "F210"}])
    )
    assert said["text"].startswith("## F210")


@pytest.mark.parametrize(
    ("mark", "shift", "name"),
    [
        ("revA.frame_b", 1, "PlanarMultiBody.Joints.Revolute"),  # the class of a component
        ("revA.frame_b", 6, "PlanarMultiBody.Interfaces.Frame_b"),
        ("Revolute revA", 2, "PlanarMultiBody.Joints.Revolute"),
        ("phi(start=1", 1, "PlanarMultiBody.Joints.Revolute"),  # what declares a variable
        ("equation\n", 2, "FourBar"),
    ],
)
async def test_the_page_of_what_stands_at_a_place(
    client: LanguageClient, mark: str, shift: int, name: str
) -> None:
    editor = Editor(client)
    uri = editor.open(FOUR_BAR)
    before = TEXT[: TEXT.index(mark) + shift]
    line, character = before.count("\n"), len(before.rpartition("\n")[2])
    place = {"uri": uri, "position": {"line": line, "character": character}}
    said = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams("planarc.handbook", arguments=[place])
    )
    assert said["class"] == name
    page, _, section = said["url"].removeprefix("file://").partition("#")
    assert section == name
    assert f'id="{name}"' in Path(page).read_text("utf-8")
    await client.workspace_symbol_async(lsp.WorkspaceSymbolParams("nothing"))  # a turn later
    assert [shown.uri for shown in client.shown_documents] == [said["url"]]


async def test_the_page_of_a_class_by_its_name(client: LanguageClient) -> None:
    editor = Editor(client)
    editor.open(FOUR_BAR)
    said = await client.workspace_execute_command_async(
        lsp.ExecuteCommandParams("planarc.handbook", arguments=["PlanarMultiBody.Forces.Spring"])
    )
    assert said["url"].endswith("handbook.html#PlanarMultiBody.Forces.Spring")
    with pytest.raises(JsonRpcException, match="there is no class"):
        await client.workspace_execute_command_async(
            lsp.ExecuteCommandParams("planarc.handbook", arguments=["No.Such"])
        )
