"""The commands of analyses and studies: what they say, as text and as JSON."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planarc.cli.app import run
from planarc.view.table.files import read_table

ROOT = Path(__file__).parents[2]
PENDULUM = str(ROOT / "examples" / "pendulum.pmo")
FOUR_BAR = str(ROOT / "examples" / "four_bar.pmo")


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert run(arguments) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    return json.loads(said(capsys, *arguments, "--json"))


def test_linearize(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "linearize", FOUR_BAR, "--at", "equilibrium", "--output-of", "revD.phi")
    (mode,) = found["modes"]
    assert found["stable"]
    assert mode["natural_frequency"] == pytest.approx(math.sqrt(-found["A"][1][0]))
    assert (found["states"], found["outputs"]) == (["revA.phi", "revA.w"], ["revD.phi"])
    assert len(found["C"]) == 1
    text = said(capsys, "linearize", FOUR_BAR, "--at", "equilibrium")
    assert f"{mode['natural_frequency']:.6g}" in text


def test_linearize_takes_a_time_with_a_unit(capsys: pytest.CaptureFixture[str]) -> None:
    found = [told(capsys, "linearize", FOUR_BAR, "--at", at) for at in ("500ms", "0.5")]
    assert found[0] == found[1]
    assert found[0]["time"] == 0.5
    assert run(["linearize", FOUR_BAR, "--at", "5kg"]) == 2
    assert "error[C115]: `at` takes a value in `s`, not `5kg`" in capsys.readouterr().err


def test_linearize_tells_what_holds(capsys: pytest.CaptureFixture[str]) -> None:
    block = "PlanarMultiBody.Examples.Contacts.RockingBlock"
    assert "3 states; others are held by `contact` (point 2)\n" in said(capsys, "linearize", block)
    assert told(capsys, "linearize", block)["holding"] == ["`contact` (point 2)"]


def test_equilibrium(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "equilibrium", FOUR_BAR, "--set", "revA.phi.start=-1")
    assert abs(found["values"]["revA.z"]) < 1e-7
    text = said(capsys, "equilibrium", FOUR_BAR)
    assert "stable" in text
    assert f"{found['start']['revA.phi']:.7g}" in text


def test_a_model_without_states_neither_rests_nor_is_put_together(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "ramp.pmo").write_text("model Ramp Real x = 2*time; end Ramp;", "utf-8")
    for command, words in (
        ("equilibrium", "Ramp has no states: nothing in it comes to rest by itself\n"),
        ("assemble", "Ramp has no states: there is nothing to put together\n"),
    ):
        assert said(capsys, command, str(tmp_path / "ramp.pmo")) == words


def test_assemble(capsys: pytest.CaptureFixture[str]) -> None:
    found = told(capsys, "assemble", FOUR_BAR, "--tries", "40")
    assert len(found["assemblies"]) == 2
    assert "2 ways" in said(capsys, "assemble", FOUR_BAR, "--tries", "40")


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_simulate_lists_the_assemblies_and_runs_nothing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    backend: str,
) -> None:
    if backend == "native":
        pytest.importorskip("llvmlite")
    monkeypatch.chdir(tmp_path)
    options = ("--assembly", "--backend", backend, "--set", "revA.phi.start=0.5")
    found = told(capsys, "simulate", FOUR_BAR, *options)
    assert len(found["assemblies"]) == 2
    assert {way["start"]["revA.phi"] for way in found["assemblies"]} == {0.5}
    assert "2 ways" in said(capsys, "simulate", FOUR_BAR, *options)
    assert list(tmp_path.iterdir()) == []


def test_assemblies_are_written_into_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", FOUR_BAR, "--assembly", "--output", "x.csv"]) == 2
    assert "C112" in capsys.readouterr().err


def test_drive(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    motion, forces = tmp_path / "motion.csv", tmp_path / "forces.csv"
    time = np.linspace(-0.1, 1.1, 500)
    rows = "\n".join(f"{t!r},{1 + 2 * t!r}" for t in time.tolist())
    motion.write_text(f"time,phi\n{rows}\n", "utf-8")
    options = ("--stop", "1", "--intervals", "10")
    by_text = told(capsys, "drive", FOUR_BAR, "--motion", "revA.phi=1 + 2*time", *options)
    by_file = told(capsys, "drive", FOUR_BAR, "--motion", f"revA.phi=@{motion}", *options)
    torques = [found["efforts"]["revA.phi"]["values"] for found in (by_text, by_file)]
    assert np.allclose(*torques, atol=1e-6)
    text = said(
        capsys, "drive", FOUR_BAR, "--motion", "revA.phi=1 + 2*time", "--output", str(forces),
        *options,
    )  # fmt: skip
    assert "revA.tau" in text
    assert np.allclose(read_table(forces)["revA.tau"], torques[0])


def test_sensitivity(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    table = tmp_path / "s.csv"
    options = ("--parameter", "crankBody.m", "--variable", "revA.phi", "--stop", "1")
    found = told(capsys, "sensitivity", FOUR_BAR, *options, "--intervals", "4")
    (only,) = found["sensitivities"]
    assert (only["variable"], only["parameter"]) == ("revA.phi", "crankBody.m")
    text = said(capsys, "sensitivity", FOUR_BAR, *options, "--output", str(table))
    assert f"{only['values'][-1]:.6g}" in text
    assert found["derivatives"] == "formulas"
    assert "from formulas" in text
    assert table.read_text("utf-8").startswith("time,d(revA.phi)/d(crankBody.m)")


def test_sensitivity_without_a_derivative_at_a_row(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    model = tmp_path / "B.pmo"
    model.write_text(
        "model B parameter Real p = 0.5; discrete Real a(start=0, fixed=true);"
        " discrete Real b(start=0, fixed=true); Real y; equation y = a + b;"
        " when time >= p then a = time; end when;"
        " when time >= 1 - p then b = 2*time; end when; end B;",
        "utf-8",
    )
    options = ("--parameter", "p", "--variable", "y", "--stop", "1", "--intervals", "4")
    (only,) = told(capsys, "sensitivity", str(model), *options)["sensitivities"]
    assert only["values"][2] is None
    text = said(capsys, "sensitivity", str(model), *options)
    assert text.splitlines()[-1].split() == ["y", "p", "-1", "1"]


def test_sweep(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    options = ("--metric", "max(revA.w)", "--metric", "revA.phi", "--stop", "1")
    found = told(capsys, "sweep", FOUR_BAR, "--vary", "crankBody.m=0.5:1:3", *options)
    assert found["columns"] == ["crankBody.m", "max(revA.w)", "revA.phi"]
    assert [row[0] for row in found["rows"]] == [0.5, 0.75, 1.0]
    listed = told(capsys, "sweep", FOUR_BAR, "--vary", "crankBody.m=0.5,0.75,1", *options)
    assert listed["rows"] == found["rows"]
    journal, table = tmp_path / "j", tmp_path / "t.csv"
    sample = ("sweep", FOUR_BAR, "--vary", "crankBody.m=1:2", "--latin", "25", *options)
    again = [
        said(capsys, *sample, "--journal", str(journal), "--output", str(table)) for _ in (1, 2)
    ]
    assert again[0] == again[1]
    assert "25 points in all" in again[0]
    assert len(table.read_text("utf-8").splitlines()) == 26


def test_a_sweep_with_failed_points_says_which(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["sweep", FOUR_BAR, "--vary", "coupler.r[1]=0.9,0.01", "--stop", "1"]) == 3
    captured = capsys.readouterr()
    assert "point 2 (coupler.r[1] = 0.01) failed" in captured.err
    assert captured.out.count("\n") == 3


def test_a_sweep_of_literals_and_arrays(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "Gear.pmo"
    file.write_text(
        "model Gear type Kind = enumeration(slow, fast); parameter Kind kind = Kind.slow;"
        " parameter Boolean back = false; parameter Real k[2] = {1, 2}; output Real x = (if back"
        " then -1 else 1)*(if kind == Kind.fast then k[2] else k[1]); end Gear;",
        "utf-8",
    )
    names = ("--vary", "kind=slow,fast", "--vary", "back=true,false", "--vary", "k={1,2},{3,4}")
    found = told(capsys, "sweep", str(file), *names, "--metric", "x", "--stop", "1")
    assert found["columns"] == ["kind", "back", "k", "x"]
    assert found["rows"][0] == ["slow", 1.0, [1.0, 2.0], -1.0]
    assert [row[3] for row in found["rows"]] == [-1, -3, 1, 3, -2, -4, 2, 4]
    assert "{3, 4}" in said(capsys, "sweep", str(file), *names, "--metric", "x", "--stop", "1")


def test_structural_settings_are_told_as_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    weightless = ("--set", "world.gravityType=NoGravity")
    assert run(["linearize", PENDULUM, *weightless]) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("note[C116]: `world.gravityType` is structural")
    assert "Recompiled" not in captured.err
    sweep = ("sweep", PENDULUM, "--vary", "rod.m=1,2", "--metric", "hinge.w", *weightless)
    assert [row[1] for row in told(capsys, *sweep)["rows"]] == [0.0, 0.0]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize(
    "command",
    [
        ("simulate", "--no-report"),
        ("drive", "--motion", "hinge.phi=time"),
        ("sensitivity", "--parameter", "rod.m"),
        ("sweep", "--vary", "rod.m=1,2"),
    ],
)
def test_a_full_disk_loses_nothing(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: tuple[str, ...],
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (tmp_path / "out.csv").symlink_to("/dev/full")
    name, *options = command
    assert run([name, PENDULUM, *options, "--output", str(tmp_path / "out.csv")]) == 2
    said = capsys.readouterr().err
    assert "no space left" in said
    (elsewhere,) = tmp_path.glob("planarc-*/out.csv")
    assert f"what was computed is in `{elsewhere}`" in said
    assert len(elsewhere.read_text("utf-8").splitlines()) >= 3


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_a_table_that_no_disk_takes_is_printed_whole(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "gone"))
    (tmp_path / "out.csv").symlink_to("/dev/full")
    sweep = ["sweep", PENDULUM, "--vary", "rod.m=1:2:30", "--stop", "0.1"]
    sweep += ["--output", str(tmp_path / "out.csv"), "--workers", "1"]
    assert run(sweep) == 2
    assert capsys.readouterr().out.count("\n") == 31
    assert run([*sweep, "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    assert (found["ok"], found["output"], len(found["rows"])) == (False, None, 30)
    assert found["diagnostics"][0]["code"] == "V501"


def test_a_motion_from_a_file(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    table = tmp_path / "motion.txt"
    motion = ("drive", PENDULUM, "--motion", f"hinge.phi=@{table}")
    for text in ("time phi\n0 1\n1 2\n2 3\n3 4\n", "0;1\n\n1;2\n2;3\n3;4", "0, 1\n1, 2\n2,3\n3,4"):
        table.write_text(text, "utf-8")
        assert "from t = 0 s to 3 s" in said(capsys, *motion)
    assert run([*motion, "--stop", "4"]) == 2
    assert "is known from 0 s to 3 s" in capsys.readouterr().err
    table.write_text("0 1\n1 2\n2 three\n", "utf-8")
    assert run(motion) == 2
    assert f"line 3 of `{table}` is no time and value: `2 three`" in capsys.readouterr().err


WRONG = [
    (("sweep", FOUR_BAR), "nothing is varied"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m"), "no NAME=VALUE"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=a:b:3"), "no numbers"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1,2", "--vary", "crankBody.m=3"), "given twice"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1:2:3", "--latin", "3"), "no range"),
    (("sweep", FOUR_BAR, "--vary", "world.gravityType=NoGravity"), "with `--set`"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1,2", "--output", "a.mat"), "use `.csv`"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1:2"), "how many"),
    (("sweep", FOUR_BAR, "--vary", "crankBdy.m=1,2"), "crankBody.m"),
    (("sweep", FOUR_BAR, "--vary", "revA.drivenFlange=true,false"), "structural"),
    (("sweep", FOUR_BAR, "--vary", "a=1:2", "--random", "3", "--latin", "3"), "both"),
    (("sweep", FOUR_BAR, "--vary", "crankBody.m=1,2", "--output", "no/a.csv"), "no folder `no`"),
    (("sensitivity", FOUR_BAR, "--parameter", "world.g", "--output", "no/a.csv"), "no folder"),
    (("drive", FOUR_BAR, "--motion", "revA.phi=1", "--output", "a.txt"), "use `.csv` or `.mat`"),
    (("drive", FOUR_BAR, "--motion", "revA.phi=sin(tme)"), "`revA.phi` cannot follow `sin(tme)`"),
    (("drive", FOUR_BAR), "no motion is given"),
    (("drive", FOUR_BAR, "--motion", "revA.phi=@nowhere.csv"), "cannot read"),
    (("drive", FOUR_BAR, "--motion", "revA.w=1"), "no coordinate of a joint"),
    (("sensitivity", FOUR_BAR), "no parameter is named"),
    (("linearize", FOUR_BAR, "--at", "rest"), "give `start`, `equilibrium` or a time in seconds"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_a_wrong_command_line_says_so(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], words: str
) -> None:
    assert run(arguments) == 2
    assert words in capsys.readouterr().err
    assert run([*arguments, "--json"]) == 2
    assert not json.loads(capsys.readouterr().out)["ok"]


# Three bars that carry a beam: one is too many. Its mass is 2 kg.
_BARS = """model Beam
  import P = PlanarMultiBody;
  inner P.World world;
  P.Parts.Body beam(m=2, I=0.3, r_CM={0.5, 0});
  P.Parts.FixedTranslation base[3](r={{0, 0}, {0.5, 0}, {1, 0}});
  P.Parts.FixedTranslation top[3](r={{0, 0}, {0.5, 0}, {1, 0}});
  P.Parts.FixedTranslation bar[3](each r={0, -1});
  P.Joints.Revolute low[3](phi(each start=0.3));
  P.Joints.Revolute high[3](phi(each start=-0.3));
