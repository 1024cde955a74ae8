"""An editor's side of the language server: `Editor` opens texts, waits for diagnostics, asks."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest_lsp
from lsprotocol import types as lsp
from pytest_lsp import ClientServerConfig, LanguageClient

EXAMPLES = Path(__file__).parents[2] / "examples"
PATIENCE = 60.0
_LONGEST = 10 * PATIENCE  # seconds of one session
_COMMAND = [sys.executable, "-m", "planarc", "lsp"]


class Editor:
    """A client with one text, at whose places it asks; `|` in a text marks the cursor."""

    def __init__(self, client: LanguageClient) -> None:
        self.client = client
        self.done: dict[str, Any] = {}

        def checked(params: Any) -> None:
            self.done[params.uri] = params

        client.feature("planarc/checked")(checked)

    def open(self, path: Path, text: str | None = None, version: int = 1) -> str:
        """Open a text, saved or not; gives its address."""
        uri = path.as_uri() if path.is_absolute() else str(path)
        text = path.read_text("utf-8") if text is None else text
        item = lsp.TextDocumentItem(uri, "modelica", version, text)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        return uri

    def mark(self, text: str, name: str = "one") -> tuple[str, lsp.Position]:
        """Open an unsaved text whose `|` is the cursor."""
        before, _, after = text.partition("|")
        line, column = before.count("\n"), len(before.rpartition("\n")[2])
        return self.open(Path(f"untitled:{name}"), before + after), lsp.Position(line, column)

    def change(self, uri: str, text: str, version: int) -> None:
        self.edit(uri, [lsp.TextDocumentContentChangeWholeDocument(text)], version)

    def edit(self, uri: str, changes: list[Any], version: int) -> None:
        document = lsp.VersionedTextDocumentIdentifier(version, uri)
        self.client.text_document_did_change(lsp.DidChangeTextDocumentParams(document, changes))

    async def checked(self, uri: str, version: int = 1) -> list[lsp.Diagnostic]:
        """The diagnostics of an edition, once all of it is checked."""

        async def wait() -> None:
            while uri not in self.done or self.done[uri].version != version:
                await asyncio.sleep(0.01)

        await asyncio.wait_for(wait(), PATIENCE)
        return list(self.client.diagnostics.get(uri, ()))


@pytest_lsp.fixture(config=ClientServerConfig(server_command=_COMMAND))
async def client(lsp_client: LanguageClient) -> AsyncIterator[None]:
    # A question without an answer fails its test, and does not hold up all others.
    server = lsp_client._server
    assert server is not None
    end = asyncio.get_running_loop().call_later(_LONGEST, server.kill)
    await lsp_client.initialize_session(
        lsp.InitializeParams(capabilities=lsp.ClientCapabilities(), root_uri=EXAMPLES.as_uri())
    )
    yield
    end.cancel()
    await lsp_client.shutdown_session()


def codes(found: list[lsp.Diagnostic]) -> list[tuple[int, str]]:
    """Lines, counted from 1, with the codes that stand there."""
    return sorted((d.range.start.line + 1, str(d.code)) for d in found)
