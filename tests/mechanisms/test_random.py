"""Random planar mechanisms: planarc against Lagrange multipliers in absolute coordinates.

`PLANARC_MECHANISMS=2000 pytest tests/mechanisms` runs more of them; `search.py` shrinks
those that fail. See `mechanism.py` for what is drawn.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from agreement import disagreement, regular
from mechanism import from_json, model_text
from multipliers import Reference

CASES = sorted(Path(__file__).with_name("cases").glob("*.json"))
COUNT = int(os.environ.get("PLANARC_MECHANISMS", "300"))


@pytest.fixture(autouse=True)
def forgetful(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody will ask for these models again."""
    monkeypatch.setattr("planarc.remembered.remember", lambda *_: None)


def backend(seed: int) -> str:
    """Every tenth mechanism runs natively; the others compile faster without."""
    if seed % 10 == 9:
        pytest.importorskip("llvmlite")
        return "native"
    return "numpy"


@pytest.mark.parametrize("seed", range(COUNT))
def test_accelerations_and_joint_forces_agree(seed: int) -> None:
    m = regular(seed)
    found = disagreement(m, backend(seed))
    assert not found, f"{found}\n{text_of(m)}"


@pytest.mark.parametrize("path", CASES, ids=lambda p: p.stem)
@pytest.mark.parametrize("back_end", ["numpy", "native"])
def test_what_once_failed_agrees(path: Path, back_end: str) -> None:
    if back_end == "native":
        pytest.importorskip("llvmlite")
    m = from_json(path.read_text(encoding="utf-8"))
    found = disagreement(m, back_end)
    assert not found, f"{found}\n{text_of(m)}"


def text_of(m: object) -> str:
    reference = Reference(m)
    q = reference.start()
    return model_text(m, reference.frame_speeds(q, reference.drift(q)))  # type: ignore[arg-type]
