"""The live pages beside texts, each of one model; they follow what is typed.

open       the address of a model's page
follow     a text was edited, and its check saw the model: the page shows what that made of it
settle     the check is over: pages whose model it did not see say why

Code is made in a thread of its own: mistakes are told meanwhile.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, TypeAlias

from planarc.core.clock import Clock
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import fastest_backend
from planarc.editor.check import Wanted, ask
from planarc.editor.runs import request_of
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text
from planarc.editor.worker import Worker
from planarc.probe.check import Seen

if TYPE_CHECKING:
    from planarc.editor.handover import Draft
    from planarc.live.server import LiveServer

Key: TypeAlias = tuple[Path, str]


class Edition(Data):
    """A text for a page, and what its check made of the model."""

    shelf: Shelf
    text: Text
    draft: Draft | None = None


class Pages:
    def __init__(self, failed: Callable[[Exception], None]) -> None:
        self._open: dict[Key, LiveServer] = {}
        self._next: dict[Key, Edition] = {}
        self._shown: dict[Key, Edition] = {}
        self._lock = Lock()
        self._worker = Worker(self._show, failed, 0.0)

    def open(self, shelf: Shelf, text: Text, name: str | None) -> tuple[str, str]:
        """The address of a model's page, and the model. Raises PlanarcError where it is wrong."""
        from planarc.live.server import LiveServer
        from planarc.live.session import Session

        request = request_of(shelf, text, name)
        assert request.class_name is not None
        key = text.path, request.class_name
        with self._lock:
            if key not in self._open:
                page = LiveServer(Session(request, fastest_backend()), request, framed=True)
                page.start()
                self._open[key], self._next[key] = page, Edition(shelf, text)
            return self._open[key].address, request.class_name

    def follow(self, shelf: Shelf, text: Text, name: str, seen: Seen, wanted: Wanted) -> bool:
        """Let the page of a model show what a check made of it; false where there is none.
        Raises Overtaken."""
        key = text.path, name
        if not self._is_old(key, text) or text.errors:  # what was left out is not its model
            return False
        from planarc.editor.handover import draft_of

        draft = draft_of(seen, fastest_backend(), Clock(watch=lambda: ask(wanted)))
        self._put(key, Edition(shelf, text, draft))
        return True

    def settle(self, shelf: Shelf, text: Text) -> None:
        """Let the pages of a text show its present edition, those that do not yet."""
        for key, _ in self._of(text.path):
            if self._is_old(key, text):
                self._put(key, Edition(shelf, text))

    def _is_old(self, key: Key, text: Text) -> bool:
        """True for an open page that shows another edition."""
        known = self._next.get(key)
        return known is not None and known.text is not text

    def _put(self, key: Key, edition: Edition) -> None:
        self._next[key] = edition
        self._worker.ask(key)

    def _show(self, key: Key, wanted: Wanted) -> None:
        page, edition = self._open.get(key), self._next.get(key)
        if page is None or edition is None or self._shown.get(key) is edition:
            return  # closed, or asked for again while it was shown
        shelf, text = edition.shelf, edition.text
        if shelf.texts.get(text.path) is not text:  # another one comes
            return
        try:
            request = request_of(shelf, text, key[1])
            library = shelf.target(text).library
        except PlanarcError:  # libraries that are gone: the check tells of them
            return
        if edition.draft is None:
            page.follow(request)
        else:
            from planarc.editor.handover import model_of

            clock = Clock(watch=lambda: ask(wanted))
            made = model_of(edition.draft, request, fastest_backend(), clock)
            page.follow(request, made, library)
        self._shown[key] = edition

    def close(self, path: Path, name: str | None = None) -> None:
        """End the pages of a text, or that of one model."""
        for key, page in self._of(path):
            if name is None or key[1] == name:
                with self._lock:
                    self._open.pop(key, None)
                    self._next.pop(key, None)
                    self._shown.pop(key, None)
                page.stop()

    def stop(self) -> None:
        for path in {path for path, _ in self._open}:
            self.close(path)
        self._worker.stop()

    def _of(self, path: Path) -> list[tuple[Key, LiveServer]]:
        with self._lock:
            return [(key, page) for key, page in self._open.items() if key[0] == path]