equation
  for i in 1:3 loop
    connect(world.frame_b, base[i].frame_a);
    connect(base[i].frame_b, low[i].frame_a);
    connect(low[i].frame_b, bar[i].frame_a);
    connect(bar[i].frame_b, high[i].frame_a);
    connect(high[i].frame_b, top[i].frame_b);
    connect(top[i].frame_a, beam.frame_a);
  end for;
end Beam;
"""


@pytest.fixture
def beam(tmp_path: Path) -> str:
    file = tmp_path / "beam.pmo"
    file.write_text(_BARS, "utf-8")
    return str(file)


def test_every_command_that_runs_a_model_accepts_redundant_joints(
    capsys: pytest.CaptureFixture[str], beam: str, tmp_path: Path
) -> None:
    """The beam stays level and hangs on bars of 1 m: a pendulum."""
    accept = (beam, "--redundant", "accept")
    found = told(capsys, "equilibrium", *accept)
    assert found["stable"]
    assert found["start"]["low[1].phi"] == pytest.approx(0, abs=1e-8)
    (mode,) = told(capsys, "linearize", *accept, "--at", "equilibrium")["modes"]
    assert mode["natural_frequency"] == pytest.approx(math.sqrt(9.81))
    (assembly,) = told(capsys, "assemble", *accept)["assemblies"]  # none where bars are crossed
    assert assembly["start"]["high[1].phi"] == pytest.approx(-0.3)
    table = tmp_path / "driven.csv"
    said(capsys, "drive", *accept, "--motion", "low[1].phi=0.3+0.5*time", "-o", str(table))
    driven = read_table(table)
    weight = 2 * 9.81 * np.sin(0.3 + 0.5 * driven.time)
    assert driven["low[1].tau"] == pytest.approx(weight, abs=1e-6)
    metric = ("--metric", "final(beam.frame_a.phi)", "--stop", "1")
    said(capsys, "sweep", *accept, "--vary", "beam.m=1,2", *metric)
    chosen = ("--parameter", "beam.m", "--variable", "low[1].phi", "--stop", "1")
    said(capsys, "sensitivity", *accept, *chosen)
    said(capsys, "animate", *accept, "--stop", "1", "-o", str(tmp_path / "beam.svg"))


def test_commands_refuse_redundant_joints_otherwise(
    capsys: pytest.CaptureFixture[str], beam: str
) -> None:
    assert run(["linearize", beam]) != 0
    assert "--redundant accept" in capsys.readouterr().err


def test_values_of_a_sweep_have_units(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["sweep", FOUR_BAR, "--stop", "10ms", "--json", "--vary"]
    for text, wanted in (
        ("crankBody.m=500g,1kg", [0.5, 1.0]),
        ("crankBody.m=500g:1000g:3", [0.5, 0.75, 1.0]),
    ):
        assert run([*command, text]) == 0
        rows = json.loads(capsys.readouterr().out)["rows"]
        assert [row[0] for row in rows] == pytest.approx(wanted)
    assert run([*command, "crankBody.m=500g:1000g", "--latin", "3"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert all(0.5 <= row[0] <= 1 for row in rows)
    for text in ("crankBody.m=500g:1kg:3", "crankBody.m=1m,2m"):
        assert run([*command, text]) == 2


def test_a_sweep_shows_runs_side_by_side(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "masses.html"
    options = ("--stop", "0.5", "--workers", "1", "--report", str(page))
    assert run(["sweep", FOUR_BAR, "--vary", "crankBody.m=0.5:2:9", *options]) == 0
    assert str(page) in capsys.readouterr().out
    found = re.search(r'id="data">(.*?)</script>', page.read_text("utf-8"), re.DOTALL)
    assert found
    data = json.loads(found[1])
    labels = [data["label"], *(other["label"] for other in data["runs"])]
    assert len(labels) == 6
    assert (labels[0], labels[-1]) == ("crankBody.m = 0.5", "crankBody.m = 2")
    assert page.stat().st_size < 1_500_000
