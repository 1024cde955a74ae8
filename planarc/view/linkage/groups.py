"""Rigid groups of a mechanism with the points that their frames reach.

In:   Result with its mechanism
Out:  Groups   a Group for each link but the ground

The points of a group stand still in its axes, which are those of the first frame of a part. The
unit is the width of a link: small against most links, but seen in a picture of the whole motion.

Example: the coupler of a four-bar, 0.9 m long

    Group(name="coupler", points=((0, 0), (0.9, 0)), joints=((0, 0), (0.9, 0)), depth=2, ...)
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from planarc.core.data import Data
from planarc.evaluate.record import Number, cos, first, sin
from planarc.ir.insight import Track
from planarc.ir.mechanism import GROUND, Mechanism
from planarc.ir.result import Result
from planarc.view.item import plain, smooth
from planarc.view.linkage.palette import paint

#: The width of a link: over the size of the picture, at most and at least, and over short links.
_MOST, _LEAST, _SHORT = 1 / 30, 1 / 260, 0.14
#: Places that are closer than this share of the picture are one.
_SAME = 1e-6
#: The decimal digits of a place in a link, of the size of its pose.
_DIGITS = 10

Pose = tuple[Track, Track, Track]
Place = tuple[float, float]


class Group(Data):
    """A rigid group; `joints` are the points where joints and force elements take hold."""

    name: str
    x: Track
    y: Track
    angle: Track
    points: tuple[Place, ...]
    joints: tuple[Place, ...]
    depth: int  # joints from the ground
    color: tuple[float, float, float]


class Groups:
    """The groups of a mechanism by number, and what belongs to them."""

    def __init__(
        self,
        groups: Mapping[int, Group],
        poses: Mapping[str, Pose],
        links: Mapping[str, int],
        size: float,
        passive: frozenset[str] = frozenset(),
    ) -> None:
        self.all = groups
        self.size = size
        self.passive = passive  # joints that nothing drives, though they have flanges
        self._poses, self._links = poses, links
        self._frames: dict[str, list[str]] = {}
        for frame in poses:
            self._frames.setdefault(frame.rpartition(".")[0], []).append(frame)

    def unit(self, size: float) -> float:
        """The width of a link in a picture of some size, which may show more than the groups."""
        return _unit(max(size, self.size), [reach(g.points) for g in self.all.values()])

    def of(self, component: str) -> int | None:
        """The number of the link that a part of `component` moves with, if it is one only."""
        numbers = {self._links[frame] for frame in self._near(component)}
        return numbers.pop() if len(numbers) == 1 else None

    def is_spread(self, component: str) -> bool:
        """True for what has frames in several links: joints and force elements."""
        return len({self._links[frame] for frame in self._near(component)}) > 1

    def at(self, component: str, x: Track, y: Track, angle: Track | None = None) -> int | None:
        """The link, among those that hold a frame of the component, with one at (x, y).

        With `angle` the frame also turns as it does.
        """
        for frame in self._here(component, x, y):
            off = np.atleast_1d(0.0 if angle is None else angle - self._poses[frame][2])
            if np.ptp(off) <= _SAME:
                return self._links[frame]
        return None

    def deepest(self, component: str, x: Track, y: Track) -> int:
        """The depth of the farthest link, among those with a frame of the component at (x, y)."""
        numbers = (self._links[frame] for frame in self._here(component, x, y))
        return max((self.all[n].depth for n in numbers if n in self.all), default=0)

    def places(self, frames: Iterable[str]) -> Iterator[tuple[Track, Track, int]]:
        """The positions of frames, with the depths of their links."""
        for frame in frames:
            if frame in self._poses:
                x, y, _ = self._poses[frame]
                group = self.all.get(self._links[frame])
                yield x, y, group.depth if group else 0

    def grounds(self) -> Iterator[tuple[str, float, float]]:
        """Components and places in the ground where joints or force elements take hold."""
        for frame, number in self._links.items():
            owner = frame.rpartition(".")[0]
            if number == GROUND and len({self._links[f] for f in self._frames[owner]}) > 1:
                x, y, _ = self._poses[frame]
                yield owner, first(x), first(y)

    def corners(self) -> Iterator[Place]:
        """The points of all groups in the world, as they start."""
        for group in self.all.values():
            x, y, angle = map(first, (group.x, group.y, group.angle))
            c, s = cos(angle), sin(angle)
            for u, v in group.points:
                yield x + c * u - s * v, y + s * u + c * v

    def _here(self, component: str, x: Track, y: Track) -> Iterator[str]:
        for frame in self._near(component):
            fx, fy, _ = self._poses[frame]
            if np.all(np.hypot(fx - x, fy - y) <= _SAME * self.size):
                yield frame

    def _near(self, component: str) -> list[str]:
        """Frames of the innermost component with frames that a name is part of."""
        name = component
        while name and name not in self._frames:
            name = name.rpartition(".")[0]
        return self._frames.get(name, [])


def find_groups(result: Result) -> Groups | None:
    """The rigid groups; None where the result holds no positions of frames."""
    mechanism = result.program.mechanism
    if mechanism is None or not len(result.time):
        return None
    poses = {
        frame: _pose(result, frame)
        for link in mechanism.links
        for frame in link.frames
        if all(f"{frame}.{v}" in result for v in ("r[1]", "r[2]", "phi"))
    }
    if not poses:
        return None
    links = {f: i for i, link in enumerate(mechanism.links) for f in link.frames if f in poses}
    size = _extent(poses.values())
    depths, near = _depths(mechanism)
    numbers = sorted(set(links.values()) - {GROUND}, key=lambda i: (depths.get(i, 1), i))
    colors = paint(numbers, near)
    owners: dict[str, set[int]] = {}
    for frame, number in links.items():
        owners.setdefault(frame.rpartition(".")[0], set()).add(number)
    holding = {f for f in links if len(owners[f.rpartition(".")[0]]) > 1}
    groups = {}
    for i in numbers:
        link = mechanism.links[i]
        frames = [f for f in link.frames if f in poses]
        axes = _still(poses[min(frames, key=lambda f: f in holding)])
        points = {f: place for f in frames if (place := _seen(axes, poses[f])) is not None}
        groups[i] = Group(
            link.name, *axes, _distinct(points.values(), size),
            _distinct((p for f, p in points.items() if f in holding), size),
            depths.get(i, 1), colors[i],
        )  # fmt: skip
    return Groups(groups, poses, links, size, frozenset(mechanism.passive))


def local(group: Group, x: Track, y: Track) -> Place | None:
    """A point of the world in the axes of a group, where both are known; None if never."""
    return _seen((group.x, group.y, group.angle), (x, y, 0.0))


def _pose(result: Result, frame: str) -> Pose:
    x, y, phi = (result.track(f"{frame}.{v}") for v in ("r[1]", "r[2]", "phi"))
    return plain(x), plain(y), smooth(phi)


def _still(pose: Pose) -> Pose:
    """A pose whose angle is known; one that nothing asks for is 0."""
    x, y, angle = pose
    return x, y, angle if np.all(np.isfinite(angle)) else plain(np.nan_to_num(angle))


def _seen(axes: Pose, pose: Pose) -> Place | None:
    """The place of a pose in some axes, at the first row where all is known."""
    tracks = (*axes, *pose[:2])
    x, y, phi, u, v = map(first, tracks)
    if not math.isfinite(x + y + phi + u + v):
        rows = np.broadcast_arrays(*map(np.atleast_1d, tracks))
        known = np.flatnonzero(np.isfinite(sum(rows)))
        if not known.size:
            return None
        x, y, phi, u, v = (float(row[known[0]]) for row in rows)
    c, s, dx, dy = cos(phi), sin(phi), u - x, v - y
    digits = _DIGITS - math.frexp(max(map(abs, map(float, (x, y, u, v)))))[1] * 3 // 10
    return _rounded(c * dx + s * dy, digits), _rounded(c * dy - s * dx, digits)


def _rounded(value: float, digits: int) -> float:
    """A number without the round-off of its pose: runs from other starts share a shape."""
    return value if isinstance(value, Number) else round(value, digits) + 0.0


def _distinct(places: Iterable[Place], size: float) -> tuple[Place, ...]:
    """The places without those that are as good as the same."""
    found: list[Place] = []
    for x, y in places:
        if not any(np.hypot(x - a, y - b) <= _SAME * size for a, b in found):
            found.append((x, y))
    return tuple(found)


def _depths(mechanism: Mechanism) -> tuple[dict[int, int], dict[int, set[int]]]:
    """The joints between each link and the ground, along the shortest way, and neighbours."""
    near: dict[int, set[int]] = {}
    for joint in mechanism.joints:
        for link in joint.links:
            near.setdefault(link, set()).update(set(joint.links) - {link})
    depths, queue = {GROUND: 0}, deque([GROUND])
    while queue:
        link = queue.popleft()
        for other in sorted(near.get(link, ())):
            if other not in depths:
                depths[other] = depths[link] + 1
                queue.append(other)
    return depths, near


def reach(points: Iterable[Place]) -> float:
    """The diagonal of the box around points."""
    places = np.array(tuple(points) or ((0.0, 0.0),))
    return float(np.hypot(*np.ptp(places, axis=0)))


def _extent(poses: Iterable[Pose]) -> float:
    """The larger side of the box around all frames at all times; 1 for a point."""
    spans = []
    for axis in (0, 1):
        values = np.concatenate([np.atleast_1d(p[axis]) for p in poses])
        values = values[np.isfinite(values)]
        spans.append(float(np.ptp(values)) if values.size else 0.0)
    largest = max(spans)
    return largest if largest > 0 and np.isfinite(largest) else 1.0


def _unit(size: float, spans: Iterable[float]) -> float:
    """The width of a link."""
    long = sorted(s for s in spans if s > _LEAST * size)
    short = long[len(long) // 4] if long else size
    return max(min(_MOST * size, _SHORT * short), _LEAST * size)
