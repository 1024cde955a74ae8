"""Items as they are drawn: sizes, colours and order by the mechanism.

In:   items as components ask for them; a `shape` may name a part (`link`, `mass`, `pin` ...)
Out:  items in drawing order

Every rigid group with a link or a mass is one plate; links lie above links by their distance
from the ground, pins above the links that they hold. What has a size keeps it; a size of 0 is
chosen, and so is a colour that nobody chose.

Example: crank.shape and crankBody.bar, both `link`, and crankBody.centre, a `mass`

    plate    crank, from hinge to hinge, blue, height 1
    mass     crankBody.centre, a small quartered circle
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from planarc.ir.insight import Track
from planarc.ir.mechanism import GROUND
from planarc.view.box import bounds
from planarc.view.item import Item, Kind
from planarc.view.linkage.groups import Groups, Place, local, reach
from planarc.view.linkage.hatches import hatches
from planarc.view.linkage.palette import BED, BODIES, JOINT, is_open
from planarc.view.linkage.palette import GROUND as STONE
from planarc.view.linkage.plates import plate
from planarc.view.linkage.slides import draw_slide

#: Sizes in units where a component gives none.
_SIZES = {
    "link": 1.0,
    "mass": 0.8,
    "pin": 0.62,
    "motor": 1.5,
    "ground": 2.3,
    "spring": 1.4,
    "damper": 1.2,
    "springDamper": 2.6,
    "gearwheel": 3.5,
    "wheel": 3.0,
    "barrel": 1.4,
    "rod": 0.5,
    "cylinder": 0.9,
    "box": 1.0,
    "beam": 1.0,
}
_PINS = ("pin", "motor")
_ELEMENTS = ("spring", "damper", "springDamper", "barrel", "rod")
#: The diameter of a body without extent, in units, and the thickness of a curve.
_LUMP, _CURVE = 2.0, 0.25
#: Heights: what stands in the ground, what is no link, force elements, arrows.
_FLOOR, _LOOSE, _FORCES, _ARROWS = -1.0, 0.5, 1e4, 1e5


def dress(items: Sequence[Item], groups: Groups | None) -> list[Item]:
    """The items as they are drawn."""
    return sorted(_Dresser(items, groups).items(), key=lambda item: item.height)


class _Dresser:
    def __init__(self, items: Sequence[Item], groups: Groups | None) -> None:
        self._raw, self._groups = items, groups
        size = _scale(items)
        self._unit = groups.unit(size) if groups is not None else size / 30
        self._parts: dict[int, list[Item]] = {}  # links and masses of each group
        self._points: dict[int, list[Place]] = {}
        self._bodies: set[int] = set()  # groups with a shape of their own: blocks, cams, wheels
        self._loose = 0

    def items(self) -> list[Item]:
        drawn = [new for item in self._raw for new in self._dressed(item)]
        return [*drawn, *self._plates(), *self._supports()]

    def _dressed(self, item: Item) -> Iterator[Item]:
        if item.kind in (Kind.ARROW, Kind.DOUBLE_ARROW):
            yield replace(item, width=item.width or 0.35 * self._unit, height=_ARROWS + item.height)
        elif item.kind is Kind.CURVE:
            yield from self._curve(item)
        elif item.kind is not Kind.SHAPE:
            yield replace(item, height=_ARROWS + item.height)
        elif item.shape == "link":
            yield from self._link(item)
        elif item.shape == "mass":
            yield from self._mass(item)
        elif item.shape == "slide":
            yield from self._slide(item)
        elif item.shape in _PINS:
            yield self._pin(item)
        elif item.shape == "ground":
            if not self._only_slides(item):
                yield self._sized(item, _FLOOR)
        else:
            yield self._solid(item)

    # Parts of groups

    def _link(self, item: Item) -> Iterator[Item]:
        number = self._number(item)
        if number is None or self._groups is None or number == GROUND:
            color = BODIES[(self._loose + (len(self._groups.all) if self._groups else 0)) % 7]
            self._loose += 1
            if number != GROUND:
                open_color = color if is_open(item.color) else item.color
                yield replace(self._sized(item, 1.0), color=open_color)
            return
        self._parts.setdefault(number, []).append(item)
        group = self._groups.all[number]
        for s in (0.0, item.length):
            x, y = item.x + np.cos(item.angle) * s, item.y + np.sin(item.angle) * s
            self._point(number, local(group, x, y))

    def _mass(self, item: Item) -> Iterator[Item]:
        """A small mark; under it, where a size is asked for, a disc."""
        number = self._number(item)
        height, color = _FORCES + 2.0, item.color
        if number is not None and self._groups is not None and number != GROUND:
            group = self._groups.all[number]
            self._parts.setdefault(number, []).append(item)
            place = local(group, item.x, item.y)
            self._point(number, place)
            height = group.depth + 0.4
            if place is not None:  # in the axes of its group, so that nothing new moves
                x, y, angle = group.x, group.y, group.angle
                item = replace(item, x=x, y=y, angle=angle, points=(place,))
            color = group.color if is_open(color) else color
        if not isinstance(item.width, (int, float)) or item.width:
            yield replace(item, shape="sphere", color=color, height=height - 0.1)
        mark = replace(item, width=0.0, color=JOINT)
        yield self._sized(mark, height)

    def _slide(self, item: Item) -> Iterator[Item]:
        slide = draw_slide(item, self._groups, self._unit)
        if slide.block is not None:
            self._bodies.add(slide.block)
        for number, place in slide.more:
            self._point(number, place)
        yield from slide.items

    def _point(self, number: int, place: Place | None) -> None:
        if place is not None:
            self._points.setdefault(number, []).append(place)

    def _plates(self) -> Iterator[Item]:
        for number, parts in self._parts.items():
            assert self._groups is not None
            group = self._groups.all[number]
            more = self._points.get(number, [])
            links = [p for p in parts if p.shape == "link"]
            widths = [float(np.max(p.width)) for p in links]
            chosen = next((p.color for p in parts if not is_open(p.color)), group.color)
            lump = reach((*group.points, *more)) < 0.05 * self._unit
            if lump and number in self._bodies:
                continue
            width = max(widths, default=0.0) or self._unit * (_LUMP if lump else 1.0)
            owners = tuple(dict.fromkeys(p.component.rpartition(".")[0] for p in parts))
            body = plate(group, more, width, chosen, owners)
            if number in self._bodies and reach(group.points) < self._unit:
                body = replace(body, height=body.height - 0.3)  # it only carries a mass farther out
            yield body

    # What is not part of a group

    def _solid(self, item: Item) -> Item:
        """A shape that a component chose itself, or the symbol of a force element."""
        number = self._number(item)
        if self._groups is not None and (item.shape in _ELEMENTS or self._spread(item, number)):
            over = 0.5 if item.shape == "barrel" else 0.0
            return self._sized(item, _FORCES + math.tanh(item.height) + over)
        depth = self._depth(number)
        above = 0.2
        if item.shape in ("wheel", "gearwheel") and number is not None:
            self._bodies.add(number)
            above = -0.2  # the arm that turns with it stays seen
        height = item.height if depth is None else depth + above + 0.1 * math.tanh(item.height)
        return self._colored(self._sized(item, height), number)

    def _curve(self, item: Item) -> Iterator[Item]:
        number = self._number(item)
        depth = self._depth(number)
        height = _FLOOR if depth is None or number == GROUND else depth - 0.2
        closed = item.shape != "line" and len(item.points) > 3 and _closed(item.points)
        thin = _CURVE * self._unit
        width = thin if isinstance(item.width, (int, float)) and not item.width else item.width
        drawn = replace(item, height=height, width=width, shape="cam" if closed else "")
        if number == GROUND and not closed and is_open(item.color):
            drawn = replace(drawn, color=STONE)
        elif closed and number is not None:
            self._bodies.add(number)
        if number == GROUND and not closed and self._groups is not None:
            yield hatches(drawn, tuple(self._groups.corners()), self._unit)
        yield self._colored(drawn, number)

    def _colored(self, item: Item, number: int | None) -> Item:
        if not is_open(item.color):
            return item
        if number == GROUND:
            return replace(item, color=BED)
        group = self._groups.all.get(number) if self._groups and number is not None else None
        return replace(item, color=group.color if group else BODIES[0])

    def _sized(self, item: Item, height: float) -> Item:
        if not isinstance(item.width, (int, float)) or item.width:
            return replace(item, height=height)
        width = _SIZES.get(item.shape, 1.0) * self._unit
        length = item.length
        if item.shape == "ground":
            length = width
        return replace(item, width=width, length=length, height=height)

    def _pin(self, item: Item) -> Item:
        """A pin just above the links that it holds together; no motor where nothing drives."""
        if self._groups is None:
            return self._sized(item, item.height)
        if item.component.rpartition(".")[0] in self._groups.passive:
            item = replace(item, shape="pin")
        return self._sized(item, self._groups.deepest(item.component, item.x, item.y) + 0.5)

    def _number(self, item: Item) -> int | None:
        if self._groups is None:
            return None
        number = self._groups.of(item.component)
        if number is not None:
            return number
        return self._groups.at(item.component, item.x, item.y, item.angle)

    def _depth(self, number: int | None) -> int | None:
        group = self._groups.all.get(number) if self._groups and number is not None else None
        return group.depth if group else None

    def _spread(self, item: Item, number: int | None) -> bool:
        """True for what reaches from group to group, but moves with none."""
        return number is None and bool(self._groups and self._groups.is_spread(item.component))

    # The ground

    def _supports(self) -> Iterator[Item]:
        """Bearings of pins and force elements in the ground, where no component draws one."""
        if self._groups is None:
            return
        shown = [(i.x, i.y) for i in self._raw if i.shape == "ground"]
        holding = {
            i.component.rpartition(".")[0] for i in self._raw if i.shape in (*_PINS, *_ELEMENTS)
        }
        for owner, x, y in self._groups.grounds():
            near = any(_near(x, y, a, b, self._unit) for a, b in shown)
            if owner in holding and not near:
                shown.append((x, y))
                size = _SIZES["ground"] * self._unit
                yield Item(owner, Kind.SHAPE, x, y, 0.0, size, size, STONE, _FLOOR, shape="ground")

    def _only_slides(self, item: Item) -> bool:
        """True for a ground symbol where nothing but slides begin, which have their guides."""
        if self._groups is None:
            return False
        slides = {i.component.rpartition(".")[0] for i in self._raw if i.shape == "slide"}
        here = {o for o, x, y in self._groups.grounds() if _near(x, y, item.x, item.y, self._unit)}
        return bool(here) and here <= slides


def _near(x: float, y: float, a: Track, b: Track, unit: float) -> bool:
    return all(bool(np.all(np.abs(np.subtract(p, q)) <= 1e-3 * unit)) for p, q in ((x, a), (y, b)))


def _closed(points: Sequence[Place]) -> bool:
    """True for a line that ends where it began."""
    (x, y), (a, b) = points[0], points[-1]
    return math.hypot(x - a, y - b) <= 1e-6 * max(reach(points), 1e-300)


def _scale(items: Sequence[Item]) -> float:
    """The larger side of the box around all that is drawn but arrows; 1 for a point."""
    box = bounds([i for i in items if i.kind not in (Kind.ARROW, Kind.DOUBLE_ARROW)])
    return (max(box[2] - box[0], box[3] - box[1]) if box is not None else 0.0) or 1.0
