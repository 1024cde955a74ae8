"""Files without an end are refused at once, by every command that reads one."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import planarc
from planarc.cli.app import run
from planarc.core.files import Endless, read_plain
from planarc.remembered import _unchanged

MODEL = "model M Real x(start=1, fixed=true); equation der(x) = -x; end M;"

pytestmark = pytest.mark.skipif(os.name != "posix", reason="named pipes of POSIX")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(params=["pipe", "device"])
def endless(request: pytest.FixtureRequest) -> Path:
    """A place where a file should be: its ending is up to who asks."""
    path = Path("endless")
    if request.param == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    return path


def test_no_file_without_an_end_is_read(endless: Path) -> None:
    with pytest.raises(Endless):
        read_plain(endless)
    assert not _unchanged(endless, "key")


@pytest.mark.parametrize(
    ("command", "ending", "code"),
    [
        ("simulate @", ".pmo", "C108"),
        ("fmt @", ".pmo", "C108"),
        ("check --all @", ".pmo", "C108"),
        ("view @", ".csv", "V503"),
        ("compare @ @", ".mat", "V503"),
        ("list --library @", ".mo", "C104"),
        ("drive m.pmo --motion x=@@", "", "C108"),
        ("sweep m.pmo --vary x.start=1,2 --journal @", ".jsonl", "C233"),
    ],
)
def test_no_command_waits_for_one(
    command: str, ending: str, code: str, endless: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("m.pmo").write_text(MODEL, "utf-8")
    path = endless.rename(f"endless{ending}")
    words = [w if w == "--motion" else w.replace("@@", f"@{path}") for w in command.split()]
    assert run([w.replace("@", str(path)) if w == "@" else w for w in words]) == 2
    assert f"error[{code}]" in capsys.readouterr().err


def test_a_pipe_of_the_shell_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    end, begin = os.pipe()
    os.write(begin, MODEL.encode())
    os.close(begin)
    assert run(["check", f"/dev/fd/{end}"]) == 0
    os.close(end)


LONG = "a" * 300


@pytest.mark.parametrize(
    "command",
    [
        *(f"{c} {LONG}.pmo" for c in ("simulate", "fmt", "check --all", "serve")),
        *(f"{c} {LONG}.csv" for c in ("view", "simulate m.pmo --output")),
        f"check PlanarMultiBody.{LONG}",
        f"list --library {LONG}",
    ],
)
def test_names_that_are_too_long_are_refused(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("m.pmo").write_text(MODEL, "utf-8")
    assert run(command.split()) == 2
    assert "X001" not in capsys.readouterr().err


@pytest.mark.parametrize("name", ["a\0b.csv", f"{LONG}.csv"])
def test_names_that_no_file_can_have_are_refused_in_python(name: str) -> None:
    result = planarc.load(MODEL).simulate()
    with pytest.raises(planarc.UsageError, match="V501"):
        result.to_csv(name)
    with pytest.raises(planarc.UsageError, match="C10"):
        planarc.load(name.replace("csv", "pmo"))


def test_a_name_as_long_as_may_be_is_written() -> None:
    """The new file beside it has a shorter name."""
    name = "ä" * 125 + "abc" + ".x"
    path = planarc.load(MODEL).simulate().to_csv(name[:-5] + ".csv")
    assert path.is_file()
    assert len(list(Path().iterdir())) == 1


def test_a_file_that_is_not_utf8_has_variants() -> None:
    """Structural parameters compile it again, from the text in its file."""
    text = 'model M "größe" parameter Integer n = 1; Real x[n] = ones(n); end M;'
    Path("m.pmo").write_bytes(text.encode("latin-1"))
    with pytest.warns(planarc.Recompiled):
        result = planarc.load("m.pmo").simulate(parameters={"n": 3})
    assert "x[3]" in result


def test_an_order_of_a_package_that_is_not_utf8(capsys: pytest.CaptureFixture[str]) -> None:
    folder = Path("P")
    folder.mkdir()
    (folder / "package.pmo").write_text("package P end P;", "utf-8")
    (folder / "A.pmo").write_text("within P; model A Real x = 1; end A;", "utf-8")
    (folder / "package.order").write_bytes(b"A\n\xff\n")
    assert run(["list", "P", "--library", "P"]) == 0
    assert "P.A" in capsys.readouterr().out
