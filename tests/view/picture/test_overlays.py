"""Layers of the report in pictures: arrows where the vectors are, in one scale, and paths."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc import Result, UsageError
from planarc.stages import study
from planarc.view.item import Kind
from planarc.view.picture.overlays import with_layers
from planarc.view.scene import make_scene

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def result() -> Result:
    return planarc.load(EXAMPLES / "pendulum.pmo").simulate(2, intervals=200)


def test_velocities_are_arrows_of_one_scale(result: Result) -> None:
    layers = study(result.rows).layers
    scene = make_scene(result.rows)
    drawn, (key,) = with_layers(scene, layers, ["velocities"])
    arrows = drawn.items[len(scene.items) :]
    (layer,) = (layer for layer in layers if layer.id == "velocities")
    assert len(arrows) == len(layer.members) > 0
    scales = []
    for arrow, mark in zip(arrows, layer.members, strict=True):
        speed = np.hypot(mark.u, mark.v)
        assert np.allclose(arrow.length * np.cos(arrow.angle) * speed, mark.u * arrow.length)
        scales.append(np.max(np.atleast_1d(arrow.length)) / np.max(speed))
    assert np.ptp(scales) < 1e-12
    assert scene.box is not None and drawn.box is not None
    span = max(scene.box[2] - scene.box[0], scene.box[3] - scene.box[1])
    longest = max(float(np.max(a.length)) for a in arrows)
    value = float(key.text.partition(" ")[0])
    assert key.length == pytest.approx(value * scales[0])
    assert 0.2 * longest < key.length <= 0.5 * longest
    assert longest == pytest.approx(0.28 * span)
    assert drawn.box[2] - drawn.box[0] >= scene.box[2] - scene.box[0]


def test_paths_lie_below_and_vectors_above(result: Result) -> None:
    layers = study(result.rows).layers
    drawn, keys = with_layers(make_scene(result.rows), layers, ["forces", "paths", "forces"])
    assert [key.text.rpartition(" ")[2] for key in keys] == ["N"]
    kinds = [item.kind for item in drawn.items]
    assert kinds[0] is Kind.CURVE
    assert kinds[-1] is Kind.ARROW
    scene = make_scene(result.rows)
    assert with_layers(scene, layers, []) == (scene, ())


@pytest.mark.parametrize("suffix", [".svg", ".png"])
def test_pictures_take_layers(result: Result, suffix: str, tmp_path: Path) -> None:
    if suffix == ".png":
        pytest.importorskip("PIL")
    plain = result.animate(tmp_path / f"plain{suffix}", at=0.5)
    drawn = result.animate(tmp_path / f"drawn{suffix}", at=0.5, layers=["forces", "velocities"])
    assert plain.read_bytes() != drawn.read_bytes()
    with pytest.raises(UsageError, match="did you mean `forces`"):
        result.animate(tmp_path / f"wrong{suffix}", layers=["force"])


def test_masses_are_discs_under_the_mechanism_by_area() -> None:
    result = planarc.load(EXAMPLES / "four_bar.pmo").simulate(0.1)
    scene = make_scene(result.rows)
    drawn, keys = with_layers(scene, study(result.rows).layers, ["masses"])
    discs = drawn.items[: len(drawn.items) - len(scene.items)]
    assert [d.component for d in discs] == ["crankBody", "couplerBody", "rockerBody"]
    areas = [float(d.width) ** 2 for d in discs]  # type: ignore[arg-type]
    assert np.allclose(np.array(areas) / areas[0], [1, 2, 1.5])
    assert drawn.items[len(discs) :] == scene.items
    assert keys == ()


def test_forces_of_components_and_joints_share_one_scale_and_key() -> None:
    result = planarc.load("PlanarMultiBody.Examples.Systems.QuickReturn").simulate(2)
    scene = make_scene(result.rows)
    (own,) = scene.scales
    _, (key,) = with_layers(scene, (), [])
    assert key.text == "100 N"
    assert key.length == pytest.approx(100 * own.metres)
    drawn, (key,) = with_layers(scene, study(result.rows).layers, ["forces"])
    metres = key.length / float(key.text.partition(" ")[0])
    arrow = next(i for i in drawn.items if i.component == own.owners[0] and i.kind is Kind.ARROW)
    said = next(i for i in scene.items if i.component == own.owners[0] and i.kind is Kind.ARROW)
    assert np.allclose(arrow.length / metres, said.length / own.metres)
