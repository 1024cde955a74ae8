"""All mistakes of a file at once: each once, in the order of the source."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planarc.cli.app import run

SYNTAX = """\
model M
  Real x
  Real y;
equation
  x = 1
  y = (2;
  x = )4;
  wen x then end when;
end N;
"""
MEANING = """\
model M
  Real y = z;
  Real q(strat=1) = 3;
  Foo f;
  parameter Real p = 1 + true;
  parameter Integer n = 2.5;
  Real good = 1;
equation
  connect(a, good);
  y = "text";
  undefined(3) = 1;
end M;
"""


@pytest.mark.parametrize(
    ("text", "lines"),
    [(SYNTAX, [2, 5, 6, 7, 8, 9]), (MEANING, [2, 3, 4, 5, 6, 9, 10, 11])],
    ids=["syntax", "meaning"],
)
def test_every_mistake_is_said_once_and_in_order(
    text: str, lines: list[int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "m.pmo"
    path.write_text(text, "utf-8")
    assert run(["check", str(path), "--json"]) == 1
    diagnostics = json.loads(capsys.readouterr().out)["diagnostics"]
    found = [d["line"] for d in diagnostics]
    assert sorted(set(found)) == lines
    assert found == sorted(found)
    assert len(found) <= len(lines) + 1  # at most one line of knock-on noise


def test_a_mistake_of_a_class_that_is_used_twice_is_said_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "model M\n  model A\n    Real x = y;\n  end A;\n  A a, b;\n  A c[3];\nend M;\n"
    path = tmp_path / "m.pmo"
    path.write_text(text, "utf-8")
    assert run(["check", str(path)]) == 1
    assert capsys.readouterr().err.count("error[") == 1
