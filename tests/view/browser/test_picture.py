"""A moving SVG picture in a real browser: at any time its parts are where the result says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import planarc
from planarc.view.picture.camera import fit_camera
from planarc.view.picture.furniture import FOOT
from planarc.view.picture.motion import resample
from planarc.view.scene import make_scene

FOUR_BAR = Path(__file__).parents[3] / "examples" / "four_bar.pmo"

#: Stops at a time (s) and gives, of each group, where its origin lies and how it is turned.
POSES = """(time) => {
  const svg = document.documentElement;
  svg.pauseAnimations();
  svg.setCurrentTime(time);
  return [...svg.querySelectorAll("g")].map((g) => {
    const m = g.getCTM();
    return [m.e, m.f, Math.cos(Math.atan2(m.b, m.a)), Math.sin(Math.atan2(m.b, m.a))];
  });
}"""


def test_a_moving_picture_moves_as_the_result_does(
    open_page: Callable[..., Any], screenshot: Callable[..., Path], tmp_path: Path
) -> None:
    import numpy as np

    result = planarc.load(FOUR_BAR).simulate(3)
    page = open_page(result.animate(tmp_path / "four_bar.svg", width=600))
    scene = make_scene(result.rows)
    camera = fit_camera(scene.box, 600, FOOT)
    for time in (0.0, 0.6, 1.37, 2.9):
        poses = page.evaluate(POSES, time)
        items = resample(scene, [time], 0.0).at(0)
        assert len(poses) > len(items) > 10  # behind them stand scale and time
        for pose, item in zip(poses, items, strict=False):
            assert pose[:2] == pytest.approx(camera(item.x, item.y), abs=0.5)
            if item.shape == "plate":
                turn = -float(item.angle)
                assert pose[2:] == pytest.approx([np.cos(turn), np.sin(turn)], abs=0.01)
    screenshot(page, "picture-four-bar")
