"""The benchmark script runs; its bars are for people, who know how busy their machine is."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parent / "bench.py"


def measure(only: str) -> str:
    command = [sys.executable, str(BENCH), "--only", only]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_help_is_measured() -> None:
    head, row = measure("help").splitlines()
    assert head.split() == ["measured", "allowed", "ratio", "pace"]
    assert row.startswith("help ")
    assert float(row.split()[1]) > 0
    assert float(row.removesuffix("  too much").split()[-1]) > 0


def test_measured_processes_keep_bytecode(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCH.parent))
    from bench import environment

    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    monkeypatch.setenv("LANG", "C")
    found = environment(PLANARC_CACHE_DIR="here")
    assert "PYTHONDONTWRITEBYTECODE" not in found
    assert (found["LANG"], found["PLANARC_CACHE_DIR"]) == ("C", "here")


def test_a_four_bar_is_run_again_and_again() -> None:
    _, row = measure("four-bar again in one process, numpy").splitlines()
    number, unit = row.split()[-2:]
    assert float(number) > 0
    assert unit == "ms"


def test_flattening_is_measured() -> None:
    command = [sys.executable, str(BENCH.with_name("flatten_bench.py")), "--only", "20"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    _, first, *rest = done.stdout.splitlines()
    assert first.startswith("flatten, 20 links ")
    assert float(first.split()[3]) > 0
    assert [row.split()[:3] for row in rest] == [["flatten,", "40", "links"]]
    assert float(rest[0].split()[5]) > 0


def test_frames_of_a_page_are_measured() -> None:
    pytest.importorskip("playwright")
    if shutil.which("chromium") is None:
        pytest.skip("there is no chromium")
    script = BENCH.with_name("frames_bench.py")
    command = [sys.executable, str(script), "PlanarMultiBody.Examples.Elementary.Pendulum"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    _, row = done.stdout.splitlines()
    own, whole = float(row.split()[1]), float(row.split()[3])
    assert 0 < own < whole


def test_a_process_is_measured_beside_the_last_release() -> None:
    command = [sys.executable, str(BENCH.with_name("speed.py")), "--only", "unchanged"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    heads, row = done.stdout.splitlines()
    assert heads.split()[:4] == ["OpenModelica", "release", "goal", "now"]
    assert row.startswith("four-bar, unchanged ")
    _, release, goal, now, ratio, megabytes, _ = row.split()[-7:]
    assert (release, goal) == ("0.24", "0.15")
    assert float(now) > 0
    assert abs(float(ratio) - float(now) / float(goal)) < 0.01
    assert float(megabytes) > 10
