"""The commands that a client lets the server carry out, and planarc's own requests.

planarc.simulate, planarc.check   {uri, class?}         {ok, text}, and a message
planarc.view                      {uri, class?}         {url, class}, and the page is shown
planarc.handbook                  {code}                {text}
                                  {uri, position}       {url, class}, and the page of the class is
                                  {uri, class}          shown
                                  a text alone is the class, or the code; without an address the
                                  text that was last used is meant
planarc/livePage, closePage       {uri, class?}         {url, class}
planarc/partAt                    a position            {class, component}
planarc/placeOf                   {uri, class, component}   a location
planarc/models                    {textDocument}        [{class, range}]
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from typing import Any

from lsprotocol import types as lsp
from pygls.exceptions import JsonRpcInvalidParams

from planarc.core.diagnostic import PlanarcError
from planarc.core.options import Redundant
from planarc.editor import handbook, runs
from planarc.editor.convert import path_of
from planarc.editor.hints import lenses_of
from planarc.editor.meaning import name_place
from planarc.editor.parts import part_at, place_of
from planarc.editor.peer import Peer, RequestFailed
from planarc.editor.view import View

_CODE = re.compile(r"[A-Z]\d{3}")

Asked = dict[str, Any]


def register(peer: Peer) -> None:
    """Let a peer carry out the commands and answer the requests."""
    for name, work in _COMMANDS.items():
        peer.command(name)(_command(peer, work))
    for method, answer in _REQUESTS.items():
        peer.answer(method, _careful(answer))
    for method, answer in _SLOW.items():
        peer.answer_slowly(method, _careful(answer))


def _command(peer: Peer, work: Callable[[Peer, Asked], Any]) -> Callable[..., Any]:
    async def run(*arguments: Any) -> Any:
        first = _addressed(peer, arguments[0] if arguments else {})
        return await asyncio.to_thread(_careful(work), peer, first)

    return run


def _addressed(peer: Peer, given: Any) -> Any:
    """What a command is given, with what an editor's command line leaves out of it."""
    if isinstance(given, str):
        given = {"code" if _CODE.fullmatch(given) else "class": given}
    if not isinstance(given, dict) or given.keys() & {"uri", "textDocument", "code"}:
        return given
    if peer.used is None:
        raise RequestFailed("no text is open: open a model first")
    return {**given, "uri": peer.used}


def _careful(work: Callable[[Peer, Asked], Any]) -> Callable[[Peer, Any], Any]:
    """Work that answers with the protocol's errors."""

    def answer(peer: Peer, asked: Any) -> Any:
        if not isinstance(asked, dict):
            raise JsonRpcInvalidParams("one object is expected")
        try:
            return work(peer, asked)
        except (KeyError, TypeError, AttributeError) as problem:
            raise JsonRpcInvalidParams(f"{problem!r} is missing or wrong") from None
        except (PlanarcError, OSError) as problem:
            raise RequestFailed(str(problem)) from None

    return answer


def _document(asked: Asked) -> str:
    document = asked.get("textDocument")
    found = document["uri"] if isinstance(document, dict) else asked["uri"]
    if not isinstance(found, str):
        raise TypeError("uri")
    return found


def _position(asked: Asked) -> lsp.Position:
    return lsp.Position(int(asked["position"]["line"]), int(asked["position"]["character"]))


def _say(peer: Peer, said: runs.Said) -> Asked:
    kind = lsp.MessageType.Info if said.ok else lsp.MessageType.Error
    peer.in_loop(lambda: peer.window_show_message(lsp.ShowMessageParams(kind, said.text)))
    return {"ok": said.ok, "text": said.text}


def _check(peer: Peer, asked: Asked) -> Asked:
    shelf, text = peer.session.shelf, peer.text_at(_document(asked))
    return _say(peer, runs.check(runs.request_of(shelf, text, asked.get("class"))))


def _simulate(peer: Peer, asked: Asked) -> Asked:
    shelf, text = peer.session.shelf, peer.text_at(_document(asked))
    redundant = Redundant.ACCEPT if asked.get("redundant") == "accept" else Redundant.REFUSE
    return _say(peer, runs.simulate(runs.request_of(shelf, text, asked.get("class"), redundant)))


def _page(peer: Peer, asked: Asked) -> Asked:
    text = peer.text_at(_document(asked))
    address, name = peer.pages.open(peer.session.shelf, text, asked.get("class"))
    return {"url": address, "class": name}


def _view(peer: Peer, asked: Asked) -> Asked:
    found = _page(peer, asked)
    told = {**found, "uri": _document(asked)}
    if peer.options.get("panel"):
        peer.in_loop(lambda: peer.protocol.notify("planarc/showPage", told))
    else:
        _show(peer, found["url"])
    return found


def _show(peer: Peer, url: str) -> None:
    """Let the client open a page in a browser."""

    def show() -> None:
        peer.window_show_document(lsp.ShowDocumentParams(url, external=True))

    peer.in_loop(show)


def _close(peer: Peer, asked: Asked) -> None:
    peer.pages.close(path_of(_document(asked)), asked.get("class"))


def _handbook(peer: Peer, asked: Asked) -> Asked:
    if "code" in asked:
        return _explained(asked)
    text = peer.text_at(_document(asked))
    view = View(peer.session.shelf, text)  # of this thread
    name = asked.get("class")
    if not isinstance(name, str):
        name = handbook.class_at(view, peer.units.offset(text.source, _position(asked)))
    url = handbook.class_page(view, name)
    if url is None:
        raise RequestFailed(f"there is no class `{name}`" if name else "no class stands here")
    _show(peer, url)
    return {"url": url, "class": name}


def _explained(asked: Asked) -> Asked:
    from planarc.catalog.explanations import Code, explain

    found = explain(Code[asked["code"]])
    blocks = [f"```{kind}\n{text.rstrip()}\n```" for kind, text in found.example]
    title = f"## {found.code.name}: {found.code.value}"
    return {"text": "\n\n".join([title, *found.cause, *blocks, f"Cure: {found.cure}"])}


def _part_at(peer: Peer, asked: Asked) -> Asked | None:
    text = peer.text_at(_document(asked))
    where = peer.units.offset(text.source, _position(asked))
    found = part_at(peer.session.view(text), where)
    return None if found is None else {"class": found[0], "component": found[1]}


def _place_of(peer: Peer, asked: Asked) -> lsp.Location | None:
    view = peer.session.view(peer.text_at(_document(asked)))
    span = place_of(view, asked["class"], asked["component"])
    if span is None or span.source.path is None:
        return None
    return lsp.Location(peer.uri(span.source.path), peer.units.range(span))


def _models(peer: Peer, asked: Asked) -> list[Asked]:
    text = peer.text_at(_document(asked))
    ranges = {lens.name: name_place(text.classes[lens.name]) for lens in lenses_of(text)}
    return [{"class": name, "range": peer.units.range(span)} for name, span in ranges.items()]


_COMMANDS: dict[str, Callable[[Peer, Asked], Any]] = {
    "planarc.simulate": _simulate,
    "planarc.check": _check,
    "planarc.view": _view,
    "planarc.handbook": _handbook,
}
_SLOW: dict[str, Callable[[Peer, Asked], Any]] = {
    "planarc/livePage": _page,
    "planarc/closePage": _close,
}
_REQUESTS: dict[str, Callable[[Peer, Asked], Any]] = {
    "planarc/partAt": _part_at,
    "planarc/placeOf": _place_of,
    "planarc/models": _models,
}
