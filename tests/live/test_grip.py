"""A dragged mechanism keeps its loops closed and comes as near to the pointer as it can."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pytest

import planarc
from planarc import Model
from planarc.core.options import RunOptions
from planarc.live.grip import Grip
from planarc.view.scene import make_scene

EXAMPLES = Path(__file__).parents[2] / "examples"


def gripped(
    model: Model, component: str, x: float, y: float, time: float = 0.0
) -> tuple[Grip, Any]:
    rows = model.simulate(1.0).rows
    grip = Grip(model, RunOptions(), rows, time)
    assert grip.take([component], x, y)
    return grip, rows


def at_start(model: Model, grip: Grip) -> Any:
    return model.simulate(0.0, start=grip.start())


def test_the_tip_of_a_pendulum_points_to_the_pointer() -> None:
    model = planarc.load("PlanarMultiBody.Examples.Elementary.Pendulum")
    rows = model.simulate(0.1).rows
    x, y = float(rows["bob.r_0CM[1]"][0]), float(rows["bob.r_0CM[2]"][0])
    grip, _ = gripped(model, "bob", x, y)
    for angle in np.linspace(0.0, 6.0, 40):
        assert grip.move(3 * np.cos(angle), 3 * np.sin(angle))
        (start,) = grip.start().values()
        result = at_start(model, grip)
        here = np.arctan2(result["bob.r_0CM[2]"][0], result["bob.r_0CM[1]"][0])
        assert np.cos(here - angle) == pytest.approx(1.0, abs=1e-6)
        assert np.isfinite(start)


def test_a_coupler_keeps_to_its_loop_and_comes_as_near_as_it_can() -> None:
    model = planarc.load(EXAMPLES / "four_bar.pmo")
    rows = model.simulate(1.0).rows
    place = [float(rows[f"couplerBody.r_0CM[{i}]"][0]) for i in (1, 2)]
    grip, rows = gripped(model, "couplerBody.centre", *place)
    for row in range(0, len(rows.time), 5):  # along its own curve it is where the pointer is
        x, y = (float(rows[f"couplerBody.r_0CM[{i}]"][row]) for i in (1, 2))
        assert grip.move(x, y)
    result = at_start(model, grip)
    assert result["couplerBody.r_0CM[1]"][0] == pytest.approx(x, abs=1e-5)
    assert result["couplerBody.r_0CM[2]"][0] == pytest.approx(y, abs=1e-5)
    assert grip.move(x + 5.0, y - 5.0)  # out of reach: the loop holds
    end = at_start(model, grip)
    length = np.hypot(
        *(end[f"revC.frame_b.r[{i}]"][0] - end[f"revB.frame_b.r[{i}]"][0] for i in (1, 2))
    )
    assert length == pytest.approx(0.9, abs=1e-8)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("Loops.AndrewsSqueezer", "OF"),
        ("Loops.CrankSlider", "crank"),
        ("Loops.PistonEngine", "crank"),
        ("Systems.QuickReturn", "lever"),
        ("CurveCurveJoint.CamFollower", "cam"),
    ],
)
def test_items_go_where_a_run_from_there_shows_them_and_soon(name: str, part: str) -> None:
    model = planarc.load(f"PlanarMultiBody.Examples.{name}")
    rows = model.simulate(0.05).rows
    grip = Grip(model, RunOptions(), rows, 0.0)
    x, y = (float(rows[f"{part}.frame_a.r[{i}]"][0]) for i in (1, 2))
    assert grip.take([part], x + 0.02, y + 0.01)
    seconds = []
    for i in range(10):
        begin = perf_counter()
        assert grip.move(x + 0.02 - 0.001 * i, y + 0.01 + 0.002 * i)
        poses = grip.poses()
        seconds.append(perf_counter() - begin)
    assert np.median(seconds) < 0.016
    shown = make_scene(at_start(model, grip).rows).items
    known = {(i.component, i.shape): i for i in shown}
    matched = 0
    for item, pose in zip(make_scene(rows).items, poses, strict=True):
        other = known.get((item.component, item.shape))
        if item.shape in ("pin", "mass", "motor") and other is not None:
            assert pose[:2] == pytest.approx(
                (float(np.ravel(other.x)[0]), float(np.ravel(other.y)[0])), abs=1e-6
            )
            matched += 1
    assert matched >= 2


def test_what_nobody_can_move_is_not_taken() -> None:
    model = planarc.load(EXAMPLES / "four_bar.pmo")
    rows = model.simulate(0.1).rows
    grip = Grip(model, RunOptions(), rows, 0.0)
    assert not grip.take(["groundA.shape"], 0.0, 0.0)
    assert not grip.take(["nowhere"], 0.0, 0.0)


def test_cylinders_stay_between_their_ends() -> None:
    model = planarc.load("PlanarMultiBody.Examples.Systems.Excavator")
    rows = model.simulate(0.1).rows
    grip = Grip(model, RunOptions(), rows, 0.0)
    x, y = (float(rows[f"bucket.frame_a.r[{i}]"][0]) for i in (1, 2))
    assert grip.take(["stick"], x, y)
    assert grip.move(x + 0.3, y + 0.5)
    poses = dict(zip([i.component for i in make_scene(rows).items], grip.poses(), strict=True))
    end = at_start(model, grip)
    for name, share in (("half_a", 0.6), ("half_b", 0.55)):
        length = poses[f"boomCylinder.{name}"][3]
        assert abs(length) == pytest.approx(share * end["boomCylinder.s"][0], rel=1e-6)
    a, b = (np.array([end[f"boomCylinder.frame_{f}.r[{i}]"][0] for i in (1, 2)]) for f in "ab")
    px, py, angle, length, _ = poses["boomCylinder.half_b"]
    assert (px, py) == pytest.approx(tuple(b), abs=1e-9)
    toward = np.array([np.cos(angle), np.sin(angle)]) * length
    assert toward == pytest.approx(0.55 * (a - b), abs=1e-6)
