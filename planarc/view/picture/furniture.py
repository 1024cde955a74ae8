"""What stands at the foot of a picture: axes and gravity, a scale, the time, keys of arrows.

In:   Motion, Camera, Scene, keys
Out:  Motion with more items, which are measured in pixels

A moving picture shows the time in steps, each a text that is there for a while: a `.svg` cannot
change a text.

Example: a picture 640 pixels wide of a four-bar

    x-y axes and g | 20 cm | 5 N, forces | t = 1.2 s
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.ir.insight import Track
from planarc.view.item import Item, Kind
from planarc.view.linkage.palette import JOINT
from planarc.view.picture.camera import Camera
from planarc.view.picture.motion import Motion
from planarc.view.scene import Scene

#: The height that the furniture takes, and the least width of a picture that has it.
FOOT, NARROW = 46, 260
#: About the length of the scale, and the pixels a letter takes.
_SCALE, _LETTER = 84.0, 7.0
#: The most texts of a moving time.
_TIMES = 50
_FOOT_Y = 15.0  # of the lowest lines, above the edge


class Key(Data):
    """The length of an arrow that stands for a round value."""

    text: str
    length: float  # m
    color: tuple[Track, Track, Track]


def furnish(motion: Motion, camera: Camera, scene: Scene, keys: Sequence[Key] = ()) -> Motion:
    """The motion with its furniture; a narrow picture has none."""
    if camera.width < NARROW:
        return motion
    items = [*_low(camera, scene, keys), *_clock(motion, camera)]
    return replace(motion, items=(*motion.items, *items))


def _low(camera: Camera, scene: Scene, keys: Sequence[Key]) -> Iterator[Item]:
    """The lower edge from the left: axes, scale, keys; as many keys as there is room for."""
    x, right = 18.0, camera.width - 90.0
    if scene.corner is not None:
        yield _at(camera, x, scene.corner)
        x += 78.0
    step = round_125(_SCALE / camera.scale)
    yield _at(camera, x, _ruler(step))
    x += step * camera.scale + 24.0
    for key in keys:
        wide = key.length * camera.scale
        end = x + wide + 8.0 + _LETTER * len(key.text)
        if end > right:
            return
        arrow = Item(key.text, Kind.ARROW, 0.0, 0.0, 0.0, key.length, 2.2 / camera.scale, key.color)
        yield _at(camera, x, arrow)
        middle = (x + wide + 8.0 + end) / 2
        yield _at(camera, middle, _note(key.text))
        x = end + 20.0


def _ruler(step: float) -> Item:
    return Item(
        "scale", Kind.SHAPE, 0.0, 0.0, 0.0, step, 0.0, JOINT, shape="ruler", upright=True,
        labels=(length_text(step),),
    )  # fmt: skip


def _note(text: str) -> Item:
    return Item(
        "note", Kind.SHAPE, 0.0, 0.0, 0.0, 0.0, 0.0, JOINT, shape="note", upright=True,
        labels=(text,),
    )  # fmt: skip


def _clock(motion: Motion, camera: Camera) -> Iterator[Item]:
    """The time at the right: one text, or one for each step."""
    first, last = float(motion.times[0]), float(motion.times[-1])
    step = round_125((last - first) / _TIMES, up=True) if last > first else 0.0
    digits = max(0, -math.floor(math.log10(step) + 1e-9)) if step else None
    told = [_time_text(t, step, digits) for t in motion.times]
    for text in dict.fromkeys(told):
        item = _at(camera, camera.width - 16.0 - _LETTER / 2 * len(text), _note(text))
        if len(motion.times) > 1:
            here = np.array([t == text for t in told])
            item = replace(item, x=np.where(here, item.x, np.nan))
        yield item


def _time_text(time: float, step: float, digits: int | None) -> str:
    if digits is None:
        return f"t = {time:.4g} s"
    return f"t = {math.floor(time / step + 1e-9) * step:.{digits}f} s"


def _at(camera: Camera, x: float, item: Item) -> Item:
    """The item at a place at the foot of the picture, in pixels from the left."""
    wx, wy = camera.back(x, camera.height - _FOOT_Y)
    return replace(item, x=wx, y=wy)


def round_125(value: float, up: bool = False) -> float:
    """The nearest of 1, 2, 5 times a power of ten that is not larger; `up`: not smaller."""
    if not (value > 0 and math.isfinite(value)):
        return 0.0
    power = 10.0 ** math.floor(math.log10(value))
    steps = [f * power for f in (1.0, 2.0, 5.0, 10.0)]
    if up:
        return next((s for s in steps if s >= value * (1 - 1e-9)), steps[-1])
    return next(s for s in reversed(steps) if s <= value * (1 + 1e-9))


def length_text(metres: float) -> str:
    """A length as people say it: 5 cm, 200 mm, 2 km."""
    units = ((1e3, "km"), (1.0, "m"), (1e-2, "cm"), (1e-3, "mm"), (1e-6, "µm"))
    size, unit = next((u for u in units if metres >= u[0] * (1 - 1e-9)), (1e-9, "nm"))
    return f"{metres / size:.3g} {unit}"
