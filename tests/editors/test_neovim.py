"""The shipped settings in a real Neovim: what its user sees, key by key.

`PLANARC_NEOVIM` names the program, 0.11 or newer; where it is missing, the test is skipped.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAM = os.environ.get("PLANARC_NEOVIM", "")

pytestmark = pytest.mark.skipif(not PROGRAM, reason="PLANARC_NEOVIM names no Neovim")


def test_a_session(tmp_path: Path) -> None:
    text = (ROOT / "examples" / "four_bar.pmo").read_text("utf-8")
    (tmp_path / "four_bar.pmo").write_text(text, "utf-8")
    command = tmp_path / "planarc"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m planarc "$@"\n', "utf-8")
    command.chmod(0o755)
    own = {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}", "HOME": str(tmp_path)}
    settings = ROOT / "editors" / "neovim" / "planarc.lua"
    session = Path(__file__).with_name("session.lua")
    subprocess.run(
        [
            PROGRAM, "--headless", "--clean", "-u", settings, "four_bar.pmo",
            "-c", f"luafile {session}",
        ],
        cwd=tmp_path, env={**os.environ, **own}, timeout=180, check=True,
        stdin=subprocess.DEVNULL, capture_output=True,
    )  # fmt: skip
    seen = json.loads((tmp_path / "seen.json").read_text("utf-8"))
    assert "problem" not in seen, seen["problem"]
    assert (seen["client"], seen["mistakes"]) == ("planarc", 0)
    assert "mobility 1, 2 states" in seen["hints"]
    assert seen["completed"] == {
        "connector": ["frame_a", "frame_b"],
        "name": ["crank", "crankBody"],
        "class": ["Fixed", "FixedTranslation"],
        "modifier": ["width"],
    }
    assert seen["declared"].startswith("model FixedTranslation")
    assert seen["uses"] == text.count("crank.") + 1
    assert seen["renamed"]
    assert seen["formatted"] == "  parameter Real unused = 1;"
    assert "Fixd" in seen["mistake"]
    assert seen["mended"] == "  Fixed fixed;"
    assert seen["page"].startswith("http://127.0.0.1:")
    assert seen["handbook"].endswith("handbook.html#PlanarMultiBody.Parts.FixedTranslation")
    assert "FourBar is complete" in seen["told"]
