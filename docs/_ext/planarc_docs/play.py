"""Runs the blocks of a page, and compares what they print with what the page says.

In:   str       a page in Markdown
Out:  Played    each block that prints, with what it printed now

A line `...` in a page stands for any lines, and `...` within a line for any text, so that a page
need not tell how long a command took. `refreshed` writes what is printed now into the page.

All blocks of a page share a folder, which holds the `examples` of the repository, and one script.
"""

from __future__ import annotations

import io
import os
import re
import shlex
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

from planarc.cli.app import run
from planarc_docs.blocks import Block, blocks_of, write_file

ROOT = Path(__file__).parents[3]
_WIDTH = "96"


class Played(NamedTuple):
    """A block that prints: what the page says (`block.text`), and what it `printed`."""

    block: Block
    printed: str

    @property
    def holds(self) -> bool:
        return is_like(self.block.text, self.printed)


def play(page: str, folder: Path) -> Iterator[Played]:
    """Run all blocks of a page in a folder. Raises what a script of the page raises."""
    shutil.copytree(ROOT / "examples", folder / "examples", dirs_exist_ok=True)
    names: dict[str, Any] = {"__name__": "__main__"}
    blocks = list(blocks_of(page))
    with _inside(folder):
        for block, following in zip(blocks, [*blocks[1:], None], strict=False):
            match block.language:
                case "modelica" | "text" if block.argument:
                    write_file(block, folder)
                case "console":
                    yield Played(block, "".join(map(_answer, _commands(block.text))))
                case "python":
                    yield _script(page, block, following, names)


def is_like(said: str, printed: str) -> bool:
    """True if what is printed is what a page says, where `...` stands for anything."""
    pattern = re.escape(said).replace(re.escape("...\n"), "(?:.*\n)*?(?:.*\n)")
    return re.fullmatch(pattern.replace(re.escape("..."), ".*"), printed) is not None


def refreshed(page: str, played: Sequence[Played]) -> str:
    """The page with what is printed now; what still holds stays as it is written."""
    for found in reversed(played):
        if not found.holds:
            begin, end = found.block.begin, found.block.end
            page = page[:begin] + _with_dots(found) + page[end:]
    return page


def _with_dots(found: Played) -> str:
    """What is printed, with the lines of the page that say the same with `...`."""
    dotted = [line for line in found.block.text.splitlines() if "..." in line and line != "..."]
    lines = found.printed.split("\n")
    return "\n".join(next((d for d in dotted if is_like(d, line)), line) for line in lines)


def _script(page: str, block: Block, following: Block | None, names: dict[str, Any]) -> Played:
    """What a piece of the script prints, beside the `text` block that stands next to it."""
    caught = io.StringIO()
    code = compile("\n" * block.line + block.text, "the page", "exec")
    with redirect_stdout(caught):
        exec(code, names)
    told = following is not None and following.language == "text"
    if following is not None and told and not page[block.end + 3 : following.begin - 8].strip():
        return Played(following, caught.getvalue())
    return Played(Block("text", "", "", block.end + 3, block.end + 3, block.line), _new(caught))


def _new(caught: io.StringIO) -> str:
    """A new block, for what a page does not tell yet."""
    text = caught.getvalue()
    return f"\n\n```text\n{text}```" if text else ""


def _commands(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.startswith("$ ")]


def _answer(line: str) -> str:
    """A command behind `$ `, and all that it says."""
    program, *arguments = shlex.split(line[2:])
    said = io.StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        if program == "planarc":
            run(arguments)
        elif program == "cat":
            said.writelines(Path(name).read_text("utf-8") for name in arguments)
        else:
            raise ValueError(f"a page runs planarc and cat, not `{program}`")
    text = re.sub(r" +$", "", said.getvalue(), flags=re.MULTILINE)
    return f"{line}\n{text}"


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """The folder as the working directory, pictures without windows, lines of one width."""
    known, here = dict(os.environ), Path.cwd()
    os.environ.update(COLUMNS=_WIDTH, MPLBACKEND="Agg", NO_COLOR="1")
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        os.chdir(here)
        os.environ.clear()
        os.environ.update(known)
