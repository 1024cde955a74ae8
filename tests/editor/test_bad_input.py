"""Bad input: files that go, classes twice, rubbish, circles, and messages that are malformed."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from lsprotocol import types as lsp
from pytest_lsp import LanguageClient

from tests.editor.conftest import EXAMPLES, PATIENCE, Editor, codes

USES = "model M\n  Lib.Part p;\n  Real x=p.k;\nend M;\n"
PART = "within Lib;\nmodel Part\n  parameter Real k=1;\nend Part;\n"


def library(folder: Path) -> Path:
    (folder / "Lib").mkdir(parents=True)
    (folder / "Lib" / "package.mo").write_text("package Lib\nend Lib;\n", encoding="utf-8")
    (folder / "Lib" / "Part.mo").write_text(PART, encoding="utf-8")
    return folder


def settings(*libraries: Path) -> lsp.DidChangeConfigurationParams:
    return lsp.DidChangeConfigurationParams({"planarc": {"libraries": [str(p) for p in libraries]}})


@pytest.mark.asyncio
async def test_a_library_comes_and_goes(client: LanguageClient, tmp_path: Path) -> None:
    editor = Editor(client)
    folder = library(tmp_path / "libraries")
    client.workspace_did_change_configuration(settings(folder))
    uri = editor.open(tmp_path / "M.mo", USES)
    assert await editor.checked(uri) == []
    shutil.rmtree(folder)
    editor.change(uri, USES + "\n", 2)
    assert codes(await editor.checked(uri, 2)) == [(2, "F210")]
    hover = await client.text_document_hover_async(
        lsp.HoverParams(lsp.TextDocumentIdentifier(uri), lsp.Position(2, 11))
    )
    assert hover is None
    library(folder)
    editor.change(uri, USES, 3)
    assert await editor.checked(uri, 3) == []


@pytest.mark.asyncio
async def test_an_edit_of_a_library_is_seen_before_it_is_saved(
    client: LanguageClient, tmp_path: Path
) -> None:
    editor = Editor(client)
    folder = library(tmp_path / "libraries")
    client.workspace_did_change_configuration(settings(folder))
    uri = editor.open(tmp_path / "M.mo", USES)
    assert await editor.checked(uri) == []
    editor.open(folder / "Lib" / "Part.mo", PART.replace(" k=", " q="))
    editor.change(uri, USES + "\n", 2)
    assert codes(await editor.checked(uri, 2)) == [(3, "F213")]


@pytest.mark.asyncio
async def test_what_is_left_out_in_a_package_is_told_once(
    client: LanguageClient, tmp_path: Path
) -> None:
    editor, folder = Editor(client), tmp_path / "Top" / "Inner"
    folder.mkdir(parents=True)
    (tmp_path / "Top" / "package.mo").write_text("package Top\nend Top;\n")
    (folder / "package.mo").write_text("within Top;\npackage Inner\nend Inner;\n")
    text = "within Top.Inner;\nmodel M\n  Real y;\nequation\n  y = 2*;\nend M;\n"
    uri = editor.open(folder / "M.mo", text)
    assert codes(await editor.checked(uri)) == [(5, "P101")]


@pytest.mark.asyncio
async def test_two_files_define_one_class(client: LanguageClient, tmp_path: Path) -> None:
    editor = Editor(client)
    first, second = "model M\n  Real x=1;\nend M;\n", "model M\n  Real y=z;\nend M;\n"
    one = editor.open(tmp_path / "a.mo", first)
    other = editor.open(tmp_path / "b.mo", second)
    assert await editor.checked(one) == []
    assert codes(await editor.checked(other)) == [(2, "F210")]
    uri = editor.open(tmp_path / "c.mo", first + second)
    assert "F203" in [c for _, c in codes(await editor.checked(uri))]
    found = await client.text_document_document_symbol_async(
        lsp.DocumentSymbolParams(lsp.TextDocumentIdentifier(uri))
    )
    assert found is not None and len(found) == 2


@pytest.mark.asyncio
async def test_classes_that_extend_each_other(client: LanguageClient) -> None:
    editor = Editor(client)
    text = "model A\n  extends B;\n  Real x=1;\nend A;\nmodel B\n  extends A;\nend B;\n"
    uri = editor.open(Path("untitled:circle"), text)
    assert "F232" in [c for _, c in codes(await editor.checked(uri))]
    asked = lsp.TextDocumentIdentifier(uri)
    found = await client.text_document_hover_async(lsp.HoverParams(asked, lsp.Position(2, 7)))
    assert found is not None


@pytest.mark.asyncio
async def test_rubbish_with_the_right_ending(client: LanguageClient) -> None:
    editor = Editor(client)
    rubbish = bytes(range(256)).decode("latin-1") * 40
    uri = editor.open(Path("untitled:rubbish"), rubbish)
    assert codes(await editor.checked(uri)) == [(1, "P100")]
    asked, where = lsp.TextDocumentIdentifier(uri), lsp.Position(5, 3)
    await client.text_document_hover_async(lsp.HoverParams(asked, where))
    await client.text_document_completion_async(lsp.CompletionParams(asked, where))
    await client.text_document_definition_async(lsp.DefinitionParams(asked, where))
    await client.text_document_folding_range_async(lsp.FoldingRangeParams(asked))
    found = await client.text_document_document_symbol_async(lsp.DocumentSymbolParams(asked))
    assert found == []


@pytest.mark.asyncio
async def test_a_huge_file(client: LanguageClient) -> None:
    editor = Editor(client)
    lines = "".join(f'  parameter Real k{i}(min=0) = {i} "one of many";\n' for i in range(20_000))
    text = f"model Huge\n{lines}  Real x = k1 + kk;\nend Huge;\n"
    uri = editor.open(Path("untitled:huge"), text)
    assert codes(await editor.checked(uri)) == [(20_002, "F210")]


@pytest.mark.asyncio
async def test_a_file_that_is_not_there(client: LanguageClient, tmp_path: Path) -> None:
    Editor(client)
    gone = lsp.TextDocumentIdentifier((tmp_path / "gone.mo").as_uri())
    assert await client.text_document_hover_async(lsp.HoverParams(gone, lsp.Position(0, 0))) is None
    assert (
        await client.text_document_references_async(
            lsp.ReferenceParams(lsp.ReferenceContext(True), gone, lsp.Position(0, 0))
        )
        is None
    )


# Messages ---------------------------------------------------------------------------------------


def message(text: str) -> bytes:
    data = text.encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(data), data)


def asked(number: int | None, method: str, params: object) -> bytes:
    told: dict[str, object] = {"jsonrpc": "2.0", "method": method, "params": params}
    return message(json.dumps(told if number is None else {**told, "id": number}))


START = (
    asked(1, "initialize", {"processId": None, "rootUri": None, "capabilities": {}}),
    asked(None, "initialized", {}),
)


def test_one_client_over_tcp() -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "planarc", "lsp", "--tcp", str(port)]
    with subprocess.Popen(command, stderr=subprocess.PIPE) as server:
        client = _connected(port)
        with client, client.makefile("rb") as answers:
            client.sendall(b"".join(START) + asked(2, "shutdown", None) + asked(None, "exit", None))
            told = [a for a in _answers(answers.read()) if "id" in a]
        assert [a["id"] for a in told] == [1, 2]
        assert server.wait(PATIENCE) == 0
        assert server.stderr is not None and server.stderr.read() == b""


def _connected(port: int) -> socket.socket:
    for _ in range(600):
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            time.sleep(0.1)
    raise AssertionError("nobody listens")


def test_malformed_messages_are_answered_and_survived() -> None:
    uri = (EXAMPLES / "pendulum.pmo").as_uri()
    sent = [
        *START,
        message("{ this is no JSON"),
        asked(2, "textDocument/hover", {"textDocument": 3}),
        asked(3, "textDocument/noSuchThing", {}),
        asked(4, "textDocument/hover", {"textDocument": {"uri": uri},
                                        "position": {"line": 10**9, "character": 10**9}}),
        asked(5, "planarc/partAt", {"nothing": 1}),
        asked(6, "planarc/placeOf", [1, 2]),
        asked(None, "textDocument/didChange", {"textDocument": {"uri": uri, "version": 3},
                                               "contentChanges": [{"text": "model M end M;"}]}),
        asked(7, "textDocument/foldingRange", {"textDocument": {"uri": uri}}),
        asked(8, "shutdown", None),
        asked(None, "exit", None),
    ]  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "planarc", "lsp"], input=b"".join(sent), capture_output=True,
        timeout=120, check=False,
    )  # fmt: skip
    answers = {a.get("id"): a for a in _answers(done.stdout) if "method" not in a}
    assert answers[None]["error"]["code"] == -32700
    assert answers[2]["error"]["code"] == -32602
    assert answers[3]["error"]["code"] == -32601
    assert answers[4]["result"] is None
    assert answers[5]["error"]["code"] == -32602
    assert answers[6]["error"]["code"] == -32602
    assert answers[7]["result"] == []
    assert "result" in answers[8]


def _answers(data: bytes) -> list[dict[str, Any]]:
    found = []
    while data:
        head, _, rest = data.partition(b"\r\n\r\n")
        size = next(int(s.split(b":")[1]) for s in head.split(b"\r\n") if b"Length" in s)
        found.append(json.loads(rest[:size]))
        data = rest[size:]
    return found
