"""The other side of the protocol: a client, what it said of itself, and the session behind it.

A message that is malformed is answered with the protocol's error and logged; the server lives on.

Reference: Language Server Protocol 3.17.
"""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol, default_converter
from pygls.protocol.json_rpc import JsonRPCNotification, JsonRPCRequestMessage
from pygls.protocol.language_server import lsp_method

from planarc.core.diagnostic import Diagnostic
from planarc.core.version import __version__
from planarc.editor import convert
from planarc.editor.check import Wanted
from planarc.editor.convert import Units, path_of
from planarc.editor.pages import Pages
from planarc.editor.session import Session
from planarc.editor.texts import Text
from planarc.probe.check import Seen

_log = logging.getLogger("planarc.editor")
_PARSE_ERROR = -32700


class RequestFailed(JsonRpcException):
    """A request that is right, but cannot be carried out; the client shows the reason."""

    CODE = -32803
    MESSAGE = "request failed"


Handled = Generator[Any, Any, None]


class _Protocol(LanguageServerProtocol):
    """The protocol without its own copies of the texts: a text is ours alone."""

    @lsp_method(lsp.TEXT_DOCUMENT_DID_OPEN)
    def lsp_text_document__did_open(self, params: lsp.DidOpenTextDocumentParams) -> Handled:
        yield self.fm.features[lsp.TEXT_DOCUMENT_DID_OPEN], (params,), None

    @lsp_method(lsp.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(self, params: lsp.DidChangeTextDocumentParams) -> Handled:
        yield self.fm.features[lsp.TEXT_DOCUMENT_DID_CHANGE], (params,), None

    @lsp_method(lsp.TEXT_DOCUMENT_DID_CLOSE)
    def lsp_text_document__did_close(self, params: lsp.DidCloseTextDocumentParams) -> Handled:
        yield self.fm.features[lsp.TEXT_DOCUMENT_DID_CLOSE], (params,), None

    def structure_message(self, data: dict[str, Any]) -> Any:
        """A message as an object; who sent a malformed question is told so."""
        try:
            return super().structure_message(data)
        except JsonRpcException as problem:
            if data.get("id") is not None and "method" in data:
                self._send_response(data["id"], error=problem.to_response_error())
            raise


def _converter() -> Any:
    """The protocol's converter; the parameters of our own requests stay plain."""
    converter: Any = default_converter()  # type: ignore[no-untyped-call]
    for kind in (JsonRPCRequestMessage, JsonRPCNotification):
        converter.register_structure_hook(kind, lambda data, cls: cls(**data))
    return converter


class Peer(LanguageServer):
    """What a client said of itself, and the session behind it."""

    def __init__(self, pause: float = 0.01) -> None:
        super().__init__(
            "planarc",
            __version__,
            text_document_sync_kind=lsp.TextDocumentSyncKind.Incremental,
            protocol_cls=_Protocol,
            converter_factory=_converter,
        )
        self.units = Units()
        self.options: dict[str, Any] = {}
        told = self._published, self._learned, self._failed
        self.session = Session(*told, pause, self._seen)
        self.pages = Pages(self._failed)
        self._uris: dict[Path, str] = {}
        self.used: str | None = None  # the address of the open text that was last used
        self._loop: asyncio.AbstractEventLoop | None = None

    # Its life

    def begin(self, params: lsp.InitializeParams) -> None:
        self._loop = asyncio.get_running_loop()
        self.units = Units(str(getattr(self.workspace.position_encoding, "value", "utf-16")))
        folders = [path_of(f.uri) for f in params.workspace_folders or ()]
        root = params.root_uri
        self.session.folders = tuple(folders or ([path_of(root)] if root else []))
        self.configure(params.initialization_options)

    def configure(self, options: object) -> None:
        """Take the client's settings, those that have the right form."""
        if not isinstance(options, dict):
            return
        options = options.get("planarc", options)
        if not isinstance(options, dict):
            return
        self.options |= options
        named = options.get("libraries")
        if isinstance(named, list):
            self.session.configure([Path(n).expanduser() for n in named if isinstance(n, str)])

    def answer(self, method: str, handler: Callable[[Peer, Any], Any], options: Any = None) -> None:
        """Let a function of this peer and the parameters answer a method."""

        def answer(params: Any) -> Any:
            return handler(self, params)

        self.feature(method, options)(answer)

    def answer_slowly(
        self, method: str, handler: Callable[[Peer, Any], Any], options: Any = None
    ) -> None:
        """Let a function answer a method in another thread: other questions are answered
        meanwhile."""

        async def answer(params: Any) -> Any:
            return await asyncio.to_thread(handler, self, params)

        self.feature(method, options)(answer)

    def report_server_error(self, error: Exception, source: Any) -> None:
        _log.error("%s", error)
        if isinstance(error, json.JSONDecodeError | UnicodeDecodeError):
            told = {"code": _PARSE_ERROR, "message": f"the message is no JSON: {error}"}
            self.protocol._send_data({"jsonrpc": "2.0", "id": None, "error": told})

    # Texts

    def text_at(self, uri: str) -> Text:
        """The text of an address. Raises OSError where it is neither open nor a file."""
        if path_of(uri) in self._uris:
            self.used = uri
        return self.session.text(path_of(uri))

    def uri(self, path: Path) -> str:
        return self._uris.get(path) or convert.uri_of(path)

    def put(self, uri: str, content: str, edition: int, touched: int = 0) -> None:
        path = path_of(uri)
        self._uris[path] = self.used = uri
        self.session.put(path, content, edition, touched)

    def forget(self, uri: str) -> None:
        self.session.close(path_of(uri))
        self.pages.close(path_of(uri))
        self._uris.pop(path_of(uri), None)
        if self.used == uri:
            self.used = next(reversed(self._uris.values()), None)
        self.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, []))

    # From the worker's thread

    def in_loop(self, call: Callable[[], None]) -> None:
        """Call in the thread that writes to the client."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call)

    def _failed(self, problem: Exception) -> None:
        _log.error("the check of a text failed", exc_info=problem)

    def _learned(self, text: Text) -> None:
        """Let the editor ask again for what stands beside a text."""
        workspace = self.client_capabilities.workspace
        if workspace and workspace.inlay_hint and workspace.inlay_hint.refresh_support:
            self.in_loop(self._refresh)

    def _refresh(self) -> None:
        self.workspace_inlay_hint_refresh(None)

    def _published(self, text: Text, found: tuple[Diagnostic, ...], done: bool) -> None:
        self.in_loop(lambda: self._tell(text, found, done))
        if done:
            self.pages.settle(self.session.shelf, text)

    def _seen(self, text: Text, name: str, seen: Seen, wanted: Wanted) -> bool:
        return self.pages.follow(self.session.shelf, text, name, seen, wanted)

    def _tell(self, text: Text, found: tuple[Diagnostic, ...], done: bool) -> None:
        if self.session.texts.get(text.path) is not text:
            return  # a later edition is there
        uri = self.uri(text.path)
        told = [convert.diagnostic(d, self.units, text.source) for d in found]
        self.text_document_publish_diagnostics(
            lsp.PublishDiagnosticsParams(uri, told, text.version)
        )
        if done:
            self.protocol.notify("planarc/checked", self._summary(text, uri))

    def _summary(self, text: Text, uri: str) -> dict[str, Any]:
        """What the check of a text found, model by model."""
        classes = []
        for finding in self.session.findings(text.path).values():
            told: dict[str, object] = {"class": finding.name, "ok": finding.ok}
            if finding.checked is not None:
                found = finding.checked
                told |= {"states": found.states, "equations": found.equations_after}
                if found.mechanism is not None:
                    told["mobility"] = found.mechanism.mobility
            classes.append(told)
        ok = all(c["ok"] for c in classes) and not text.errors
        return {"uri": uri, "version": text.version, "ok": ok, "classes": classes}
