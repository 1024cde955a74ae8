"""The pages about Python: each public name is there, is described, and stands in code that runs."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.catalog.explanations import Code
from planarc_docs.blocks import blocks_of
from tests.docs.test_pages import PAGES

REFERENCE = Path(__file__).parents[2] / "docs" / "python"
_DIRECTIVE = re.compile(
    r"^ *\.\. auto\w+:: ([\w.]+)(?:\(\))?\n(?:   :members:(.*)\n)?", re.MULTILINE
)
#: The code of all pages, which test_pages runs.
CODE = "\n".join(
    b.text for path in PAGES for b in blocks_of(path.read_text("utf-8")) if b.language == "python"
)
NEEDS_MORE = {"to_control"}  # than the packages of planarc: tests/api run it where they are there


def find(name: str) -> Any:
    """The object that a directive names."""
    path = name.removeprefix("planarc.").split(".")
    for count in range(len(path) - 1, -1, -1):
        try:
            found: Any = importlib.import_module(".".join(["planarc", *path[:count]]))
        except ModuleNotFoundError:
            continue
        for part in path[count:]:
            found = getattr(found, part)
        return found
    raise AssertionError(name)


def described() -> Iterator[tuple[str, Any]]:
    """What the pages describe, members included."""
    for page in sorted(REFERENCE.glob("*.md")):
        for name, members in _DIRECTIVE.findall(page.read_text("utf-8")):
            yield name, find(name)
            for member in filter(None, (m.strip() for m in members.split(","))):
                yield f"{name}.{member}", getattr(find(name), member)


DESCRIBED = dict(described())
IDS = sorted(DESCRIBED)


def test_every_public_name_is_described() -> None:
    assert {getattr(planarc, name) for name in planarc.__all__} <= set(DESCRIBED.values())


@pytest.mark.parametrize("name", IDS)
def test_the_words_are_whole_and_their_codes_are_there(name: str) -> None:
    own = inspect.getdoc(DESCRIBED[name])
    assert own and re.match(r"[A-Z`]|dx/dt", own)
    assert own.rstrip().endswith(".")
    assert set(re.findall(r"\b[A-Z]\d{3}\b", own)) <= Code.__members__.keys()


@pytest.mark.parametrize("name", [n for n in IDS if not inspect.isclass(DESCRIBED[n])])
def test_an_example_uses_it(name: str) -> None:
    last = name.rpartition(".")[2]
    pattern = {"__getitem__": r"\w\[", "__call__": r"\bsolve_ivp\(f,"}.get(last, rf"\b{last}\b")
    assert last in NEEDS_MORE or re.search(pattern, CODE), name


def test_the_example_of_a_model_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Code in a docstring stands below an empty line, indented."""
    example = Path(__file__).parents[2] / "examples" / "four_bar.pmo"
    (tmp_path / "four_bar.pmo").write_text(example.read_text("utf-8"), "utf-8")
    monkeypatch.chdir(tmp_path)
    text = "\n".join(re.findall(r"^    (.*)$", inspect.getdoc(planarc.Model) or "", re.MULTILINE))
    names: dict[str, Any] = {"planarc": planarc}
    exec(compile(text, "Model", "exec"), names)
    assert names["result"]["revA.phi"][0] == pytest.approx(0.7853981633974483)
