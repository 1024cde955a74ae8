"""Names in pictures: of bodies and joints, without overlaps, with lines to those farther away."""

from __future__ import annotations

from pathlib import Path

import pytest

import planarc
from planarc.view.marks.draw import marks_of
from planarc.view.marks.marks import Label, Outline
from planarc.view.picture.camera import fit_camera
from planarc.view.picture.motion import When, item_at, sample_motion
from planarc.view.picture.names import place_tags, tags
from planarc.view.picture.overlays import with_layers
from planarc.view.scene import make_scene

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def leg() -> planarc.Result:
    return planarc.load(EXAMPLES / "walking_leg.pmo").simulate(1)


def test_bodies_and_joints_are_named_once(leg: planarc.Result) -> None:
    scene = make_scene(leg.rows)
    names = [tag.labels[0] for tag in tags(scene)]
    assert len(names) == len(set(names))
    assert {"crank", "shin", "heel", "hip", "ankle"} <= set(names)
    assert not any(name.endswith((".shape", ".pin", ".bar")) for name in names)


@pytest.mark.parametrize("width", [320, 640, 1280])
def test_names_never_overlap_while_the_mechanism_moves(leg: planarc.Result, width: int) -> None:
    scene, _ = with_layers(make_scene(leg.rows), (), ["names"])
    camera = fit_camera(scene.box, width, 46)
    motion = place_tags(sample_motion(scene, When(rate=10)), camera, 46)
    shown = [item for item in motion.items if item.shape == "tag"]
    assert len(shown) > (10 if width > 400 else 3)
    assert width > 640 or any(len(item.points) == 2 for item in shown)  # with a line
    for frame in range(len(motion.times)):
        boxes = []
        for tag in shown:
            item = item_at(tag, frame)
            *lines, label = marks_of(item, 1 / camera.scale)
            assert isinstance(label, Label)
            assert all(isinstance(line, Outline) for line in lines)
            x, y = camera(item.x + label.x, item.y + label.y)  # type: ignore[arg-type]
            half = 6.6 * len(label.text) / 2
            assert 0 < x - half < x + half < camera.width
            assert 0 < y < camera.height - 46
            boxes.append((x - half, x + half, y - 7, y + 7))
        for i, (a, b, c, d) in enumerate(boxes):
            assert not any(a < f and e < b and c < h and g < d for e, f, g, h in boxes[i + 1 :]), (
                f"frame {frame}"
            )
