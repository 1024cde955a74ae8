"""Items of a scene that follow the links of a mechanism.

In:   items over a few positions, and the poses of the links there
Out:  for other poses of the links those of the items, in no time

An item that keeps its place and angle in a link moves with it; one that begins at one link and
ends at another, as a spring does, is stretched between them. Of any other the place is unknown.

Example: the pin of a pendulum stays in the ground, its bar and mark follow the only link.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.view.item import Item

#: Place and angle of a link, or of an item: at an instant, or over some.
Pose = tuple[float, float, float]
#: How far a place may be off, as a share of the size of all, and an angle (rad).
_SAME = 1e-6
_NOWHERE = (math.nan, math.nan, math.nan, math.nan, math.nan)


class Anchor(Data):
    """A point that stands still in a link; `turn` is the angle there, None where it changes."""

    link: int
    u: float
    v: float
    turn: float | None


class Tie(Data):
    """An item with its origin, and its end where it is stretched; the rest as it was."""

    origin: Anchor | None
    end: Anchor | None
    angle: float
    length: float
    width: float


def tie(items: Sequence[Item], links: Mapping[int, Vector], size: float) -> tuple[Tie, ...]:
    """How items hang on links. `links` are rows of x, y and angle at the same instants."""
    return tuple(_tied(item, links, _SAME * size) for item in items)


def follow(ties: Sequence[Tie], links: Mapping[int, Pose]) -> list[tuple[float, ...]]:
    """x, y, angle, length and width of each item."""
    return [_posed(t, links) for t in ties]


def _tied(item: Item, links: Mapping[int, Vector], same: float) -> Tie:
    count = len(next(iter(links.values()))[0])
    x, y, angle, length, width = (
        np.broadcast_to(np.asarray(t, dtype=float), (count,) if np.ndim(t) == 0 else np.shape(t))[
            -count:
        ]
        for t in (item.x, item.y, item.angle, item.length, item.width)
    )
    origin = _anchor(x, y, angle, links, same)
    end = None
    turns = origin is not None and origin.turn is None and not item.upright
    if turns or np.ptp(length) > same:
        tip = x + length * np.cos(angle), y + length * np.sin(angle)
        end = _anchor(*tip, None, links, same)
        origin = origin if end is not None else None
    return Tie(origin, end, float(angle[-1]), float(length[-1]), float(width[-1]))


def _anchor(
    x: Vector, y: Vector, angle: Vector | None, links: Mapping[int, Vector], same: float
) -> Anchor | None:
    """Where a point stands still, best with the angle standing still, too."""
    found = None
    for number, (a, b, phi) in links.items():
        c, s = np.cos(phi), np.sin(phi)
        u, v = c * (x - a) + s * (y - b), c * (y - b) - s * (x - a)
        if not (np.ptp(u) <= same and np.ptp(v) <= same):
            continue
        if angle is None:
            return Anchor(number, float(u[-1]), float(v[-1]), None)
        off = np.exp(1j * (angle - phi))
        if np.max(np.abs(off - off[-1])) <= _SAME:
            turn = math.remainder(float(angle[-1] - phi[-1]), 2 * math.pi)
            return Anchor(number, float(u[-1]), float(v[-1]), turn)
        found = found or Anchor(number, float(u[-1]), float(v[-1]), None)
    return found


def _place(anchor: Anchor, links: Mapping[int, Pose]) -> tuple[float, float]:
    x, y, phi = links[anchor.link]
    c, s = math.cos(phi), math.sin(phi)
    return x + c * anchor.u - s * anchor.v, y + s * anchor.u + c * anchor.v


def _posed(t: Tie, links: Mapping[int, Pose]) -> tuple[float, ...]:
    if t.origin is None:
        return _NOWHERE
    x, y = _place(t.origin, links)
    if t.end is None:
        turn = t.origin.turn
        angle = t.angle if turn is None else links[t.origin.link][2] + turn
        return x, y, angle, t.length, t.width
    a, b = _place(t.end, links)
    length = math.hypot(a - x, b - y)
    if t.length < 0:  # it is drawn backwards
        return x, y, math.atan2(y - b, x - a), -length, t.width
    return x, y, math.atan2(b - y, a - x), length, t.width
