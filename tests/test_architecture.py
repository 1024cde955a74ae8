"""ARCHITECTURE.md: the data that it shows are made by the code, its map is that of the folders.

`pytest --update-golden` rewrites the data.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from planarc import compiler, stages
from planarc.codegen.native.printer import ir
from planarc.core.options import Backend, RunOptions
from planarc.ir.expr import text
from planarc.ir.text.flat import print_model
from planarc.ir.text.sorted import sorted_text
from planarc.request.request import Request, open_target

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "ARCHITECTURE.md"
EXAMPLE = ROOT / "examples" / "four_bar.pmo"
LAW = "stdlib/PlanarMultiBody/Parts/FixedTranslation.pmo"
#: The variable whose equation is followed.
NAME = "crank.r_0"
_BLOCK = re.compile(r"(<!-- made: (\w+) -->\n```\w*\n)(.*?)(\n```)", re.DOTALL)


@pytest.fixture(scope="module")
def made() -> dict[str, str]:
    """Each shown piece, as the stages make it today."""
    return dict(_pieces())


def _pieces() -> Iterator[tuple[str, str]]:
    law = (ROOT / LAW).read_text("utf-8")
    yield "law", next(line.strip() for line in law.splitlines() if line.startswith("  r_0 ="))
    flat = stages.flatten(open_target(Request(EXAMPLE)))
    yield "flat", _lines(print_model(flat), rf"'{NAME}' = ")
    dae = stages.to_dae(flat)
    scalar = [e for e in dae.equations if text(e.left) == f"{NAME}[1]"]
    yield "lower", "\n".join(f"{text(e.left)} = {text(e.right)}" for e in scalar)
    model = stages.to_sorted(dae)
    yield "structure", _lines(sorted_text(model), rf"{re.escape(NAME)}\[1\]\)* := ")
    program = stages.to_program(model)
    slot = program.slots[f"{NAME}[1]"]
    yield "program", f"w[{slot}]  {NAME}[1]"
    source = stages.to_code(program, Backend.NUMPY)
    assert isinstance(source, str)
    yield "numpy", _with_parts(source, "crank_r_0_1")
    yield "llvm", _stores(ir(program), slot)
    compiled = compiler.compile_model(Request(EXAMPLE))
    result = compiler.run(compiled, RunOptions(stop=0.0, backend=compiled.backend))
    yield "result", f"{NAME}[1] = {result[f'{NAME}[1]'][0]:.6f} m at t = {result.time[0]:g} s"


def _lines(whole: str, pattern: str) -> str:
    found = [line.strip() for line in whole.splitlines() if re.search(pattern, line)]
    return "\n".join(re.sub(r"  // .*", "", line) for line in found)


def _with_parts(source: str, name: str) -> str:
    """The statement that computes a variable, after those of its temporaries."""
    lines = [line.strip() for line in source.splitlines()]
    place = next(i for i, line in enumerate(lines) if re.match(rf"{name} = (?!w\[)", line))
    parts = re.findall(r"\bt\d+\b", lines[place])
    known = [line for line in lines[:place] if line.partition(" = ")[0] in parts]
    return "\n".join((*known[-len(parts) :], lines[place]))


def _stores(whole: str, slot: int) -> str:
    """The instructions to the first store into a slot of the workspace, from the store before."""
    lines = whole.splitlines()
    place = next(i for i, line in enumerate(lines) if line.endswith(f"ptr %2, i64 {slot}"))
    begin = 1 + max(i for i, line in enumerate(lines[:place]) if line.strip().startswith("store"))
    return "\n".join(line.strip() for line in lines[begin : place + 2])


def test_the_data_shown_are_made_by_the_code(
    made: dict[str, str], request: pytest.FixtureRequest
) -> None:
    page = PAGE.read_text("utf-8")
    assert {m[2] for m in _BLOCK.finditer(page)} == made.keys()
    new = _BLOCK.sub(lambda m: f"{m[1]}{made[m[2]]}{m[4]}", page)
    if request.config.getoption("--update-golden"):
        PAGE.write_text(new, encoding="utf-8", newline="\n")
    assert new == PAGE.read_text("utf-8")


def test_the_map_names_every_room_and_no_other() -> None:
    page = PAGE.read_text("utf-8")
    named = re.findall(r"^\| `(\w+)(?:/|\.py)` \|", page, re.MULTILINE)
    package = ROOT / "planarc"
    there = {p.name for p in package.iterdir() if p.is_dir() and any(p.glob("*.py"))}
    there |= {p.stem for p in package.glob("[a-z]*.py")}
    assert sorted(named) == sorted(there)


def test_files_that_the_page_names_are_there() -> None:
    page = PAGE.read_text("utf-8")
    named = set(re.findall(r"`([\w./]+/[\w.]+\.(?:py|md|pmo|lark|toml))[`:]", page))
    missing = [n for n in named if not ((ROOT / n).exists() or (ROOT / "planarc" / n).exists())]
    assert len(named) > 10
    assert missing == []


def test_page_and_map_are_short_and_the_rooms_few() -> None:
    assert len(PAGE.read_text("utf-8").splitlines()) <= 150
    package = ROOT / "planarc"
    assert len((package / "compiler.py").read_text("utf-8").splitlines()) <= 130
    rooms = [p for p in package.iterdir() if p.suffix == ".py" or (p / "__init__.py").exists()]
    assert len([p for p in rooms if not p.stem.startswith("__")]) <= 26


def test_a_long_file_says_why() -> None:
    for file in (ROOT / "planarc").rglob("*.py"):
        text = file.read_text("utf-8")
        if len(text.splitlines()) > 400:
            head = " ".join((ast.get_docstring(ast.parse(text)) or "").split())
            assert re.search(r"The file is long because|hence one file", head), file
