"""Names of bodies and joints in a picture, which never overlap.

In:   Scene          its items, each a point that a name belongs to
Out:  tags           items at these points, each with a name
      Motion         with each tag's name beside its point, farther ones with a line to it

A name keeps its place beside its point as long as the picture lasts. What has no room at all
instants is left out.

Example: a hinge whose name stands 9 pixels to the right of it and 12 above

    Item(shape="tag", labels=("revB",), points=((31.0, 12.0),))
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from msgspec.structs import replace

from planarc.core.arrays import Vector, spread
from planarc.view.item import Item, Kind, plain
from planarc.view.linkage.palette import JOINT
from planarc.view.picture.camera import Camera
from planarc.view.picture.motion import Motion, item_at
from planarc.view.scene import Scene

#: The layer of names, by the id that it has on a page.
NAMES = "names"
#: Pixels from a point to its name, and the ways that lead there.
_RINGS = (12.0, 24.0, 42.0, 66.0, 96.0)
_WAYS = ((1, 1), (1, -1), (-1, 1), (-1, -1), (0, 1), (0, -1), (1, 0), (-1, 0))
#: Sizes in pixels: of a letter, of a line, of what stays free around a point.
_LETTER, _LINE, _POINT = 6.6, 15.0, 5.0
#: The longest name, in letters; the most names; the most instants that are looked at.
_LONGEST, _MOST, _INSTANTS = 28, 150, 60


def tags(scene: Scene) -> Iterator[Item]:
    """A tag for each body and joint, without its place in the picture."""
    named: dict[str, Item] = {}
    within: set[str] = set()
    for item in scene.items:
        name = item.component  # of a shape, that of what it is in
        while not item.parts and "." in name and name not in scene.classes:
            name = name.rpartition(".")[0]
        if name not in named and name not in within:
            named[name] = item
            within.update(item.parts)
    for name, item in named.items():
        u, v = np.mean(item.points, axis=0) if item.shape == "plate" and item.points else (0.0, 0.0)
        c, s = np.cos(item.angle), np.sin(item.angle)
        x, y = plain(item.x + c * u - s * v), plain(item.y + s * u + c * v)
        text = name if len(name) <= _LONGEST else f"{name[:14]}…{name[-13:]}"
        yield Item(
            name, Kind.SHAPE, x, y, 0.0, 0.0, 0.0, JOINT, 1e7, "tag", upright=True, labels=(text,)
        )


def place_tags(motion: Motion, camera: Camera, foot: float) -> Motion:
    """The motion with its tags where there is room, above `foot` pixels."""
    own = [item for item in motion.items if item.shape == "tag"][:_MOST]
    if not own:
        return motion
    frames = spread(len(motion.times), _INSTANTS).tolist()
    points = [np.array([_point(item_at(i, f), camera) for f in frames]) for i in own]
    taken = [_box(p, 0.0, 0.0, 2 * _POINT, 2 * _POINT) for p in points]
    room = float(camera.width), camera.height - foot
    others = [item for item in motion.items if item.shape != "tag"]
    placed = []
    for item, at in zip(own, points, strict=True):
        found = _place(item.labels[0], at, taken, room)
        if found is not None:
            placed.append(replace(item, points=found))
    return replace(motion, items=(*others, *placed))


def _point(item: Item, camera: Camera) -> tuple[float, float]:
    return camera(item.x, item.y)  # type: ignore[arg-type]


def _place(
    text: str, at: Vector, taken: list[Vector], room: tuple[float, float]
) -> tuple[tuple[float, float], ...] | None:
    """The middle of a name, from its point and upwards, and where the line to it ends."""
    wide, high = _LETTER * len(text), _LINE
    for ring in _RINGS:
        for a, b in _WAYS:
            x = a * ((0.75 * ring if b else ring) + wide / 2)
            y = b * ring
            box = _box(at, x, y, wide + 4, high + 2)
            inside = (box[:, :2] >= 2).all() and (box[:, 2:] <= np.subtract(room, 2)).all()
            if not inside or any(_overlap(box, other) for other in taken):
                continue
            taken.append(box)
            end = (x - a * wide / 2, y - b * high / 2)
            return ((x, y),) if ring == _RINGS[0] else ((x, y), end)
    return None


def _box(at: Vector, x: float, y: float, wide: float, high: float) -> Vector:
    """Left, top, right, bottom at each instant; `y` is upwards, as nowhere else in pixels."""
    middle = at + np.array([x, -y])
    half = np.array([wide / 2, high / 2])
    return np.hstack([middle - half, middle + half])


def _overlap(one: Vector, other: Vector) -> bool:
    low, high = np.maximum(one[:, :2], other[:, :2]), np.minimum(one[:, 2:], other[:, 2:])
    return bool((low < high).all(axis=1).any())
