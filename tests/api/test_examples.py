"""What users read first in Python: the notebook, the example scripts, the README."""

from __future__ import annotations

import json
import re
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from planarc import Model

ROOT = Path(__file__).parents[2]
PYTHON = re.findall(
    r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
)


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.ipynb")), ids=lambda p: p.stem)
def test_a_notebook_runs_from_its_first_cell_to_its_last(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(path.parent)
    cells = json.loads(path.read_text("utf-8"))["cells"]
    names: dict[str, Any] = {"__name__": "__main__"}
    for i, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [], "a notebook is kept without outputs"
            exec(compile("".join(cell["source"]), f"cell {i}", "exec"), names)
    assert names["result"]._repr_html_().startswith("<iframe")


def test_scipy_bends_a_coupler_curve_through_points(four_bar: Model) -> None:
    example = runpy.run_path(str(ROOT / "examples" / "coupler_curve.py"))
    _, (before, after) = example["optimize"](four_bar, evaluations=25)
    assert after.max() < 0.25 * before.max()


def test_the_python_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert PYTHON
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "four_bar.pmo").write_bytes((ROOT / "examples" / "four_bar.pmo").read_bytes())
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    pytest.importorskip("matplotlib").use("Agg")
    names: dict[str, Any] = {"__name__": "readme"}
    for block in PYTHON:
        exec(compile(block, "README.md", "exec"), names)


def test_the_python_of_the_readme_has_right_types(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    (tmp_path / "readme.py").write_text("\n".join(PYTHON), "utf-8")
    found = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent",
         "--config-file", str(ROOT / "pyproject.toml"), str(tmp_path / "readme.py")],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )  # fmt: skip
    assert found.returncode == 0, found.stdout + found.stderr
