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
    share: float = 1.0  # of the way from the origin to the end


def tie(items: Sequence[Item], links: Mapping[int, Vector], size: float) -> tuple[Tie, ...]:
    """How items hang on links. `links` are rows of x, y and angle at the same instants."""
    seen = [_seen(item, links) for item in items]
    same = _SAME * size
    origins = [_anchor(x, y, angle, links, same) for x, y, angle, *_ in seen]
    owners = [item.component.rpartition(".")[0] for item in items]
    found = []
    for item, rows, origin, owner in zip(items, seen, origins, owners, strict=True):
        others = [
            (at, x, y)
            for (x, y, *_), at, other in zip(seen, origins, owners, strict=True)
            if at is not None and origin is not None and other == owner and at.link != origin.link
        ]
        found.append(_tied(item, rows, origin, links, same, others))
    return tuple(found)


def follow(ties: Sequence[Tie], links: Mapping[int, Pose]) -> list[tuple[float, ...]]:
    """x, y, angle, length and width of each item."""
    return [_posed(t, links) for t in ties]


def _seen(item: Item, links: Mapping[int, Vector]) -> list[Vector]:
    """x, y, angle, length and width of an item at the instants of the links, the last ones."""
    count = len(next(iter(links.values()))[0])
    tracks = (np.atleast_1d(t) for t in (item.x, item.y, item.angle, item.length, item.width))
    return [t[-count:] if len(t) > 1 else np.full(count, t[0], dtype=float) for t in tracks]


def _tied(
    item: Item,
    rows: Sequence[Vector],
    origin: Anchor | None,
    links: Mapping[int, Vector],
    same: float,
    others: Sequence[tuple[Anchor, Vector, Vector]],
) -> Tie:
    """An item on the links; `others` are points of its component that it may aim at."""
    x, y, angle, length, width = rows
    end, share = None, 1.0
    turns = origin is not None and origin.turn is None and not item.upright
    if turns or np.ptp(length) > same:
        u, v = length * np.cos(angle), length * np.sin(angle)
        end = _anchor(x + u, y + v, None, links, same)
        for at, a, b in others if end is None else ():
            way = np.hypot(a - x, b - y)
            part = abs(float(length[-1] / way[-1])) if way[-1] else 0.0
            if np.max(np.hypot(u - part * (a - x), v - part * (b - y))) <= same:
                end, share = at, part
                break
        origin = origin if end is not None else None
    return Tie(origin, end, float(angle[-1]), float(length[-1]), float(width[-1]), share)


def _anchor(
    x: Vector, y: Vector, angle: Vector | None, links: Mapping[int, Vector], same: float
) -> Anchor | None:
    """The link in which a point stands still, best with the angle standing still, too."""
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
    length = t.share * math.hypot(a - x, b - y)
    if t.length < 0:  # it is drawn backwards
        return x, y, math.atan2(y - b, x - a), -abs(length), t.width
    return x, y, math.atan2(b - y, a - x), length, t.width
