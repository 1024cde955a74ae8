"""`planarc check --all`: what is counted, what is said, and what cannot stop it."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from planarc.catalog import survey
from planarc.cli.app import run
from planarc.request.request import Request

REPOSITORY = Path(__file__).parents[2]
GOOD = "model {} Real x(start=0, fixed=true); equation der(x) = 1; end {};\n"


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """Ship.Hull is good, Ship.Mast.Sail does not balance, Ship.Rope cannot be read."""
    files = {
        "package.mo": "package Ship\n  constant Real pi = 3;\n  type Length = Real;\nend Ship;\n",
        "package.order": "pi\nLength\nHull\nMast\nRope\nDeck\n",
        "Hull.mo": "within Ship;\n" + GOOD.replace("{}", "Hull"),
        "Mast/package.mo": "within Ship;\npackage Mast\nend Mast;\n",
        "Mast/Sail.mo": "within Ship.Mast;\nmodel Sail Real x; end Sail;\n",
        "Mast/Flag.mo": "within Ship.Mast;\npartial block Flag Real x; end Flag;\n",
        "Rope.mo": "within Ship;\nmodel Rope Real x y; end Rope;\n",
        "Deck.mo": "within Ship;\nblock Deck output Real y = 1; model In\nend In; end Deck;\n",
    }
    for name, text in files.items():
        path = tmp_path / "Ship" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    return tmp_path / "Ship"


def test_the_embedded_libraries_are_clean(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("PlanarMultiBody", "Modelica"):
        assert run(["check", "--all", name]) == 0, capsys.readouterr().err


def test_the_examples_are_clean(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "--all", str(REPOSITORY / "examples"), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    files = len(list((REPOSITORY / "examples").rglob("*.pmo")))
    outer = [c["name"] for c in answer["classes"] if "." not in c["name"]]
    assert (len(outer), answer["bad"], answer["percent"]) == (files, 0, 100.0)


def test_every_class_is_named_with_its_verdict(
    library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["check", "--all", "Ship", "--library", str(library), "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    found = [(c["name"], c["kind"], c["verdict"]) for c in answer["classes"]]
    assert found == [
        ("Ship", "package", "read"),
        ("Ship.Length", "type", "read"),
        ("Ship.Hull", "model", "good"),
        ("Ship.Mast", "package", "read"),
        ("Ship.Mast.Flag", "partial block", "read"),
        ("Ship.Mast.Sail", "model", "bad"),
        ("Ship.Rope", "class", "bad"),
        ("Ship.Deck", "block", "good"),
        ("Ship.Deck.In", "model", "good"),
    ]
    codes = {c["name"]: [d["code"] for d in c["diagnostics"]] for c in answer["classes"]}
    assert codes["Ship.Rope"] == ["P101"]
    assert codes["Ship.Mast.Sail"]
    assert not codes["Ship.Hull"]
    assert (answer["good"], answer["bad"], answer["others"], answer["percent"]) == (3, 2, 4, 60.0)
    assert [p["package"] for p in answer["packages"]] == ["Ship", "Ship.Mast"]
    assert sum(p["good"] + p["bad"] + p["others"] for p in answer["packages"]) == len(found)


@pytest.mark.parametrize("by_folder", [False, True])
def test_the_table_counts_by_package(
    library: Path, by_folder: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    target = [str(library)] if by_folder else ["Ship", "--library", str(library)]
    assert run(["check", "--all", *target]) == 1
    out, err = capsys.readouterr()
    rows = [line.split() for line in out.splitlines()]
    assert rows[0] == ["package", "models", "good", "bad", "per", "cent", "others"]
    assert rows[1] == ["Ship", "4", "3", "1", "75.0", "2"]
    assert rows[2] == ["Ship.Mast", "1", "0", "1", "0.0", "2"]
    assert rows[-1] == ["Ship", "5", "3", "2", "60.0", "4"]
    assert err.count("error[") == 2
    assert "  in: `Ship.Rope`\n" in err


def test_a_folder_of_files_and_packages(library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = library.parent
    (folder / "boat.pmo").write_text("model Boat extends Ship.Hull; end Boat;\n", "utf-8")
    (folder / "wreck.pmo").write_text("model Wreck", "utf-8")
    assert run(["check", "--all", str(folder), "--json"]) == 1
    classes = {c["name"]: c["verdict"] for c in json.loads(capsys.readouterr().out)["classes"]}
    assert classes["Boat"] == "good"
    assert classes["wreck.pmo"] == "bad"
    assert classes["Ship.Hull"] == "good"


def test_one_cause_is_said_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    users = "\n".join(f"model M{i} extends Base; end M{i};" for i in range(5))
    text = f"package P\npartial model Base\n  Nothing x;\nend Base;\n{users}\nend P;\n"
    (tmp_path / "P.mo").write_text(text, "utf-8")
    assert run(["check", "--all", str(tmp_path / "P.mo")]) == 1
    err = capsys.readouterr().err
    assert err.count("error[") == 1
    assert "  in: `P.M0`, `P.M1`, `P.M2` and 2 more\n" in err


def test_wrong_requests(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "--all", "NoSuchLibrary"]) != 0
    assert "there is no class `NoSuchLibrary`" in capsys.readouterr().err
    assert run(["check", "--all", str(REPOSITORY / "examples" / "pendulum.pmo"), "Pendulum"]) == 2
    assert "leave out the class" in capsys.readouterr().err


# What cannot stop it ----------------------------------------------------------------------------


FORKED = pytest.mark.skipif(
    sys.platform != "linux", reason="the processes are no copies of this one"
)


@FORKED
def test_the_survey_goes_on_without_a_class_that_kills_or_hangs(
    library: Path, monkeypatch: pytest.MonkeyPatch, hang: Callable[[], None]
) -> None:
    from planarc import stages

    whole = stages.flatten

    def flatten(target: survey.Target) -> object:
        if target.class_name == "Ship.Hull":
            os.kill(os.getpid(), signal.SIGKILL)
        if target.class_name == "Ship.Deck":
            hang()
        if target.class_name == "Ship.Deck.In":
            raise KeyError("a mistake")
        return whole(target)

    monkeypatch.setattr(stages, "flatten", flatten)
    found = survey.survey(Request(None, "Ship", (library,)), workers=2)
    codes = {f.name: f.errors[0].code for f in found.findings if f.errors}
    assert codes["Ship.Hull"] == "X004"
    assert codes["Ship.Deck"] == "X003"
    assert codes["Ship.Rope"] == "P101"
    assert found.total.others == 4


@pytest.mark.parametrize(("units", "code"), [("warn", 0), ("error", 1), ("off", 0)])
@pytest.mark.parametrize("every", [True, False])
def test_units_warn_or_fail_or_are_left_alone(
    units: str, code: int, every: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = """model M
      Real s(unit="m") = time;
      Real m(unit="kg");
    equation
      m = s;
    end M;"""
    (tmp_path / "m.pmo").write_text(text, "utf-8")
    arguments = ["check", str(tmp_path / "m.pmo"), f"--units={units}", "--json"]
    assert run([*arguments, "--all"] if every else arguments) == code
    answer = json.loads(capsys.readouterr().out)
    diagnostics = answer["classes"][0]["diagnostics"] if every else answer["diagnostics"]
    found = [d["severity"] for d in diagnostics]
    assert found == {"warn": ["warning"], "error": ["error"], "off": []}[units]


def test_folders_in_a_folder_are_looked_through_too(
    tmp_path: Path, library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for place in ("one.pmo", "deep/er/two.pmo", ".hidden/three.pmo", "deep/Ship/package.mo"):
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        text = GOOD.replace("{}", Path(place).stem.title())
        (tmp_path / place).write_text(
            "package Ship model A end A; end Ship;" if place.endswith(".mo") else text, "utf-8"
        )
    assert run(["check", "--all", str(tmp_path / "deep"), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [c["name"] for c in answer["classes"]] == ["Ship", "Ship.A", "Two"]
    assert run(["check", "--all", str(tmp_path), "--json"]) == 1
    names = [c["name"] for c in json.loads(capsys.readouterr().out)["classes"]]
    assert {"One", "Two", "Ship.Hull"} <= set(names)
    assert "Three" not in names


def test_what_is_not_there_is_a_wrong_request(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "--all", "nosuch"]) == 2
    assert "error[C103]" in capsys.readouterr().err
