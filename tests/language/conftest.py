"""Collects `*.case` files: the language, section by section, input and outcome together.

A file holds cases, each a text and what becomes of it:

    [case what the rule says]
    model M  Real x = 1; end M;
    [flat]
    model M
      Real x = 1;
    end M;

The last class of the text is flattened. The outcome is `[flat]` with the flat model
(warnings above it), or `[errors]` with the messages. `pytest --update-golden` writes
the outcomes anew; read them as a user would.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.core.render import render_all
from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir.text.flat import print_model
from planarc.parse.parser import parse_annotation, parse_file, parse_text
from tests.ir.check.flat import check_model

_CASE = re.compile(r"^\[case (.*)\]$", re.MULTILINE)
_OUTCOME = re.compile(r"^\[(flat|errors)\]\n", re.MULTILINE)


def outcome_of(text: str) -> str:
    """The section that belongs to an input: its flat model or its messages."""
    library = Library([stdlib()], parse_file, parse_annotation)
    try:
        names = library.add_file(parse_text(Source("case.mo", text)))
        model = flatten(library, names[-1])
    except PlanarcError as problem:
        return "[errors]\n" + render_all(problem.diagnostics)
    check_model(model)
    warnings = render_all(model.warnings)
    return "[flat]\n" + (f"{warnings}\n" if warnings else "") + print_model(model)


class CaseFile(pytest.File):
    def collect(self) -> Iterator[pytest.Item]:
        for name, _, _ in read_cases(self.path):
            yield CaseItem.from_parent(self, name=name)


class CaseItem(pytest.Item):
    #: Fixtures: none, but plugins of pytest look here.
    funcargs: ClassVar[Mapping[str, object]] = {}

    def runtest(self) -> None:
        text, expected = next((t, e) for n, t, e in read_cases(self.path) if n == self.name)
        found = outcome_of(text)
        if self.config.getoption("--update-golden"):
            replace_outcome(self.path, self.name, found)
            return
        assert found.rstrip() == expected.rstrip()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException]) -> str:
        return str(excinfo.getrepr(style="short"))

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, self.name


def read_cases(path: Path) -> list[tuple[str, str, str]]:
    """Name, input and outcome of each case of a file."""
    pieces = _CASE.split(path.read_text(encoding="utf-8"))
    cases = []
    for name, body in zip(pieces[1::2], pieces[2::2], strict=True):
        match = _OUTCOME.search(body)
        text = body[: match.start()] if match else body
        outcome = body[match.start() :] if match else ""
        cases.append((name, text.strip("\n") + "\n", outcome))
    return cases


def replace_outcome(path: Path, name: str, outcome: str) -> None:
    head = _CASE.split(path.read_text(encoding="utf-8"))[0]
    blocks = [
        f"[case {n}]\n{t}{outcome if n == name else e}".rstrip() for n, t, e in read_cases(path)
    ]
    path.write_text(head + "\n\n".join(blocks) + "\n", encoding="utf-8", newline="\n")


def pytest_collect_file(parent: pytest.Collector, file_path: Path) -> CaseFile | None:
    if file_path.suffix == ".case":
        return CaseFile.from_parent(parent, path=file_path)
    return None
