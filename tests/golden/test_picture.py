"""The picture of the README is drawn from a run of examples/four_bar.pmo.

`pytest --update-golden` draws it again: the mechanism at the start, some later poses
behind it, and the path of the coupler's centre of mass.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import cos, sin
from pathlib import Path
from typing import Any

import pytest

from planarc.compiler import simulate
from planarc.core.options import RunOptions
from planarc.view.scene import Item, Kind, Scene, make_scene

EXAMPLES = Path(__file__).parents[2] / "examples"
PICTURE = EXAMPLES / "four_bar.svg"
STOP = 2.0  # s, enough for the path to close
POSES = ((240, 0.12), (160, 0.2), (80, 0.35), (0, 1.0))  # row, opacity; the last one in front
SCALE = 300.0  # pixels a metre
MARGIN = 0.06  # m


def at(track: Any, row: int) -> float:
    return float(track) if isinstance(track, (int, float)) else float(track[row])


def color(item: Item, row: int) -> str:
    return "#" + "".join(f"{round(at(c, row)):02x}" for c in item.color)


def shape(item: Item, row: int) -> str:
    """A solid: seen from its end a disc, else a bar with round ends."""
    x, y, angle, length, width = (
        at(track, row) for track in (item.x, item.y, item.angle, item.length, item.width)
    )
    paint = color(item, row)
    if item.upright:
        return f'<circle cx="{x:.4f}" cy="{y:.4f}" r="{width / 2:.4f}" fill="{paint}"/>'
    turn = f'transform="translate({x:.4f} {y:.4f}) rotate({angle * 57.29577951:.3f})"'
    place = f'x="{min(0.0, length):.4f}" y="{-width / 2:.4f}"'
    size = f'width="{abs(length):.4f}" height="{width:.4f}" rx="{width / 2:.4f}"'
    return f'<rect {place} {size} fill="{paint}" {turn}/>'


def solids(scene: Scene) -> list[Item]:
    return [i for i in scene.items if i.kind is Kind.SHAPE and i.shape != "ground"]


def box(scene: Scene) -> tuple[float, float, float, float]:
    """Left, bottom, right, top of what is drawn, with a margin."""
    xs, ys = [], []
    for item in solids(scene):
        for row, _ in POSES:
            x, y, angle, length = (at(v, row) for v in (item.x, item.y, item.angle, item.length))
            xs += [x, x + length * cos(angle)]
            ys += [y, y + length * sin(angle)]
    return min(xs) - MARGIN, min(ys) - MARGIN, max(xs) + MARGIN, max(ys) + MARGIN


def poses(scene: Scene) -> Iterator[str]:
    for row, opacity in POSES:
        yield f'<g opacity="{opacity}">'
        yield from (shape(item, row) for item in solids(scene))
        yield "</g>"


def draw() -> str:
    options = RunOptions(stop=STOP, intervals=500, tolerance=1e-8)
    result = simulate(EXAMPLES / "four_bar.pmo", options=options)
    scene = make_scene(result)
    left, bottom, right, top = box(scene)
    width, height = right - left, top - bottom
    xs, ys = result["couplerBody.r_0CM[1]"], result["couplerBody.r_0CM[2]"]
    path = " ".join(f"{x:.3f},{y:.3f}" for x, y in zip(xs[::4], ys[::4], strict=True))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width * SCALE:.0f}" '
        f'height="{height * SCALE:.0f}" '
        f'viewBox="{left:.4f} {-top:.4f} {width:.4f} {height:.4f}">',
        '<g transform="scale(1 -1)">',
        f'<polyline points="{path}" fill="none" stroke="#d64541" stroke-width="0.006"/>',
        *poses(scene),
        "</g>",
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def numbers(text: str) -> list[float]:
    return [float(n) for n in re.findall(r"-?\d+\.\d+", text)]


def test_the_picture_shows_what_the_model_does(request: pytest.FixtureRequest) -> None:
    drawn = draw()
    if request.config.getoption("--update-golden"):
        PICTURE.write_text(drawn, encoding="utf-8", newline="\n")
    stored = PICTURE.read_text("utf-8")
    mask = re.compile(r"-?\d+\.\d+")
    assert mask.sub("#", drawn) == mask.sub("#", stored)
    assert numbers(drawn) == pytest.approx(numbers(stored), abs=2e-3)
