"""The live pages beside texts show the newest edition, and each edition once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from planarc.editor import pages
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Texts
from planarc.live.server import LiveServer

PATH = Path("untitled:m.pmo")


class AtOnce:
    """A worker without a thread, which does each thing as often as it is asked to."""

    def __init__(self, work: Callable[..., None], *_: Any) -> None:
        self._work = work

    def ask(self, key: pages.Key) -> None:
        self._work(key, lambda: True)

    def stop(self) -> None:
        pass


def _text(rate: int) -> str:
    return f"model M\n  Real x(start=0);\nequation\n  der(x) = {rate};\nend M;\n"


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The texts that pages were told to follow."""
    found: list[str] = []
    monkeypatch.setattr(pages, "Worker", AtOnce)
    monkeypatch.setattr(LiveServer, "follow", lambda self, r, *more: found.append(r.text))
    return found


def test_an_overtaken_edition_is_not_shown(shown: list[str]) -> None:
    texts = Texts()
    shelf, made = Shelf(texts), pages.Pages(lambda problem: None)
    try:
        made.open(shelf, texts.put(PATH, _text(1)), None)
        second = texts.put(PATH, _text(2))
        third = texts.put(PATH, _text(3))
        made.settle(shelf, second)
        assert shown == []
        made.settle(shelf, third)
        assert shown == [_text(3)]
    finally:
        made.stop()


def test_an_edition_is_shown_once(shown: list[str]) -> None:
    """However often the worker is woken for it."""
    texts = Texts()
    shelf, made = Shelf(texts), pages.Pages(lambda problem: None)
    try:
        made.open(shelf, texts.put(PATH, _text(1)), None)
        made.settle(shelf, second := texts.put(PATH, _text(2)))
        made.settle(shelf, second)
        made._worker.ask((PATH, "M"))  # as where an edition comes between two looks of the thread
        assert shown == [_text(2)]
    finally:
        made.stop()
