"""Every code is explained, and every example of an explanation raises its code.

A code is raised by a test when its example is run here, when a case of the command line shows
its message, or when a test asserts that it was raised. So no code is only written somewhere.
"""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

import pytest

from planarc.catalog.explanations import FOLDER, STAGES, Code, Explanation, explain
from planarc.cli.app import run
from planarc.core.diagnostic import PlanarcError

TESTS = Path(__file__).parents[1]
EXAMPLES = TESTS.parent / "examples"
HEADS = {f.stem: re.findall(r"^## (\w*)", f.read_text("utf-8"), re.M) for f in FOLDER.glob("*.md")}
EXPLAINED = [explain(code) for code in Code if code.name in HEADS[code.name[0]]]
#: Codes that come with another one: too many equations here are too few elsewhere.
COMPANIONS = {"S302": {"S303"}, "R429": {"R456"}}
SHOWN = [e for e in EXPLAINED if e.example]


def codes_in(node: ast.AST) -> set[str]:
    """The codes in the texts of a piece of a program."""
    texts = (n.value for n in ast.walk(node) if isinstance(n, ast.Constant))
    return {c for t in texts if isinstance(t, str) for c in re.findall(r"\b[A-Z]\d{3}\b", t)}


def names_in(node: ast.AST) -> set[str]:
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def assigned_in(block: Sequence[ast.stmt]) -> dict[str, set[str]]:
    """The codes in what the names of a block stand for."""
    found: dict[str, set[str]] = {}
    for node in block:
        if isinstance(node, (ast.Assign, ast.AnnAssign)) and node.value is not None:
            for name in names_in(node) - names_in(node.value):
                found.setdefault(name, set()).update(codes_in(node.value))
    return found


def asserted_in(file: Path) -> Iterator[str]:
    """The codes that tests of a file look for: in an `assert`, in `pytest.raises`, in what a
    function of the file that asserts is called with, in the parameters of the test."""
    module = ast.parse(file.read_bytes())
    functions = [n for n in ast.walk(module) if isinstance(n, ast.FunctionDef)]
    judges = {"raises", "warns"}
    judges |= {f.name for f in functions if any(isinstance(n, ast.Assert) for n in ast.walk(f))}
    for test in functions:
        if not test.name.startswith("test_"):
            continue
        known = assigned_in(module.body) | assigned_in(test.body)
        looks: list[ast.AST] = list(test.decorator_list)
        for node in ast.walk(test):
            called = node.func if isinstance(node, ast.Call) else None
            name = getattr(called, "attr", getattr(called, "id", ""))
            if isinstance(node, ast.Assert) or name in judges:
                looks.append(node)
        for look in looks:
            yield from codes_in(look).union(*(known.get(n, set()) for n in names_in(look)))


@cache
def raised_by_tests() -> frozenset[str]:
    """The codes that tests assert, and that cases show."""
    shown = (re.findall(r"\w\[(\w\d{3})\]: ", f.read_text("utf-8")) for f in TESTS.rglob("*.case"))
    asserted = (asserted_in(f) for f in TESTS.rglob("test_*.py") if f != Path(__file__))
    return frozenset(code for codes in (*shown, *asserted) for code in codes)


def test_every_code_has_its_section_in_the_file_of_its_stage() -> None:
    codes = {stage: [c for c in Code.__members__ if c.startswith(stage)] for stage in STAGES}
    assert codes == HEADS


@pytest.mark.parametrize("found", EXPLAINED, ids=lambda e: e.code.name)
def test_every_code_has_a_cause_and_a_cure(found: Explanation) -> None:
    assert found.cause and found.cure
    for text in (*found.cause, found.cure):
        assert text[0].isupper() or text.startswith(("`", "planarc")), text
        assert text.endswith((".", "?", ":", "`")), text
        assert "  " not in text


@pytest.mark.parametrize("found", EXPLAINED, ids=lambda e: e.code.name)
def test_every_code_is_raised_by_a_test(found: Explanation) -> None:
    assert found.example or found.code.name in raised_by_tests()


@pytest.mark.parametrize("found", SHOWN, ids=lambda e: e.code.name)
def test_an_example_raises_its_code(
    found: Explanation,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    commands = [line for kind, text in found.example if kind == "sh" for line in text.splitlines()]
    blocks = dict(found.example)
    if "modelica" in blocks:
        names = re.findall(r"\S+\.(?:pmo|mo)\b", " ".join(commands)) or ["example.pmo"]
        Path(names[0]).write_text(blocks["modelica"], encoding="utf-8")
        models = re.findall(r"^(?:model|block) (\w+)", blocks["modelica"], re.MULTILINE)
        commands = commands or [" ".join(["planarc simulate example.pmo", *models[-1:]])]
    for line in commands:
        for word in shlex.split(line):
            if (EXAMPLES / word).is_file() and not Path(word).exists():
                Path(word).write_bytes((EXAMPLES / word).read_bytes())
        assert line.startswith("planarc ")
        run(shlex.split(line)[1:])
    told = re.findall(r"\w+\[(\w\d{3})\]", capsys.readouterr().err)
    if "python" in blocks:
        with pytest.raises(PlanarcError) as caught:
            exec(blocks["python"], {})
        told += [d.code for d in caught.value.diagnostics]
    assert found.code.name in told
    assert set(told) <= {found.code.name} | COMPANIONS.get(found.code.name, set())
