"""The picture of the README is what the README's command makes of examples/walking_leg.pmo.

`pytest --update-golden` makes it again.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from planarc.cli.app import run

ROOT = Path(__file__).parents[2]
COMMAND = re.compile(r"The picture at the top\s+is made by\s+`planarc ([^`]*)`")
#: Equal up to this many pixels or degrees, at any time.
CLOSE = 1.0


def make(output: Path) -> str:
    found = COMMAND.search((ROOT / "README.md").read_text("utf-8"))
    assert found
    *arguments, last = shlex.split(found[1])
    assert last == "examples/walking_leg.svg"
    here = [str(ROOT / a) if a.startswith("examples/") else a for a in arguments]
    assert run([*here, str(output)]) == 0
    return output.read_text("utf-8")


def numbers(text: str) -> list[float]:
    return [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", text)]


def course(node: Any) -> Any:
    """The values of an animation at a hundred times."""
    rows = np.array([numbers(v) for v in node.get("values").split(";")])
    times = node.get("keyTimes")
    keys = numbers(times.replace(";", " ")) if times else np.linspace(0, 1, len(rows))
    at = np.linspace(0, 1, 100)
    return np.column_stack([np.interp(at, keys, column) for column in rows.T])


def test_the_picture_shows_what_the_model_does(
    request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    stored = ROOT / "examples" / "walking_leg.svg"
    text = make(tmp_path / "picture.svg")
    if request.config.getoption("--update-golden"):
        stored.write_text(text, encoding="utf-8", newline="\n")
    new, old = (list(ElementTree.fromstring(t).iter()) for t in (text, stored.read_text("utf-8")))
    assert [n.tag for n in new] == [o.tag for o in old]
    for a, b in zip(new, old, strict=True):
        assert a.text == b.text or not (a.text or "").strip()
        if a.get("values") and a.get("calcMode") != "discrete":
            np.testing.assert_allclose(course(a), course(b), atol=CLOSE)
        for name in set(a.keys()) - {"values", "keyTimes"}:
            assert numbers(a.get(name)) == pytest.approx(numbers(b.get(name)), abs=CLOSE)


def test_it_moves_and_comes_back_to_where_it_began() -> None:
    """Otherwise it would jump, each time that it begins again."""
    text = (ROOT / "examples" / "walking_leg.svg").read_text("utf-8")
    nodes = [n for n in ElementTree.fromstring(text).iter() if n.get("values")]
    moving = [n for n in nodes if n.get("calcMode") != "discrete"]  # the clock begins again
    assert len(moving) > 10
    for node in moving:
        path = course(node)
        off = path[-1] - path[0]
        if node.get("type") == "rotate":
            off = (off + 180) % 360 - 180  # whole turns are none
        np.testing.assert_allclose(off, 0, atol=0.5)
    assert max(float(np.ptp(course(n))) for n in moving) > 100
