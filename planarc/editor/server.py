"""The language server: the life of a text in it, and its own.

Reference: Language Server Protocol 3.17.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable
from socket import create_server, socket
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import PyglsError

from planarc.core.diagnostic import usage_error
from planarc.editor import convert, requests
from planarc.editor.convert import path_of
from planarc.editor.peer import Peer

_log = logging.getLogger("planarc.editor")


def _changed(peer: Peer, params: lsp.DidChangeTextDocumentParams) -> None:
    document = params.text_document
    text = peer.session.texts.get(path_of(document.uri))
    content = "" if text is None else text.source.text
    touched = 0
    for change in params.content_changes:
        content, touched = convert.apply(content, change, peer.units)
    peer.put(document.uri, content, document.version, touched)


def _opened(peer: Peer, params: lsp.DidOpenTextDocumentParams) -> None:
    document = params.text_document
    peer.put(document.uri, document.text, document.version)


def _watched(peer: Peer, params: lsp.DidChangeWatchedFilesParams) -> None:
    peer.session.look_again()


def _ended(peer: Peer, params: None) -> None:
    peer.session.stop()
    peer.pages.stop()


_LIFE: dict[str, Callable[..., Any]] = {
    lsp.INITIALIZE: lambda peer, params: peer.begin(params),
    lsp.SHUTDOWN: _ended,
    lsp.TEXT_DOCUMENT_DID_OPEN: _opened,
    lsp.TEXT_DOCUMENT_DID_CHANGE: _changed,
    lsp.TEXT_DOCUMENT_DID_CLOSE: lambda peer, params: peer.forget(params.text_document.uri),
    lsp.TEXT_DOCUMENT_DID_SAVE: lambda peer, params: peer.session.look_again(),
    lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES: _watched,
    lsp.WORKSPACE_DID_CHANGE_CONFIGURATION: lambda peer, params: peer.configure(params.settings),
}


def make_server(pause: float = 0.01) -> Peer:
    """A server that answers all that it can, not yet connected."""
    peer = Peer(pause)
    for method, handler in _LIFE.items():
        peer.answer(method, handler)
    requests.register(peer)
    return peer


def serve(host: str = "127.0.0.1", port: int | None = None) -> None:
    """Speak with one client, over TCP where a port is given, else over the standard streams.

    Raises UsageError C280 where the port is taken.
    """
    # A key is answered while a check runs: threads take turns oftener than Python's 5 ms.
    sys.setswitchinterval(0.001)
    peer = make_server()
    try:
        if port is not None:
            connection = _accept(host, port)
            with connection, connection.makefile("rb") as read, connection.makefile("wb") as write:
                peer.start_io(read, write)
            return
        # What a library might print must not get between the messages.
        with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:
            os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
            peer.start_io(None, out)
    except PyglsError as problem:
        _log.error("%s", problem)


def _accept(host: str, port: int) -> socket:
    """The connection of the first client."""
    try:
        with create_server((host, port)) as listener:
            return listener.accept()[0]
    except OSError as problem:
        reason = (problem.strerror or str(problem)).lower()
        hint = "choose another one with `--tcp`"
        raise usage_error("C280", f"cannot listen on port {port}: {reason}", hint=hint) from None
