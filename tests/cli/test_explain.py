"""`planarc explain`: one code, a stage, all codes, a code that is none."""

from __future__ import annotations

import json

import pytest

from planarc.catalog.explanations import STAGES, Code
from planarc.cli.app import run
from planarc.cli.explain import _completed


def said(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> str:
    assert run(["explain", *arguments]) == code
    found = capsys.readouterr()
    return found.out if code == 0 else found.err


def test_a_code_is_told_with_cause_example_and_cure(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "f320")
    assert text.startswith("F320: more or fewer equations than unknowns\n\n  A model needs")
    assert "\nExample\n    model Loose\n      Real x;\n" in text
    assert "\nCure\n  With too few," in text
    assert max(map(len, text.splitlines())) <= 88


def test_commands_of_an_example_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert "\nRun\n    planarc simulate train.pmo --set n=3\n" in said(capsys, "C116")


def test_several_codes_follow_each_other(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "R401", "R402")
    assert text.index("R401: ") < text.index("\n\nR402: ")


def test_all_codes_are_listed_by_stage(capsys: pytest.CaptureFixture[str]) -> None:
    lines = said(capsys).splitlines()
    assert [f"  {c.name}  {c.value}" for c in Code] == [x for x in lines if x[:2] == "  "]
    assert [x for x in lines if x and x[0] != " "] == [f"{s}: {w}" for s, w in STAGES.items()]


def test_the_codes_of_one_stage(capsys: pytest.CaptureFixture[str]) -> None:
    lines = said(capsys, "g").splitlines()
    assert lines == ["G: writing the code", f"  G401  {Code.G401.value}"]


def test_a_code_that_is_none(capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, "F3200", code=2)
    assert text.startswith("error[C294]: there is no code `F3200`\n  hint: did you mean ")
    assert "`F320`" in text
    assert "`planarc explain` lists all codes" in said(capsys, "?", code=2)


def test_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    (found,) = json.loads(said(capsys, "S303", "--json"))["codes"]
    assert (found["code"], found["title"]) == ("S303", Code.S303.value)
    assert found["example"][0]["kind"] == "modelica"
    assert found["cause"] and found["cure"]
    listed = json.loads(said(capsys, "--json"))["codes"]
    assert listed[0] == {"code": "C100", "title": Code.C100.value}
    assert len(listed) == len(Code)


def test_codes_are_completed() -> None:
    assert _completed("g4") == ["G401"]
