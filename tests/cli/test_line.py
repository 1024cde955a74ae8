"""Command lines as they are read without typer: the same arguments as typer's, or none."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from enum import Enum
from functools import wraps
from pathlib import Path
from typing import Any

import pytest
import typer

from planarc.cli import line
from planarc.cli.advice import as_typed
from planarc.cli.app import _take_volume
from planarc.cli.commands import COMMANDS, function_of

#: A value of each kind, in a line.
WRITTEN = {str: "x=1", Path: "some/file.pmo", int: "7", float: "1e-3"}
#: Lines that are wrong, or that only typer explains.
NOT_READ = (
    "simulate",
    "simulate a.pmo B c.mat",
    "simulate a.pmo --help",
    "simulate -h",
    "simulate a.pmo --stp 1",
    "simulate a.pmo --stop",
    "simulate a.pmo --stop late",
    "simulate a.pmo --intervals 1.5",
    "simulate a.pmo --json=yes",
    "simulate a.pmo --solver eule",
    "simulate a.pmo -x",
    "simulate a.pmo -1",
    "serve a.pmo --port 65536",
    "serve a.pmo --port -1",
    "export exe a.pmo",
    "import outline a.svg --tolerance 0",
)
#: Lines that are right in other ways than the examples are.
READ = (
    "simulate a.pmo --stop=3 --stop 500ms -o a.csv --output=-.csv",
    "simulate --set a=1 a.pmo --set=b=2 A --set --json",
    "simulate --no-report -- -a.pmo --json",
    "simulate - '' --tolerance nan",
    "plot a.csv --x v x y -- -z",
    "animate a.pmo --light --dark -o a.svg",
    "animate a.pmo --light -o a.svg",
    "serve a.pmo --port 65535",
)


def as_typer_reads(words: list[str]) -> dict[str, Any] | None:
    found: list[dict[str, Any]] = []
    command = function_of(words[0])

    @wraps(command)
    def noted(**given: Any) -> None:
        found.append(given)

    noted.__signature__ = as_typed(command).__signature__  # type: ignore[attr-defined]
    app = typer.Typer(add_completion=False)
    app.command()(noted)
    try:
        app(words[1:], standalone_mode=False)
    except typer.BadParameter.__mro__[1]:
        return None
    return found[0] if found else None


def examples() -> Iterator[str]:
    for lines in COMMANDS.values():
        for written in lines:
            yield from (part.partition(" > ")[0].strip() for part in written.split("&&"))


def each_option(command: Callable[..., int]) -> Iterator[list[str]]:
    """Lines with what is needed, and one word of one option; all arguments."""
    known = line.parameters(command)
    needed = [word(p) for p in known if p.default is ...]
    yield needed
    for p in known:
        if isinstance(p.said, line.Option):
            for name in p.words():
                yield [*needed, name] if p.kind is bool else [name, word(p), *needed]
        elif p.default is not ...:
            needed = [*needed, word(p)]
            yield needed


def word(p: line.Parameter) -> str:
    if p.said.parser is not None:
        return "0.25"
    return str(list(p.kind)[-1].value) if issubclass(p.kind, Enum) else WRITTEN[p.kind]


@pytest.mark.parametrize("written", (*dict.fromkeys(examples()), *READ))
def test_a_line_that_is_right_is_read_as_typer_reads_it(written: str) -> None:
    _, *words = (
        shlex.split(written) if written.startswith("planarc ") else ("", *shlex.split(written))
    )
    words, _ = _take_volume(words)
    given = line.read(function_of(words[0]), words[1:])
    assert given is not None
    assert repr(given) == repr(as_typer_reads(words))  # numbers that are none are equal as text


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_is_read_as_typer_reads_it(name: str) -> None:
    command = function_of(name)
    for words in each_option(command):
        given = line.read(command, words)
        assert given is not None, words
        assert given == as_typer_reads([name, *words]), words
        assert {k: type(v) for k, v in given.items()} == {
            k: type(v) for k, v in (as_typer_reads([name, *words]) or {}).items()
        }


@pytest.mark.parametrize("written", NOT_READ)
def test_a_line_that_is_wrong_is_left_to_typer(written: str) -> None:
    name, *words = shlex.split(written)
    assert line.read(function_of(name), words) is None
    assert as_typer_reads([name, *words]) is None


def test_a_file_that_nobody_may_read_is_left_to_typer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "lib").mkdir()
    monkeypatch.setattr("os.access", lambda *_: False)
    words = ["a.pmo", "--library", str(tmp_path / "lib")]
    assert line.read(function_of("check"), words) is None
    assert line.read(function_of("check"), ["a.pmo", "--library", "nowhere"]) is not None
