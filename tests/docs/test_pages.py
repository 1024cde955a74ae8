"""Every code block of every page runs, and prints what the page says.

`pytest --update-golden` writes what is printed now into the pages.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from planarc_docs.blocks import blocks_of
from planarc_docs.play import is_like, play, refreshed

DOCS = Path(__file__).parents[2] / "docs"
MADE = ("library", "commands", "codes", "_build", "made", "_ext")
PAGES = sorted(p for p in DOCS.rglob("*.md") if p.relative_to(DOCS).parts[0] not in MADE)
LANGUAGES = {"modelica", "console", "python", "text", "bash"}


@pytest.mark.parametrize("path", PAGES, ids=lambda p: str(p.relative_to(DOCS).with_suffix("")))
def test_blocks_print_what_the_page_says(
    path: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    page = path.read_text("utf-8")
    played = list(play(page, tmp_path))
    if request.config.getoption("--update-golden"):
        path.write_text(refreshed(page, played), encoding="utf-8", newline="\n")
        page = path.read_text("utf-8")
        played = []
    for found in played:
        where = f"{path.name}:{found.block.line}"
        assert found.holds, (
            f"{where} prints\n{found.printed}\nand the page says\n{found.block.text}"
        )


@pytest.mark.parametrize("path", PAGES, ids=lambda p: str(p.relative_to(DOCS).with_suffix("")))
def test_blocks_are_run_in_a_way_that_is_known(path: Path) -> None:
    page = path.read_text("utf-8")
    assert page.count("\n```") % 2 == 0
    blocks = list(blocks_of(page))
    assert {b.language for b in blocks} <= LANGUAGES
    for block in blocks:
        if block.language == "modelica":
            assert block.argument, f"{path.name}:{block.line}: a model needs the name of a file"
            own = block.argument.partition("/")[0].partition(".")[0]
            assert page.count(own) > 1, f"{block.argument} is never used"


def test_shell_commands_are_those_of_the_readme() -> None:
    """What is not run here is run by CI: the commands of the README."""
    readme = (DOCS.parent / "README.md").read_text("utf-8")
    for path in PAGES:
        for block in blocks_of(path.read_text("utf-8")):
            if block.language == "bash":
                assert block.text in readme, f"{path.name}:{block.line}"


@pytest.mark.parametrize("path", PAGES, ids=lambda p: str(p.relative_to(DOCS).with_suffix("")))
def test_a_page_is_written_for_everybody(path: Path) -> None:
    """Every page has something to run, and sentences that can be read aloud."""
    page = path.read_text("utf-8")
    prose = re.sub(r"^(```|:::).*?^\1$", "", page, flags=re.MULTILINE | re.DOTALL)
    assert page.startswith("# ")
    prose = re.sub(r"^[|#].*$", ".", prose, flags=re.MULTILINE)
    for sentence in re.split(r"(?<=[.?!:])\s", " ".join(prose.split())):
        assert len(re.sub(r"\]\([^)]*\)", "", sentence).split()) < 60, sentence


def test_dots_stand_for_anything() -> None:
    assert is_like("took ... ms\n", "took 12.5 ms\n")
    assert is_like("a\n...\nb\n", "a\nx\ny\nb\n")
    assert not is_like("took ... ms\n", "took 12.5 s\n")
    assert not is_like("a\n", "a\nb\n")
