"""What is under the pointer is named; its curves are a click away; names never overlap."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from tests.view.browser.conftest import PLACE, until


@pytest.fixture(scope="module")
def result() -> Any:
    return planarc.load("PlanarMultiBody.Examples.Loops.FourBar").simulate()


@pytest.mark.parametrize("size", [(1920, 1080), (1280, 800), (390, 844)])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_a_part_says_what_it_is(
    result: Any,
    open_page: Callable[..., Any],
    screenshot: Callable[..., Path],
    tmp_path: Path,
    size: tuple[int, int],
    theme: str,
) -> None:
    page = open_page(result.report(tmp_path / "page.html"), size)
    page.evaluate("theme => planarc.theme.set(theme)", theme)
    page.evaluate("planarcPlayer.setTime(1); planarcPlayer.setLayer('names', true)")
    until(page, "Math.abs(planarcPlayer.time - 1) < 1e-9")
    place = page.evaluate(PLACE, [0.3, "coupler"])
    page.mouse.move(place["x"], place["y"])
    card = page.locator(".part")
    card.wait_for(state="visible")
    told = card.inner_text()
    assert told.startswith("coupler")
    assert "BodyShape" in told
    speed = np.interp(
        1.0, result.time, np.hypot(*(result[f"coupler.body.v_CM[{i}]"] for i in (1, 2)))
    )
    assert f"{speed:.3f}"[:4] in told
    screenshot(page, f"card-{size[0]}-{theme}")
    page.mouse.click(place["x"], place["y"])
    until(page, "planarcPlots.chosen.has('coupler.body.w')")
    page.mouse.move(place["x"] + 2, 1)
    card.wait_for(state="hidden")


def test_labels_do_not_overlap(result: Any, open_page: Callable[..., Any], tmp_path: Path) -> None:
    page = open_page(result.report(tmp_path / "page.html"))
    points = [{"text": f"name {i}", "x": 300 + i % 7, "y": 200 + 3 * i} for i in range(40)]
    labels = page.evaluate(
        "points => planarc.createPlacer().place(points, (text) => 7 * text.length, 600, 400)",
        points,
    )
    assert len(labels) > 20
    for a, b in itertools.combinations(labels, 2):
        apart = (
            a["left"] + a["wide"] <= b["left"]
            or b["left"] + b["wide"] <= a["left"]
            or a["top"] + a["high"] <= b["top"]
            or b["top"] + b["high"] <= a["top"]
        )
        assert apart
    assert any(label["far"] for label in labels)
