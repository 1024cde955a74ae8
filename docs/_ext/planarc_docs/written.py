"""Made pages as files, and the marks that keep texts of a library from being Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

_MARKS = re.compile(r"([\\`*_{}\[\]<>#$~^])")


def write_folder(folder: Path, pages: Mapping[str, str]) -> None:
    """Write pages by name, only those that changed, and remove all others of the folder."""
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.md"):
        if old.stem not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text("utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")


def plain(text: str) -> str:
    """A text in which no mark means anything."""
    return _MARKS.sub(r"\\\1", " ".join(text.split()))


def prose(text: str) -> str:
    """A text in which backticks alone mean something."""
    parts = re.split(r"(`[^`]*`)", " ".join(text.split()))
    return "".join(p if p.startswith("`") else _MARKS.sub(r"\\\1", p) for p in parts)


def code(text: str) -> str:
    """A text as code within a line."""
    shown = " ".join(text.split())
    ticks = "``" if "`" in shown else "`"
    return f"{ticks}{shown}{ticks}" if shown else ""


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table without the columns that are empty in every row."""
    lines = [tuple(cell.replace("|", "\\|") for cell in row) for row in rows]
    kept = [i for i in range(len(head)) if any(row[i] for row in lines)]
    shown = [tuple(head[i] for i in kept), tuple("---" for _ in kept)]
    shown += [tuple(row[i] for i in kept) for row in lines]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in shown) + "\n"


def fence(language: str, text: str, argument: str = "") -> str:
    return f"```{' '.join(filter(None, (language, argument)))}\n{text.rstrip()}\n```\n"
