"""`planarc simulate` from end to end: files, JSON, exit codes, rows, interruption."""

from __future__ import annotations

import csv
import itertools
import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from planarc.cli.app import run
from tests.stdlib.small import BEGINNINGS

EXAMPLES = Path(__file__).parents[2] / "examples"
KEYS = [
    "ok",
    "model",
    "equations",
    "states",
    "solver",
    "backend",
    "seconds",
    "steps",
    "events",
    "rows",
    "output",
    "report",
    "mechanism",
    "diagnostics",
]
DECAY = """model Decay "Falls to nothing"
  parameter Real rate(min=0)=1 "Decay constant";
  Real x(start=1, fixed=true);
equation
  der(x) = -rate*x;
  annotation(experiment(StopTime=2));
end Decay;
"""
BOUNCE = """model Bounce
  Real h(start=1, fixed=true);
  Real v(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(v, -0.8*pre(v));
  end when;
end Bounce;
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MODELICAPATH", raising=False)
    (tmp_path / "decay.pmo").write_text(DECAY, "utf-8")
    (tmp_path / "bounce.pmo").write_text(BOUNCE, "utf-8")
    return tmp_path


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, Any]]:
    """Exit code and JSON object of `planarc simulate --json`."""
    capsys.readouterr()
    code = run(["simulate", *arguments, "--json"])
    out, err = capsys.readouterr()
    assert err == ""
    assert out.count("\n") == 1
    found: dict[str, Any] = json.loads(out)
    assert list(found) == KEYS
    return code, found


def rows(name: str) -> list[dict[str, float]]:
    with Path(name).open(encoding="utf-8", newline="") as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def test_a_run_says_everything_in_json(capsys: pytest.CaptureFixture[str]) -> None:
    code, found = answer(capsys, "decay.pmo")
    assert code == 0
    assert found["ok"] is True
    assert found["model"] == "Decay"
    assert found["equations"] == {"before": 1, "after": 1}
    assert found["states"] == ["x"]
    assert found["rows"] == 501
    assert (found["output"], found["report"]) == ("Decay.csv", "Decay.html")
    assert found["events"] == 0
    assert found["steps"] > 0
    assert found["seconds"]["total"] >= found["seconds"]["flatten"]
    assert found["diagnostics"] == []


def test_the_result_is_the_solution() -> None:
    assert run(["simulate", "decay.pmo", "--no-report", "--tolerance", "1e-9"]) == 0
    last = rows("Decay.csv")[-1]
    assert last["time"] == 2
    assert last["x"] == pytest.approx(0.1353352832366127, rel=1e-7)


def test_a_failure_is_json_too(capsys: pytest.CaptureFixture[str]) -> None:
    Path("bad.pmo").write_text("model Bad\n  Reel x;\nend Bad;\n", "utf-8")
    code, found = answer(capsys, "bad.pmo")
    assert code == 1
    assert found["ok"] is False
    (problem,) = found["diagnostics"]
    assert set(problem) == {"code", "severity", "message", "file", "line", "column", "hint"}
    assert (problem["severity"], problem["file"], problem["line"]) == ("error", "bad.pmo", 2)


def test_default_files_are_written_and_replaced_again(here: Path) -> None:
    before = {p.name for p in here.iterdir()}
    for _ in range(2):
        assert run(["simulate", "decay.pmo"]) == 0
    new = {p.name for p in here.iterdir()} - before
    assert new == {"Decay.csv", "Decay.csv-metadata.json", "Decay.html"}


def test_no_files_when_none_are_wanted(here: Path) -> None:
    before = sorted(here.iterdir())
    assert run(["simulate", "decay.pmo", "--no-output", "--no-report"]) == 0
    assert sorted(here.iterdir()) == before


def test_a_file_that_planarc_did_not_write_is_kept() -> None:
    Path("Decay.csv").write_text("time,x\n0,1\n", "utf-8")
    assert run(["simulate", "decay.pmo"]) == 2
    assert Path("Decay.csv").read_text("utf-8") == "time,x\n0,1\n"


def test_named_files_are_written(capsys: pytest.CaptureFixture[str]) -> None:
    Path("a.csv").write_text("anything", "utf-8")
    code, found = answer(capsys, "decay.pmo", "--output", "a.csv", "--report", "b.html")
    assert (code, found["output"], found["report"]) == (0, "a.csv", "b.html")
    assert len(rows("a.csv")) == 501
    assert "<html" in Path("b.html").read_text("utf-8")
    assert not Path("Decay.csv").exists()


def test_a_matlab_file_has_the_usual_matrices() -> None:
    from scipy.io import loadmat

    assert run(["simulate", "decay.pmo", "--output", "a.mat", "--no-report"]) == 0
    matrices = loadmat("a.mat")
    assert {"Aclass", "name", "description", "dataInfo", "data_1", "data_2"} <= set(matrices)


def test_parameters_and_start_values_are_set() -> None:
    assert run(["simulate", "decay.pmo", "--set", "rate=0", "--set", "x.start=7"]) == 0
    assert rows("Decay.csv")[-1]["x"] == pytest.approx(7)


def test_the_file_name_chooses_the_model(capsys: pytest.CaptureFixture[str]) -> None:
    text = DECAY.replace("Decay", "SlowDecay") + DECAY.replace("Decay", "Other")
    Path("slow_decay.pmo").write_text(text, "utf-8")
    assert answer(capsys, "slow_decay.pmo")[1]["model"] == "SlowDecay"
    assert answer(capsys, "slow_decay.pmo", "Other")[1]["model"] == "Other"


@pytest.mark.parametrize(
    ("options", "count"),
    [
        ((), 501),
        (("--intervals", "10"), 11),
        (("--interval", "0.5"), 5),
        (("--start", "1", "--stop", "1"), 1),
        (("--stop", "3", "--interval", "1"), 4),
    ],
)
def test_rows_stand_at_the_requested_times(
    options: tuple[str, ...], count: int, capsys: pytest.CaptureFixture[str]
) -> None:
    _, found = answer(capsys, "decay.pmo", *options)
    assert found["rows"] == count == len(rows("Decay.csv"))


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_each_event_has_two_rows(backend: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, found = answer(capsys, "bounce.pmo", "--backend", backend, "--stop", "2")
    assert code == 0
    assert found["events"] == 3  # at 0.45, 1.17 and 1.75 s
    table = rows("Bounce.csv")
    times = [row["time"] for row in table]
    twice = [a for a, b in itertools.pairwise(times) if a == b]
    assert len(table) == found["rows"] == 501 + 2 * found["events"]
    assert len(twice) == found["events"]
    assert twice[0] == pytest.approx((2 / 9.81) ** 0.5, rel=1e-5)


def test_a_failed_assertion_is_3_and_keeps_the_rows(capsys: pytest.CaptureFixture[str]) -> None:
    text = DECAY.replace("equation\n", 'equation\n  assert(x > 0.5, "x is too small");\n')
    Path("decay.pmo").write_text(text, "utf-8")
    code, found = answer(capsys, "decay.pmo")
    assert (code, found["ok"], found["output"]) == (3, False, "Decay.csv")
    assert any("x is too small" in d["message"] for d in found["diagnostics"])
    table = rows("Decay.csv")
    assert len(table) == found["rows"]
    assert 0 < table[-1]["time"] < 0.8


def test_terminate_is_a_good_end(capsys: pytest.CaptureFixture[str]) -> None:
    text = DECAY.replace(
        "equation\n", 'equation\n  when x < 0.5 then\n    terminate("done");\n  end when;\n'
    )
    Path("decay.pmo").write_text(text, "utf-8")
    code, found = answer(capsys, "decay.pmo")
    assert (code, found["ok"]) == (0, True)
    assert rows("Decay.csv")[-1]["time"] == pytest.approx(0.6931, abs=1e-3)


@pytest.mark.skipif(os.name != "posix", reason="terminals of POSIX")
def test_ctrl_c_saves_what_there_is() -> None:
    Path("endless.pmo").write_text(
        "model Endless Real x; equation der(x) = cos(time); end Endless;",
        "utf-8",
    )
    command = [sys.executable, "-m", "planarc", "simulate", "endless.pmo", "--no-report"]
    ours, theirs = os.openpty()
    process = subprocess.Popen(
        [*command, "--stop", "1e9", "--interval", "1e4"],
        stdout=theirs,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm"},
    )
    os.close(theirs)
    said = b""
    while b"Ctrl-C stops and saves" not in said:
        said += os.read(ours, 1000)
    process.send_signal(signal.SIGINT)
    with suppress(OSError):  # the end of a terminal
        while more := os.read(ours, 1000):
            said += more
    os.close(ours)
    assert process.wait() == 130
    assert b"interrupted at t = " in said
    assert b"Traceback" not in said
    table = rows("Endless.csv")
    assert table[0]["time"] == 0
    assert table[-1]["time"] < 1e9


def test_the_same_run_gives_the_same_bytes(tmp_path: Path) -> None:
    """Whatever the hash seed and the working directory."""
    found = []
    for seed in ("1", "2"):
        folder = tmp_path / f"folder{seed}"
        folder.mkdir()
        (folder / "four_bar.pmo").write_bytes((EXAMPLES / "four_bar.pmo").read_bytes())
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PLANARC_CACHE_DIR": ""}
        command = [sys.executable, "-m", "planarc", "simulate", "four_bar.pmo", "--stop", "1"]
        subprocess.run(command, check=True, cwd=folder, env=environment, capture_output=True)
        found.append({p.name: p.read_bytes() for p in folder.iterdir()})
    written = {"FourBar.csv", "FourBar.csv-metadata.json", "FourBar.html"}
    assert set(found[0]) == {"four_bar.pmo", *written}
    assert found[0] == found[1]


@pytest.mark.parametrize("backend", ["native", "numpy"])
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.pmo")), ids=lambda p: p.stem)
def test_every_example_runs(path: Path, backend: str, capsys: pytest.CaptureFixture[str]) -> None:
    short = backend == "numpy" and path.stem in BEGINNINGS
    stop = ["--stop", str(BEGINNINGS[path.stem])] if short else []
    code, found = answer(capsys, str(path), "--backend", backend, *stop)
    assert code == 0, found["diagnostics"]
    assert short or found["rows"] >= 400
    assert found["diagnostics"] == []


WITHOUT = """
import importlib.metadata, sys
sys.modules.update(dict.fromkeys(("llvmlite", "sksundae")))
find = importlib.metadata.Distribution.from_name.__func__
def hide(cls, name):
    if name in ("llvmlite", "scikit-sundae"):
        raise importlib.metadata.PackageNotFoundError(name)
    return find(cls, name)
