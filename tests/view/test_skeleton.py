"""A model that draws nothing is drawn by its frames and joints."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planarc
from planarc.view.scene import make_scene


@pytest.fixture(scope="module")
def plain() -> Any:
    model = planarc.load(
        "model M extends PlanarMultiBody.Examples.Loops.FourBar(world(enableAnimation=false));"
        " annotation(experiment(StopTime=1)); end M;"
    )
    return model.simulate().rows


def test_links_are_bars_and_joints_are_circles(plain: Any) -> None:
    scene = make_scene(plain)
    bars = {item.component: item for item in scene.items if item.shape == "plate"}
    joints = {item.component for item in scene.items if item.shape == "pin"}
    assert set(bars) == {"crank", "coupler", "rocker"}
    assert joints == {"revA", "revB", "revC", "revD"}
    (x, y), (a, b) = bars["crank"].points
    assert np.hypot(a - x, b - y) == pytest.approx(0.4, abs=1e-9)
    angle = np.unwrap(np.asarray(bars["crank"].angle) - plain["crank.body.phi"])
    np.testing.assert_allclose(np.sin(angle), 0.0, atol=1e-6)


def test_joints_lie_over_the_bars_and_all_lies_in_the_box(plain: Any) -> None:
    scene = make_scene(plain)
    heights = {item.component: item.height for item in scene.items}
    for joint, bars in {
        "revA": ["crank"],
        "revB": ["crank", "coupler"],
        "revC": ["rocker"],
    }.items():
        assert all(heights[bar] < heights[joint] for bar in bars)
    assert scene.box is not None
    left, bottom, right, top = scene.box
    assert left < plain["crank.frame_b.r[1]"].min()
    assert right > 1.0
    assert bottom < plain["crank.frame_b.r[2]"].min()
    assert top > plain["rocker.frame_b.r[2]"].max()


def test_a_model_with_pictures_keeps_to_them() -> None:
    model = planarc.load("PlanarMultiBody.Examples.Elementary.Pendulum")
    scene = make_scene(model.simulate().rows)
    shapes = {item.component: item.shape for item in scene.items}
    assert shapes == {"bob": "plate", "bob.centre": "mass", "hinge.hinge": "pin", "hinge": "ground"}
    assert scene.corner is not None
