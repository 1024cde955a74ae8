"""Golden cases: each file shows input and output together.

A case is a text of sections, each begun by a line `=== KIND: NAME`:

    === file: NAME       a file in the working directory, with this text
    === example: NAME    the same, a copy of `examples/NAME`
    === bytes: NAME      a file of these bytes, in hexadecimal
    === folder: NAME     a folder
    === run: COMMAND     what is run there: `planarc ...`, or `syntax FILE`
    === exit: CODE
    === output           what it printed on standard output
    === errors           what it printed on standard error
    === columns: NAMES   some columns of the result FILE.csv that was written, at a few
                         rows; compared within a thousandth

The summary of `planarc simulate` is left out: it tells how long the run took.

`pytest --update-golden` rewrites what stands after `run`, and the copies of examples.
"""

from __future__ import annotations

import csv
import os
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from planarc.cli.app import run

TESTS = Path(__file__).parent.parent
EXAMPLES = TESTS.parent / "examples"
CASES = sorted([*TESTS.glob("golden/**/*.case"), *TESTS.glob("errors/*.case")])
ROWS = 6  # of a table of results


@dataclass(frozen=True)
class Section:
    kind: str
    name: str
    body: str

    def __str__(self) -> str:
        head = f"=== {self.kind}: {self.name}" if self.name else f"=== {self.kind}"
        return f"{head}\n{self.body}"


def read_sections(text: str) -> Iterator[Section]:
    for part in ("\n" + text).split("\n=== ")[1:]:
        head, _, body = part.partition("\n")
        kind, _, name = head.partition(": ")
        if body and not body.endswith("\n"):
            body += "\n"
        yield Section(kind, name, body)


def prepare(section: Section, folder: Path) -> Section:
    """Make what a section of input describes."""
    target = folder / section.name
    match section.kind:
        case "file":
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(section.body, encoding="utf-8", newline="\n")
        case "example":
            text = (EXAMPLES / section.name).read_text(encoding="utf-8")
            target.write_text(text, encoding="utf-8", newline="\n")
            return Section("example", section.name, text)
        case "bytes":
            target.write_bytes(bytes.fromhex(section.body))
        case "folder":
            target.mkdir()
        case _:
            raise AssertionError(f"a case has no section `{section.kind}` before `run`")
    return section


def execute(command: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command."""
    program, *arguments = shlex.split(command)
    capsys.readouterr()
    if program == "syntax":
        print(syntax(Path(arguments[0])), end="")
        code = 0
    else:
        assert program == "planarc"
        code = run(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def syntax(path: Path) -> str:
    from planarc.parse.parser import parse_file
    from tests.ir.text.syntax import definition_text

    return definition_text(parse_file(path, path.name))


def table(names: str) -> str:
    """The named columns of the only result file, at ROWS rows from first to last."""
    (file,) = Path().glob("*.csv")
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    picked = [rows[round(i * (len(rows) - 1) / (ROWS - 1))] for i in range(ROWS)]
    wanted = names.split()
    return "".join(" ".join(f"{float(row[name]):.6g}" for name in wanted) + "\n" for row in picked)


def tables_agree(new: str, old: str) -> bool:
    """Whether no number differs by more than a thousandth of its column's largest."""
    rows = [[[float(x) for x in line.split()] for line in t.splitlines()] for t in (new, old)]
    if [len(row) for row in rows[0]] != [len(row) for row in rows[1]]:
        return False
    columns = zip(zip(*rows[0], strict=True), zip(*rows[1], strict=True), strict=True)
    return all(
        abs(a - b) <= 1e-3 * max(1e-3, *map(abs, stored))
        for found, stored in columns
        for a, b in zip(found, stored, strict=True)
    )


@pytest.mark.parametrize("path", CASES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_case(
    path: Path,
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    update = request.config.getoption("--update-golden")
    sections = list(read_sections(path.read_text(encoding="utf-8")))
    kinds = [s.kind for s in sections]
    at = kinds.index("run")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.delenv("MODELICAPATH", raising=False)
    given = [prepare(s, tmp_path) for s in sections[:at]]
    command = sections[at]
    if command.name.startswith("planarc import outline") and ".svg" in command.name:
        pytest.importorskip("svgelements")
    code, out, err = execute(command.name, capsys)
    assert "Traceback" not in err
    assert os.fspath(tmp_path) not in out + err
    found = [*given, Section("run", command.name, ""), Section("exit", str(code), "")]
    found += [Section(kind, "", text) for kind, text in (("output", out), ("errors", err)) if text]
    tables = [s for s in sections if s.kind == "columns"]
    found_tables = [Section("columns", s.name, table(s.name)) for s in tables]
    if command.name.startswith("planarc simulate"):  # its summary holds times
        found = [s for s in found if s.kind != "output"]
    if update:
        found_tables = [
            old if tables_agree(new.body, old.body) else new
            for new, old in zip(found_tables, tables, strict=True)
        ]
        path.write_text("".join(map(str, [*found, *found_tables])), "utf-8", newline="\n")
        return
    stored = [s for s in sections if s.kind != "columns"]
    assert "".join(map(str, found)) == "".join(map(str, stored))
    for new, old in zip(found_tables, tables, strict=True):
        assert tables_agree(new.body, old.body), f"{new}\ninstead of\n{old}"
