"""The printed flat model is Modelica: read again, it flattens to itself."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir.text.flat import print_model
from planarc.parse.parser import parse_annotation, parse_file, parse_text

#: `R('r.a', 'r.b') := f(R('r.a', 'r.b'))`: what Modelica has no words for without a record.
_RECORD_TARGET = re.compile(r"^ +\(?(?:[\w']+\(|\{)[^:]*:= ", re.MULTILINE)

TESTS = Path(__file__).parents[2]


def flat_texts() -> list[pytest.param]:  # type: ignore[valid-type]
    spec = importlib.util.spec_from_file_location("cases", TESTS / "language" / "conftest.py")
    assert spec is not None and spec.loader is not None
    cases = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(cases)
    found = []
    for path in sorted((TESTS / "language").rglob("*.case")):
        for name, _, outcome in cases.read_cases(path):
            start = outcome.find("[flat]\n")
            if start >= 0 and "warning[" not in outcome and not _RECORD_TARGET.search(outcome):
                found.append(pytest.param(outcome[len("[flat]\n") :], id=name))
    for path in sorted((TESTS / "golden" / "flat").glob("*.txt")):
        text = path.read_text(encoding="utf-8").partition("// Flat model:\n\n")[2]
        found.append(pytest.param(text, id=path.stem))
    return found


@pytest.mark.parametrize("text", flat_texts())
def test_a_flat_model_flattens_to_itself(text: str) -> None:
    library = Library([stdlib()], parse_file, parse_annotation)
    names = library.add_file(parse_text(Source("flat.mo", text)))
    again = print_model(flatten(library, names[-1]))
    if "\\'" in text:  # functions of operators were made when they were tried, before their calls
        assert sorted(again.strip().split("\n\n")) == sorted(text.strip().split("\n\n"))
    else:
        assert again.rstrip() == text.rstrip()
