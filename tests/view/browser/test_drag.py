"""On the live page a body follows the pointer, and the mechanism runs from where it is let go."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from planarc.core.options import Backend
from planarc.live.server import LiveServer
from planarc.request.request import Request
from tests.view.browser.conftest import PLACE, settle, until

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"


@pytest.fixture
def live(serve: Callable[..., LiveServer]) -> LiveServer:
    return serve(Request(FOUR_BAR), Backend.NUMPY)


def angle(page: Any) -> float:
    """The angle of the crank at the start."""
    page.evaluate("planarcPlayer.pause(); planarcPlayer.setTime(0)")
    until(page, "planarcPlayer.time === 0")
    return float(page.evaluate("planarcPlayer.pose('crank').angle"))


def test_a_bar_is_dragged_and_let_go(
    live: LiveServer, open_page: Callable[..., Any], screenshot: Callable[..., Path]
) -> None:
    page = open_page(live.address)
    settle(page)
    before = angle(page)
    place = page.evaluate(PLACE, [0.35, "crank"])
    view = page.evaluate("({ ...planarcPlayer.view })")
    page.mouse.move(place["x"], place["y"])
    page.mouse.down()
    for i in range(1, 11):
        page.mouse.move(place["x"] + 9 * i, place["y"] + 4 * i)
    until(page, "planarcDrag.delays.length > 1")
    assert page.evaluate("planarcPlayer.pose('crank').angle") < before - 0.1
    assert page.evaluate("({ ...planarcPlayer.view })") == view  # the picture stays where it is
    screenshot(page, "live-dragged")
    page.mouse.up()
    until(page, "!document.getElementById('reset').hidden")
    settle(page)
    assert angle(page) < before - 0.1
    page.locator("#reset").click()
    settle(page)
    until(page, "!planarcLive.busy")
    assert angle(page) == pytest.approx(before, abs=1e-6)


def test_with_shift_a_rod_gets_longer(live: LiveServer, open_page: Callable[..., Any]) -> None:
    page = open_page(live.address)
    settle(page)
    angle(page)
    start, place = (page.evaluate(PLACE, [u, "rocker"]) for u in (0.0, 0.7))
    page.keyboard.down("Shift")
    page.mouse.move(place["x"], place["y"])
    page.mouse.down()
    for i in (1, 2, 3):  # a fifth farther from the hinge
        page.mouse.move(
            *(p + 0.2 * i / 3 * (p - s) for p, s in ((place[k], start[k]) for k in "xy"))
        )
    page.mouse.up()
    page.keyboard.up("Shift")
    settle(page)
    field = page.locator('.field[data-name="rocker.r[1]"] input[type=text]')
    assert float(field.input_value()) == pytest.approx(0.8 + 0.2 * 0.7, rel=0.02)