importlib.metadata.Distribution.from_name = classmethod(hide)
from planarc.cli.app import run
sys.exit(run(sys.argv[1:]))
"""


@pytest.mark.parametrize("solver", ["auto", "scipy-bdf"])
@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.pmo")), ids=lambda p: p.stem)
def test_the_base_path_needs_neither_llvmlite_nor_sundials(path: Path, solver: str) -> None:
    """numpy and scipy alone run every example."""
    options = ["--stop", str(BEGINNINGS.get(path.stem, 0.5)), "--solver", solver, "--json"]
    command = [sys.executable, "-c", WITHOUT, "simulate", str(path), *options]
    done = subprocess.run(command, capture_output=True, text=True)
    found = json.loads(done.stdout)
    assert done.returncode == 0, found["diagnostics"]
    assert found["backend"] == "numpy"
    assert "cvode" not in found["solver"]


def test_asking_for_what_is_not_installed_is_usage() -> None:
    command = [sys.executable, "-c", WITHOUT, "simulate", "decay.pmo", "--backend", "native"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr.split(":")[0]) == (2, "error[C113]")


@pytest.mark.parametrize("first", ["true", "false"])
def test_warnings_are_those_of_the_model_that_runs(
    first: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = f"""
model Rod
  parameter Boolean found = {first};
  parameter Real length(start=1, fixed=not found);
  Real x(start=2, fixed=true);
initial equation
  if found then
    length = x;
  end if;
equation
  der(x) = -length*x;
end Rod;
"""
    Path("rod.pmo").write_text(text)
    then = "false" if first == "true" else "true"
    command = ["simulate", "rod.pmo", "--set", f"found={then}", "--stop", "1", "-o", "rod.csv"]
    assert run(command) == 0
    captured = capsys.readouterr()
    printed = captured.out + captured.err
    assert "note[C116]" in printed
    assert ("warning[F286]" in printed) == (then == "false")


def test_a_structural_parameter_is_set_by_compiling_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "model Fan parameter Integer n = 2; Real y[n] = {i*time for i in 1:n}; end Fan;"
    Path("fan.pmo").write_text(text)
    assert run(["simulate", "fan.pmo", "--set", "n=3", "--stop", "1", "-o", "fan.csv"]) == 0
    captured = capsys.readouterr()
    assert "note[C116]: `n` is structural" in captured.out + captured.err
    rows = list(csv.reader(Path("fan.csv").read_text().splitlines()))
    assert rows[0] == ["time", "y[1]", "y[2]", "y[3]"]
    assert [float(x) for x in rows[-1]] == [1, 1, 2, 3]
