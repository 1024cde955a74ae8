"""Slides: a block on a hatched guide, a block on a moving bar, or barrel and rod.

In:   item of the part `slide`: from frame_a along the axis, as long as the slide is out
Out:  items, and points by which the bars that carry blocks are longer

On the ground the guide is as long as the travel of the run. Of two moving groups the one that
is held at a single point is the block; where none or both are, the slide is a cylinder.

Example: a piston that goes from 0.8 m to 1.2 m in the ground

    guide    at 0.8 m less a margin, 0.4 m and two margins long, hatched
    block    at the end of the slide
"""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.evaluate.record import span
from planarc.ir.insight import Track
from planarc.ir.mechanism import GROUND
from planarc.view.item import Item, plain
from planarc.view.linkage.groups import Groups, Place, local
from planarc.view.linkage.palette import JOINT, Color
from planarc.view.marks.shapes import RAIL

#: Sizes in units: the block, the margin of its guide, barrel and rod.
_BLOCK, _MARGIN, _BARREL, _ROD = (2.8, 1.9), 2.0, 1.5, 0.55
#: Hatches of a guide a unit.
_HATCHES = 1.1
#: The barrel over the shortest slide, and what of it the rod fills at the longest.
_CASE, _INSIDE = 0.86, 0.25


class Slide(Data):
    """Drawn items, the number of the group that is the block, and more points of groups."""

    items: tuple[Item, ...]
    block: int | None = None
    more: tuple[tuple[int, Place], ...] = ()


def draw_slide(item: Item, groups: Groups | None, unit: float) -> Slide:
    """The picture of a slide."""
    low, high = _travel(item)
    if groups is None:
        return _on_guide(item, low, high, unit, JOINT, None, 1.0)
    a = groups.at(item.component, item.x, item.y)
    b = groups.at(item.component, *_end(item))
    if a in (None, GROUND):
        group = groups.all.get(b) if b is not None else None
        color = group.color if group else JOINT
        return _on_guide(item, low, high, unit, color, b, group.depth if group else 1.0)
    single_a, single_b = (_held_once(groups, n, unit) for n in (a, b))
    if single_a != single_b or low < 3 * unit or b == GROUND:
        on_b = single_a and not single_b and b != GROUND
        return _on_bar(item, groups, unit, b if on_b else a, a if on_b else b, (low, high), on_b)
    return _cylinder(item, groups, unit, a, b, (low, high))


def _on_guide(
    item: Item, low: float, high: float, unit: float, color: Color, block: int | None, depth: float
) -> Slide:
    margin = _MARGIN * unit
    length = high - low + 2 * margin
    x, y = _along(item, low - margin)
    guide = replace(
        item, shape="guide", x=x, y=y, length=length, width=_BLOCK[1] * unit / (2 * RAIL),
        height=-2.0, extra=float(max(3, min(60, round(_HATCHES * length / unit)))),
    )  # fmt: skip
    return Slide((guide, _block(item, *_end(item), unit, color, depth)), block)


def _on_bar(
    item: Item,
    groups: Groups,
    unit: float,
    bar: int | None,
    block: int | None,
    travel: tuple[float, float],
    backwards: bool,
) -> Slide:
    """A block on a bar that moves, whose travel makes the bar longer."""
    carrier = groups.all[bar]  # type: ignore[index]
    other = groups.all.get(block) if block is not None else None
    place = (item.x, item.y) if backwards else _end(item)
    ends = tuple(
        (bar, at)
        for s in travel
        if (at := local(carrier, *_seen_from(item, s, backwards))) is not None
    )
    depth = max(carrier.depth, other.depth if other else 0) + 0.2
    color = other.color if other else JOINT
    return Slide((_block(item, *place, unit, color, depth),), block, ends)  # type: ignore[arg-type]


def _cylinder(
    item: Item, groups: Groups, unit: float, a: int | None, b: int | None,
    travel: tuple[float, float],
) -> Slide:  # fmt: skip
    low, high = travel
    first, second = groups.all[a], groups.all[b]  # type: ignore[index]
    depth = float(max(first.depth, second.depth))
    case = _CASE * low
    inside = high - (1 - _INSIDE) * case
    x, y = _end(item)
    barrel = replace(
        item, shape="barrel", length=case, width=_BARREL * unit, color=first.color,
        height=depth + 0.2,
    )  # fmt: skip
    rod = replace(
        item, shape="rod", x=x, y=y, length=-inside, width=_ROD * unit, color=second.color,
        height=depth + 0.1,
    )  # fmt: skip
    return Slide((rod, barrel))


def _block(item: Item, x: Track, y: Track, unit: float, color: Color, depth: float) -> Item:
    length, width = _BLOCK
    return replace(
        item, shape="block", x=x, y=y, length=length * unit, width=width * unit, color=color,
        height=depth + 0.1,
    )  # fmt: skip


def _travel(item: Item) -> tuple[float, float]:
    """The shortest and the longest slide of the run."""
    return span([item.length]) or (0.0, 0.0)


def _end(item: Item) -> tuple[Track, Track]:
    return _along(item, item.length)


def _along(item: Item, s: Track) -> tuple[Track, Track]:
    """The point of the axis at a distance from frame_a."""
    return plain(item.x + np.cos(item.angle) * s), plain(item.y + np.sin(item.angle) * s)


def _seen_from(item: Item, s: float, backwards: bool) -> tuple[Track, Track]:
    """The place of the block at s: seen from frame_a, or backwards from frame_b."""
    return _along(item, item.length - s) if backwards else _along(item, s)


def _held_once(groups: Groups, number: int | None, unit: float) -> bool:
    """True for a group whose joints are at one point."""
    group = groups.all.get(number) if number is not None else None
    if group is None:
        return True
    places = np.array(group.joints or ((0.0, 0.0),))
    return bool(np.ptp(places, axis=0).max() <= unit)
