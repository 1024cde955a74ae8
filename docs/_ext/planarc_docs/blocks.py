"""The code blocks of a page: plain fences, so that a page reads well wherever it is shown.

In:   str     a page in Markdown
Out:  Block   each fence with its language, what stands behind that, and its text

    modelica NAME   a file of the page, which later blocks may use; or text NAME
    console         commands behind `$ `, and what they say
    python          a part of the page's script; a `text` block next to it is what it prints
    bash            a command for a shell, which is not run here
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

#: Languages whose blocks are files, where they have a name.
FILES = ("modelica", "text")
_FENCE = re.compile(r"^```([a-z]+)(?: ([^\n`{}]+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """`begin` and `end` are the places of `text` in the page."""

    language: str
    argument: str
    text: str
    begin: int
    end: int
    line: int


def blocks_of(page: str) -> Iterator[Block]:
    """The blocks in their order."""
    for found in _FENCE.finditer(page):
        line = page.count("\n", 0, found.start()) + 1
        language, argument, text = found.groups()
        yield Block(language, (argument or "").strip(), text, *found.span(3), line)


def write_file(block: Block, folder: Path) -> Path:
    """Write one file of a page; its name may lead into folders."""
    path = folder / block.argument
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(block.text, encoding="utf-8", newline="\n")
    return path


def write_files(page: str, folder: Path) -> Mapping[str, Path]:
    """Write the files of a page into a folder."""
    named = [b for b in blocks_of(page) if b.language in FILES and b.argument]
    return {b.argument: write_file(b, folder) for b in named}


def with_captions(page: str) -> str:
    """The page with the names of files above their texts."""

    def captioned(found: re.Match[str]) -> str:
        language, name, text = found.groups()
        if language not in FILES or not name:
            return found[0]
        return f"```{{code-block}} {language}\n:caption: {name}\n\n{text}```"

    return _FENCE.sub(captioned, page)
