"""Libraries: where they are looked for, in which order, and what `list` says of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from planarc.cli.app import run

CLOCK = 'model Clock "{}"\n  Real x(start=0, fixed=true);\nequation\n  der(x) = {};\nend Clock;\n'


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two folders of libraries, each with a package `Watches`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MODELICAPATH", raising=False)
    for rate, root in enumerate(("first", "second"), 1):
        package = tmp_path / root / "Watches"
        package.mkdir(parents=True)
        (package / "package.mo").write_text(f'package Watches "{root}"\nend Watches;\n', "utf-8")
        text = "within Watches;\n" + CLOCK.format(root, rate)
        (package / "Clock.mo").write_text(text, "utf-8")
    return tmp_path


def rate(capsys: pytest.CaptureFixture[str], *arguments: str) -> float:
    """The slope of x, which tells the libraries apart."""
    capsys.readouterr()
    assert run(["simulate", *arguments, "--no-report", "--json"]) == 0
    path = Path(json.loads(capsys.readouterr().out)["output"])
    header, *_, last = path.read_text("utf-8").splitlines()
    assert header == '"time","x","der(x)"'
    return round(float(last.split(",")[1]), 6)


@pytest.mark.parametrize("library", ["second", "second/Watches", "second/Watches/package.mo"])
def test_a_library_is_a_folder_of_packages_a_package_or_its_file(
    library: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert rate(capsys, "Watches.Clock", "--library", library) == 2


def test_a_library_is_a_single_file(capsys: pytest.CaptureFixture[str]) -> None:
    text = f"package Tower\n{CLOCK.format('', 3)}end Tower;\n"
    Path("Tower.mo").write_text(text, "utf-8")
    assert rate(capsys, "Tower.Clock", "--library", "Tower.mo") == 3


def test_the_first_library_wins(capsys: pytest.CaptureFixture[str]) -> None:
    both = ("--library", "first", "--library", "second")
    assert rate(capsys, "Watches.Clock", *both) == 1
    assert rate(capsys, "Watches.Clock", *both[2:], *both[:2]) == 2


def test_modelicapath_comes_after_the_options(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MODELICAPATH", "second")
    assert rate(capsys, "Watches.Clock") == 2
    assert rate(capsys, "Watches.Clock", "--library", "first") == 1


def test_a_file_uses_libraries(capsys: pytest.CaptureFixture[str]) -> None:
    text = "model Wrist\n  extends Watches.Clock;\nend Wrist;\n"
    Path("wrist.pmo").write_text(text, "utf-8")
    assert rate(capsys, "wrist.pmo", "--library", "second") == 2


def test_list_shows_files_packages_and_folders(capsys: pytest.CaptureFixture[str]) -> None:
    clock = 'package Watches "second"\nmodel Watches.Clock "second"\n'
    assert run(["list", "second"]) == 0
    assert capsys.readouterr().out == clock
    assert run(["list", "Watches", "--library", "second"]) == 0
    assert capsys.readouterr().out == clock
    assert run(["list", "second/Watches/Clock.mo", "--library", "second"]) == 0
    assert capsys.readouterr().out == 'model Watches.Clock "second"\n'


def test_list_without_arguments_shows_what_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", "--library", "second"]) == 0
    first, *others = capsys.readouterr().out.splitlines()
    assert first == 'package Watches "second"'
    assert [line.split()[1] for line in others] == ["Modelica", "PlanarMultiBody"]


def test_every_class_of_planarc_can_be_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", "PlanarMultiBody"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("model PlanarMultiBody.Joints.Revolute ") for line in lines)
    assert all(' "' in line for line in lines), [line for line in lines if ' "' not in line]
