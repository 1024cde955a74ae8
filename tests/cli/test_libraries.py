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


def test_list_shows_files_that_stand_by_themselves_in_a_folder(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Their names need not be those of their classes, as beside a library they are scripts."""
    script = Path("second/two_clocks.pmo")
    script.write_text('model One "1"\nend One;\nmodel Two "2"\nend Two;\n', "utf-8")
    Path("second/Watches 1.0.mo").write_text("package Watches\nend Watches;\n", "utf-8")
    assert run(["list", "second"]) == 0
    clock = 'package Watches "second"\nmodel Watches.Clock "second"\n'
    assert capsys.readouterr().out == f'{clock}model One "1"\nmodel Two "2"\n'
    assert run(["list", "--library", "second"]) == 0
    names = [line.split(' "')[0].split()[-1] for line in capsys.readouterr().out.splitlines()]
    assert names == ["Watches", "Complex", "Modelica", "PlanarMultiBody"]
    script.write_text("model One\n", "utf-8")
    assert run(["list", "second"]) == 1
    assert "two_clocks.pmo:1:10" in capsys.readouterr().err


def test_list_without_arguments_shows_what_is_found(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", "--library", "second"]) == 0
    first, *others = capsys.readouterr().out.splitlines()
    assert first == 'package Watches "second"'
    names = [line.split(' "')[0].split()[-1] for line in others]
    assert names == ["Complex", "Modelica", "PlanarMultiBody"]


def test_every_class_of_planarc_can_be_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["list", "PlanarMultiBody"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("model PlanarMultiBody.Joints.Revolute ") for line in lines)
    assert all(' "' in line for line in lines), [line for line in lines if ' "' not in line]


def test_the_highest_version_in_a_folder_is_taken(capsys: pytest.CaptureFixture[str]) -> None:
    for slope, version in enumerate(("1.2", "1.10", "1.9.9"), 5):
        package = Path("third") / f"Sundials {version}"
        package.mkdir(parents=True)
        (package / "package.mo").write_text("package Sundials\nend Sundials;\n", "utf-8")
        text = "within Sundials;\n" + CLOCK.format(version, slope)
        (package / "Clock.mo").write_text(text, "utf-8")
    assert rate(capsys, "Sundials.Clock", "--library", "third") == 6


def test_a_file_must_be_where_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    path = Path("first/Watches/Clock.mo")
    path.write_text("within Elsewhere;\n" + CLOCK.format("", 1), "utf-8")
    assert run(["check", "Watches.Clock", "--library", "first"]) == 1
    err = capsys.readouterr().err
    assert "says `within Elsewhere`" in err
    assert "hint: write `within Watches;`" in err


def test_a_file_that_says_nothing_of_its_package_is_warned_of(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("first/Watches/Clock.mo").write_text(CLOCK.format("", 1), "utf-8")
    assert run(["check", "Watches.Clock", "--library", "first"]) == 0
    err = capsys.readouterr().err
    assert "warning[F205]" in err
    assert "hint: write `within Watches;` above it" in err


def test_a_file_must_hold_the_class_of_its_name(capsys: pytest.CaptureFixture[str]) -> None:
    Path("first/Watches/Dial.mo").write_text("within Watches;\n" + CLOCK.format("", 1), "utf-8")
    assert run(["check", "Watches.Dial", "--library", "first"]) == 1
    assert "the file `Dial.mo` holds no class `Dial`" in capsys.readouterr().err


def test_classes_come_in_the_order_of_package_order(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("Alarm", "Bell"):
        text = f"within Watches;\nmodel {name}\nend {name};\n"
        Path(f"first/Watches/{name}.mo").write_text(text, "utf-8")
    Path("first/Watches/package.order").write_text("Clock\nBell\nGone\n", "utf-8")
    assert run(["list", "Watches", "--library", "first"]) == 0
    names = [line.split()[1] for line in capsys.readouterr().out.splitlines()]
    assert names == ["Watches", "Watches.Clock", "Watches.Bell", "Watches.Alarm"]


@pytest.mark.parametrize(
    ("wanted", "warned"), [("2.0", False), ("1.9", False), ("1.0", True), ("3.0", True)]
)
def test_another_version_than_the_model_uses_is_warned_of(
    wanted: str, warned: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    versions = 'version="2.0", conversion(noneFromVersion="1.9", noneFromVersion="1.8")'
    text = f"package Watches\n  annotation({versions});\nend Watches;\n"
    Path("first/Watches/package.mo").write_text(text, "utf-8")
    uses = f'annotation(uses(Watches(version="{wanted}"), Nowhere(version="1")))'
    Path("wrist.pmo").write_text(f"model Wrist\n  extends Watches.Clock;\n  {uses};\nend Wrist;\n")
    assert run(["check", "wrist.pmo", "--library", "first"]) == 0
    err = capsys.readouterr().err
    message = f"warning[C119]: `Wrist` is written for Watches {wanted}, but Watches 2.0 is found"
    assert (message in err) == warned
    assert ("warning" in err) == warned


def test_only_the_classes_that_are_used_are_read() -> None:
    """The others need not even be readable."""
    from planarc.request.request import Request, open_target
    from planarc.stages import flatten

    package = Path("first/Watches")
    for i in range(300):
        text = f"model Wheel{i} Real x = {i}; end Wheel{i};" if i < 30 else "this is no class"
        (package / f"Wheel{i}.mo").write_text(f"within Watches;\n{text}\n", "utf-8")
    used = "".join(f"Watches.Wheel{i} w{i};\n" for i in range(30))
    Path("train.pmo").write_text(f"model Train\n{used}end Train;\n", "utf-8")
    target = open_target(Request(Path("train.pmo"), libraries=(Path("first"),)))
    assert len(flatten(target).equations) + len(flatten(target).variables) >= 30
    read = sorted(path.name for path in target.reader.files)
    assert read == sorted(["train.pmo", "package.mo", *(f"Wheel{i}.mo" for i in range(30))])
