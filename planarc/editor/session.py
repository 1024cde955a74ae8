"""What a language server knows: open texts, libraries, findings; no protocol in it.

put, close        an edition of a text; its models are checked when typing pauses
text, view        what is asked of a place
publish           called with a text and its diagnostics, from the worker's thread
seen              called with a model of it before that, as soon as its equations are sorted; true
                  where it is shown
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Sequence
from pathlib import Path

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic
from planarc.editor.check import Finding, Wanted, all_of, ask, check_text
from planarc.editor.facts import Facts, facts_of
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text, Texts
from planarc.editor.view import View
from planarc.editor.worker import Worker
from planarc.probe.check import Seen

#: Called with each stage of an edition's diagnostics; the last time with `done`.
Publish = Callable[[Text, tuple[Diagnostic, ...], bool], None]

#: Seconds for the picture of a model, before facts are looked for.
_REST = 0.4


class Session:
    def __init__(
        self,
        publish: Publish,
        learned: Callable[[Text], None],
        failed: Callable[[Exception], None],
        pause: float = 0.01,
        seen: Callable[[Text, str, Seen, Wanted], bool] = lambda *_: False,
    ) -> None:
        self.texts = Texts()
        self.shelf = Shelf(self.texts)
        self.folders: tuple[Path, ...] = ()
        self._publish, self._learned, self._failed, self._seen = publish, learned, failed, seen
        self._tidied = False
        self._findings: dict[Path, dict[str, Finding]] = {}
        self._views: dict[Path, View] = {}
        self._facts: dict[tuple[Path, str], Facts] = {}
        self._told: dict[Path, tuple[Diagnostic, ...]] = {}
        self._touched: dict[Path, int] = {}
        self._worker = Worker(self._check, failed, pause)

    def configure(self, libraries: Sequence[Path]) -> None:
        """Take other folders of libraries; every open text is checked again."""
        self.shelf = Shelf(self.texts, libraries)
        self.look_again()

    def look_again(self) -> None:
        """Check all open texts: files may have changed on disk."""
        self._views.clear()
        for text in self.texts:
            self._worker.ask(text.path)

    def put(self, path: Path, content: str, version: int = 0, touched: int = 0) -> Text:
        """Take an edition of a text, edited at a place."""
        before = self.texts.get(path)
        text = self.texts.put(path, content, version)
        self._views.clear()
        self._touched[path] = touched
        self._worker.ask(path, 0.0 if before is None else None)
        return text

    def close(self, path: Path) -> None:
        self._worker.forget(path)
        self.texts.close(path)
        self._views.clear()
        self._findings.pop(path, None)
        self._told.pop(path, None)
        for key in [k for k in self._facts if k[0] == path]:
            del self._facts[key]

    def stop(self) -> None:
        self._worker.stop()

    def text(self, path: Path) -> Text:
        """The open text; one that is not open is read from its file. Raises OSError."""
        found = self.texts.get(path)
        if found is None:
            from planarc.core.files import read_plain
            from planarc.core.source import decode

            found = Text(path, decode(read_plain(path)))
        return found

    def view(self, text: Text) -> View:
        """The names around a text, looked up in this edition of all texts."""
        view = self._views.get(text.path)
        if view is None or view.text is not text:
            view = self._views[text.path] = View(self.shelf, text)
        return view

    def findings(self, path: Path) -> dict[str, Finding]:
        """The last findings of a text's models by name."""
        return self._findings.get(path, {})

    def diagnostics(self, path: Path) -> tuple[Diagnostic, ...]:
        """The diagnostics of the last edition of a text that was checked."""
        return self._told.get(path, ())

    def facts(self, path: Path, name: str) -> Facts | None:
        """What the last check of a class that was right told of its variables."""
        return self._facts.get((path, name))

    def _check(self, path: Path, wanted: Wanted) -> None:
        text = self.texts.get(path)
        if text is None:
            return
        found: list[Finding] = []
        if text.errors:
            self._publish(text, text.errors, False)
        first = text.chain(self._touched.get(path, 0))
        name = ".".join(([first[0]] if first[0] else []) + [c.name for c in first[1]])
        shown: list[bool] = []

        def watch(model: str, seen: Seen) -> None:
            shown.append(self._seen(text, model, seen, wanted))

        for finding in check_text(self.shelf, text, wanted, name, watch):
            found.append(finding)
            ask(wanted)
            if len(found) == 1:
                self._publish(text, all_of(text, found), False)
        ask(wanted)
        self._findings[path] = {f.name: replace(f, seen=None) for f in found}
        self._told[path] = all_of(text, found)
        self._publish(text, all_of(text, found), True)
        if any(shown):
            self._worker.rest(_REST)
        for finding in found:
            ask(wanted)
            if finding.seen is not None:
                self._learn(path, finding)
        self._learned(text)
        found.clear()
        ask(wanted)
        self._tidy()

    def _learn(self, path: Path, finding: Finding) -> None:
        assert finding.seen is not None
        try:
            self._facts[path, finding.name] = facts_of(finding.seen)
        except Exception as problem:  # told, and the next model is looked at
            self._failed(problem)

    def _tidy(self) -> None:
        """Search for cycles while nobody types. What is there after the first check are libraries,
        which stay: they are not searched again."""
        gc.collect()
        if not self._tidied:
            gc.freeze()
        self._tidied = True
