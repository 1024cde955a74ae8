"""What an editor waits for, and the memory of the language server, beside what is promised of them.

    python tests/benchmarks/editor_bench.py [--library DIR] [--write]

DIR holds the Modelica Standard Library; without it the rows of its file are left out. `--write`
puts the table into `docs/measured.json`, which the site shows. The start is that of the processor,
the median of four; other times are those of a clock, medians of seven.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from statistics import median
from typing import Any
from urllib.request import Request, urlopen

from figures import DATA, machine
from lsprotocol import types as lsp
from pygls.lsp.client import LanguageClient

ROOT = Path(__file__).parents[2]
TIMES = 7
REST = 0.3  # s between two keys
Row = tuple[str, float, float, str]  # what, measured, promised, unit


class Editor:
    """A client that notes when the diagnostics of an edition came."""

    def __init__(self) -> None:
        self.client = LanguageClient("bench", "1")
        self.told: dict[tuple[str, int | None], float] = {}
        self.done: set[tuple[str, int | None]] = set()

        @self.client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def tell(params: lsp.PublishDiagnosticsParams) -> None:
            self.told.setdefault((params.uri, params.version), time.perf_counter())

        @self.client.feature("planarc/checked")
        def finish(params: Any) -> None:
            self.done.add((params.uri, params.version))

    async def start(self, libraries: list[str]) -> float:
        """Seconds of the processor until the server answers; those of a clock where the system
        does not tell."""
        begin = time.perf_counter()
        await self.client.start_io(sys.executable, "-m", "planarc", "lsp")
        options = {"libraries": libraries}
        asked = lsp.InitializeParams(lsp.ClientCapabilities(), initialization_options=options)
        await self.client.initialize_async(asked)
        return processor(self.process) or time.perf_counter() - begin

    @property
    def process(self) -> int:
        return int(getattr(self.client, "_server").pid)  # noqa: B009

    async def stop(self) -> None:
        await self.client.shutdown_async(None)
        self.client.exit(None)

    def open(self, path: Path) -> tuple[str, str]:
        uri, text = path.as_uri(), path.read_text("utf-8")
        item = lsp.TextDocumentItem(uri, "modelica", 0, text)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))
        return uri, text

    def key(self, uri: str, where: lsp.Position, version: int, typed: str = " ") -> None:
        change = lsp.TextDocumentContentChangePartial(lsp.Range(where, where), typed)
        document = lsp.VersionedTextDocumentIdentifier(version, uri)
        self.client.text_document_did_change(lsp.DidChangeTextDocumentParams(document, [change]))

    async def wait(self, condition: Callable[[], bool]) -> None:
        while not condition():
            await asyncio.sleep(0.001)


def position(text: str, mark: str, shift: int) -> lsp.Position:
    at = text.index(mark) + shift
    return lsp.Position(text.count("\n", 0, at), at - text.rfind("\n", 0, at) - 1)


async def typed(
    editor: Editor, path: Path, mark: str, ask: tuple[str, int], name: str, promised: float
) -> list[Row]:
    """Diagnostics after a key behind a mark, then hover and completion at another place."""
    uri, text = editor.open(path)
    await editor.wait(lambda: (uri, 0) in editor.done)
    where, took = position(text, mark, len(mark)), []
    for version in range(1, TIMES + 1):
        begin, edition = time.perf_counter(), (uri, version)
        editor.key(uri, where, version)
        await editor.wait(lambda now=edition: now in editor.told)  # type: ignore[misc]
        took.append(editor.told[edition] - begin)
        await editor.wait(lambda now=edition: now in editor.done)  # type: ignore[misc]
        await asyncio.sleep(REST)
    document, at = lsp.TextDocumentIdentifier(uri), position(text, *ask)
    client = editor.client
    hover = await asked(lambda: client.text_document_hover_async(lsp.HoverParams(document, at)))
    listed = await asked(
        lambda: client.text_document_completion_async(lsp.CompletionParams(document, at))
    )
    return [
        (f"{name}: mistakes after a key", median(took), promised, "s"),
        (f"{name}: what a name means", 1000 * hover, 50, "ms"),
        (f"{name}: completion", 1000 * listed, 50, "ms"),
    ]


async def asked(question: Callable[[], Awaitable[Any]]) -> float:
    """Seconds to a warm answer."""
    took = []
    for _ in range(TIMES + 1):
        begin = time.perf_counter()
        assert await question() is not None
        took.append(time.perf_counter() - begin)
    return median(took[1:])


async def redrawn(editor: Editor, path: Path, mark: str) -> Row:
    """From a key to the data of the new picture, as the page beside the text asks for them."""
    uri, text = path.as_uri(), path.read_text("utf-8")
    page = await editor.client.protocol.send_request_async("planarc/livePage", {"uri": uri})
    where, took = position(text, mark, len(mark)), []

    def run() -> None:
        """Ask until there is a picture: an order that a later edit overtook has none."""
        kind = {"Content-Type": "application/json"}
        found: dict[str, Any] = {}
        while "scene" not in found:
            with urlopen(Request(f"{page.url}run", data=b'{"page": "p"}', headers=kind)) as answer:
                found = json.load(answer)
            assert not found.get("problems"), found["problems"]

    def follow(events: Any) -> None:
        while events.readline() != b"event: edited\n":
            pass
        run()

    await asyncio.to_thread(run)
    for version in range(100, 100 + TIMES):
        with urlopen(f"{page.url}events?page=p") as events:
            await asyncio.to_thread(events.readline)
            begin = time.perf_counter()
            editor.key(uri, where, version, "1")
            await asyncio.to_thread(follow, events)
            took.append(time.perf_counter() - begin)
        await asyncio.sleep(REST)
    return "four-bar: the mechanism beside the text after a key", median(took), 0.5, "s"


def processor(process: int) -> float:
    """Seconds, where the system tells."""
    stat = Path(f"/proc/{process}/stat")
    fields = stat.read_text("utf-8").rpartition(")")[2].split() if stat.exists() else []
    ticks = sum(map(int, fields[11:13]))
    return ticks / os.sysconf("SC_CLK_TCK") if ticks else 0.0


def memory(process: int) -> float:
    """Megabytes, where the system tells."""
    status = Path(f"/proc/{process}/status")
    lines = status.read_text("utf-8").splitlines() if status.exists() else []
    return next((int(s.split()[1]) / 1024 for s in lines if s.startswith("VmRSS")), 0.0)


async def measure(library: Path | None) -> list[Row]:
    libraries = [str(library)] if library else []
    starts = []
    for _ in range(3):
        editor = Editor()
        starts.append(await editor.start(libraries))
        await editor.stop()
    editor = Editor()
    starts.append(await editor.start(libraries))
    rows: list[Row] = [("start of the server, processor", median(starts), 0.7, "s")]
    four_bar = ROOT / "examples" / "four_bar.pmo"
    rows += await typed(editor, four_bar, "connect(groundA", ("crank(r=", 2), "four-bar", 0.3)
    rows.append(await redrawn(editor, four_bar, "crank(r={0.4"))
    if library is not None:
        file = next(library.glob("Modelica*/Blocks/Continuous.mo"))
        rows += await typed(
            editor, file, "parameter Real k", ("der(y)", 5), "file of the library", 1.0
        )
    rows.append(("memory, all of that open", memory(editor.process), 400, "MB"))
    await editor.stop()
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description="Measure the language server.")
    parser.add_argument("--library", type=Path, metavar="DIR")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    rows = asyncio.run(measure(given.library))
    shown = [(n, f"{v:.2g} {u}" if v < 10 else f"{v:.0f} {u}", f"{p:g} {u}") for n, v, p, u in rows]
    for name, value, promised in shown:
        print(f"{name:52} {value:>8}   promised {promised}")
    if given.write:
        command = "python tests/benchmarks/editor_bench.py --library DIR"
        table = {"head": ["what", "measured"], "rows": [[name, value] for name, value, _ in shown]}
        known = json.loads(DATA.read_text("utf-8"))
        known["editor"] = {**table, "machine": machine(), "command": command}
        text = json.dumps(known, indent=1, ensure_ascii=False) + "\n"
        DATA.write_text(text, encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
