"""The scene at the instants of the frames.

In:   Scene, when      rows of a result; which part of its time, how fast it is shown
Out:  Motion           the same items, their moving quantities at each frame

Frames are equally far apart in time; between rows of the result values run straight.

Example: 2 s shown at 25 frames a second and at half speed

    Motion(times=array([0, 0.02, ..., 2]), shown=4.0)        # 101 frames in 4 s
"""

from __future__ import annotations

import math

import numpy as np

from planarc.core.arrays import Vector
from planarc.core.data import Data
from planarc.core.diagnostic import usage_error
from planarc.ir.insight import Track
from planarc.view.item import Item
from planarc.view.scene import Scene

#: The shortest and the longest motion (s) shown at its own pace: longer runs are shown faster,
#: shorter ones slower, by 2, 5, 10 ...
_SHORTEST, _LONGEST = 2.0, 12.0
#: The most frames: a file of more is one that nobody waits for.
_MOST_FRAMES = 20_000


class When(Data):
    """The shown part of a run. Times in s of the run; None: from its start, to its end.

    `speed` is seconds of the run in a second of the picture, None chooses it.
    """

    begin: float | None = None
    end: float | None = None
    speed: float | None = None
    rate: float = 25.0  # frames a second


class Motion(Data):
    """Items whose tracks have one value for each of `times`; `shown` is how long, in s."""

    times: Vector
    items: tuple[Item, ...]
    shown: float

    def at(self, frame: int) -> tuple[Item, ...]:
        """The items of one frame, all their quantities numbers."""
        return tuple(item_at(item, frame) for item in self.items)


def sample_motion(scene: Scene, when: When) -> Motion:
    """The scene at the instants of frames. Raises UsageError V703 for times that are not in the
    run, and V707 for too many frames."""
    begin, end = _span(scene, when)
    speed = when.speed or choose_speed(end - begin)
    shown = (end - begin) / speed
    count = max(1, round(shown * when.rate))
    if count > _MOST_FRAMES:
        raise usage_error(
            "V707",
            f"this makes {count} frames, more than {_MOST_FRAMES}",
            hint="show it faster with `--speed`, or a part with `--from` and `--to`",
        )
    return resample(scene, np.linspace(begin, end, count + 1) if shown else [begin], shown)


def still(scene: Scene, time: float) -> Motion:
    """The one frame at a time of the run."""
    _span(scene, When(time, time))
    return resample(scene, [time], 0.0)


def resample(scene: Scene, times: object, shown: float) -> Motion:
    """The scene at any times."""
    instants = np.asarray(times, dtype=float)
    known: dict[int, Track] = {}

    def at(track: Track) -> Track:
        if isinstance(track, (int, float)):
            return track
        if id(track) not in known:
            known[id(track)] = np.interp(instants, scene.time, track)
        return known[id(track)]

    return Motion(instants, tuple(item.mapped(at) for item in scene.items), shown)


def thinned(motion: Motion, step: int) -> Motion:
    """Every `step`-th frame of a motion."""

    def at(track: Track) -> Track:
        return track if isinstance(track, (int, float)) else track[::step]

    items = tuple(item.mapped(at) for item in motion.items)
    return Motion(motion.times[::step], items, motion.shown)


def item_at(item: Item, frame: int) -> Item:
    return item.mapped(lambda t: float(t if isinstance(t, (int, float)) else t[frame]))


def choose_speed(duration: float) -> float:
    """The pace: 1 where the run can be watched as it is, else 1, 2 or 5 times a power of ten."""
    if not duration or _SHORTEST <= duration <= _LONGEST:
        return 1.0
    wanted = duration / (_LONGEST if duration > _LONGEST else 2 * _SHORTEST)
    power = 10.0 ** math.floor(math.log10(wanted) + 1e-9)
    up = duration > _LONGEST
    steps = [f * power for f in (1.0, 2.0, 5.0, 10.0)]
    if up:
        return next((s for s in steps if s >= wanted * (1 - 1e-9)), steps[-1])
    return next((s for s in reversed(steps) if s <= wanted * (1 + 1e-9)), steps[0])


def _span(scene: Scene, when: When) -> tuple[float, float]:
    first, last = float(scene.time[0]), float(scene.time[-1])
    begin = first if when.begin is None else when.begin
    end = last if when.end is None else when.end
    slack = 1e-9 * max(1.0, abs(first), abs(last))
    for time in (begin, end):
        if not first - slack <= time <= last + slack:
            raise usage_error(
                "V703",
                f"t = {time:g} s is not in the run, which lasts from {first:g} to {last:g} s",
                hint="choose a time in it, or simulate for longer with `--stop`",
            )
    if begin > end:
        raise usage_error(
            "V703", f"the picture ends, at {end:g} s, before it begins, at {begin:g} s"
        )
    return begin, end


def thin_polyline(times: Vector, values: Vector, tolerance: float) -> list[int]:
    """Rows, ascending with both ends, from which straight lines give all others.

    `values` has a row for each of `times`; no row is farther than `tolerance` from the line
    between its neighbours that are kept, at its own time.

    Reference: D. H. Douglas, T. K. Peucker, Cartographica 10(2), 1973, 112-122; here the
    distance is taken at equal time, since a picture runs through its points by time.
    """
    keep = {0, len(times) - 1}
    stack = [(0, len(times) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        share = ((times[a + 1 : b] - times[a]) / (times[b] - times[a]))[:, None]
        straight = values[a] + share * (values[b] - values[a])
        off = np.linalg.norm(values[a + 1 : b] - straight, axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = a + 1 + worst
            keep.add(middle)
            stack += [(a, middle), (middle, b)]
    return sorted(keep)
