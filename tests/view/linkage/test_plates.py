"""Plates hold all points of their group, are convex, and round by half their width."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.view.item import Item, Kind
from planarc.view.linkage.plates import hull
from planarc.view.marks.draw import marks_of
from planarc.view.marks.marks import Disc, Outline
from planarc.view.marks.shapes import shape_of
from planarc.view.scene import make_scene


def turns(corners: tuple[tuple[float, float], ...]) -> list[float]:
    """The cross products of successive sides."""
    n = len(corners)
    sides = [np.subtract(corners[(i + 1) % n], corners[i]) for i in range(n)]
    return [
        float(a[0] * b[1] - a[1] * b[0]) for a, b in zip(sides, sides[1:] + sides[:1], strict=True)
    ]


@pytest.mark.parametrize("seed", range(20))
def test_a_hull_is_convex_and_holds_all_points(seed: int) -> None:
    points = [tuple(p) for p in np.random.default_rng(seed).normal(size=(3 + seed, 2))]
    corners = hull(points)
    assert set(corners) <= set(points)
    assert all(t > 0 for t in turns(corners))
    for x, y in points:
        for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1], strict=True):
            assert (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= -1e-12


@pytest.mark.parametrize("count", range(4))
def test_points_on_a_line_are_a_bar(count: int) -> None:
    line = [(0.1 * i, 0.2 * i) for i in range(count)]
    assert len(hull(line, 1e-9)) == min(count, 2)
    assert len(hull([*line, (1e-17, -1e-17)], 1e-9)) == min(max(count, 1), 2)


@pytest.mark.parametrize(
    "corners", [((0.0, 0.0), (2.0, 0.0)), ((0.0, 0.0), (2.0, 0.0), (1.0, 1.0))]
)
def test_the_rim_runs_half_a_width_outside(corners: tuple[tuple[float, float], ...]) -> None:
    item = Item(
        "a", Kind.SHAPE, 0.0, 0.0, 0.0, 2.0, 0.4, (1.0, 2.0, 3.0), shape="plate", upright=True,
        points=corners,
    )  # fmt: skip
    (rim,) = marks_of(item, 1e-3)
    assert isinstance(rim, Outline)
    sides = list(zip(corners, corners[1:] + corners[:1], strict=True))
    for p in rim.points:
        assert min(distance(p, a, b) for a, b in sides) == pytest.approx(0.2, abs=2e-3)


def distance(p: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    d = np.subtract(b, a)
    share = min(1.0, max(0.0, float(np.dot(np.subtract(p, a), d) / np.dot(d, d))))
    return math.dist(p, tuple(np.add(a, share * d)))


def test_a_single_point_is_a_disc() -> None:
    item = Item(
        "a", Kind.SHAPE, 0.0, 0.0, 0.0, 0.0, 0.4, (1.0, 2.0, 3.0), shape="plate", upright=True,
        points=((0.3, 0.1),),
    )  # fmt: skip
    (disc,) = marks_of(item, 1e-3)
    assert isinstance(disc, Disc)
    assert (disc.x, disc.y, disc.radius) == (0.3, 0.1, 0.2)


def test_runs_from_other_starts_share_the_shapes_of_links() -> None:
    model = planarc.load(Path(__file__).parents[3] / "examples" / "four_bar.pmo")
    first, second = (
        [shape_of(i) for i in make_scene(model.simulate(0.1, start={"revA.phi": phi}).rows).items]
        for phi in (1.0, 1.1)
    )
    assert first == second
