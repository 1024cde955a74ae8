"""Where results go; no file of a user is ever lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from planarc.cli.files import Destinations, destinations, file_stem
from planarc.core.diagnostic import UsageError


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def refusal(output: Path | None = None, report: Path | None = None) -> str:
    with pytest.raises(UsageError) as caught:
        destinations("A.FourBar", output, report, False, False)
    return caught.value.diagnostics[0].code


@pytest.mark.parametrize(
    ("model", "stem"),
    [
        ("FourBar", "FourBar"),
        ("A.B.Pendulum", "Pendulum"),
        ("A.'x/../y z'", "x____y_z"),
        ("A.'..'", "__"),
        ("'a.b'", "a_b"),
    ],
)
def test_the_file_is_called_like_the_class(model: str, stem: str) -> None:
    assert file_stem(model) == stem


def test_the_default_files_lie_in_the_working_directory() -> None:
    found = destinations("A.FourBar", None, None, False, False)
    assert found == Destinations(Path("FourBar.csv"), Path("FourBar.html"))


def test_nothing_is_written_when_refused() -> None:
    assert destinations("A", None, None, True, True) == Destinations(None, None)


@pytest.mark.parametrize("text", ["time,x\n0,1\n", "x;y\n", '"t","x"\n', "\N{SNOWMAN}"])
def test_a_table_of_the_user_is_not_replaced(text: str) -> None:
    Path("FourBar.csv").write_text(text, "utf-8")
    assert refusal() == "C122"


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_table_of_times_alone_is_ours(end: str) -> None:
    """That of a model in which nothing moves."""
    Path("FourBar.csv").write_bytes(f'"time"{end}0.0{end}'.encode())
    assert destinations("A.FourBar", None, None, False, True).output == Path("FourBar.csv")


def test_a_page_of_the_user_is_not_replaced() -> None:
    Path("FourBar.html").write_text("<html><title>My four-bar</title></html>", "utf-8")
    assert refusal() == "C122"


def test_a_named_file_is_replaced() -> None:
    Path("mine.csv").write_text("time,x\n", "utf-8")
    found = destinations("A", Path("mine.csv"), None, False, True)
    assert found.output == Path("mine.csv")


@pytest.mark.parametrize("name", ["a.xlsx", "a", "csv", ".csv", "a.csv.gz"])
def test_an_unknown_ending_is_refused(name: str) -> None:
    assert refusal(Path(name)) == "C121"


def test_folders_and_missing_folders_are_refused() -> None:
    Path("a.csv").mkdir()
    assert refusal(Path("a.csv")) == "C123"
    assert refusal(Path("no/a.csv")) == "C123"
    assert refusal(report=Path("no/a.html")) == "C123"
